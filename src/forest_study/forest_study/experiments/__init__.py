"""The experiments of `forest_ident` in a graph, in lockstep or live."""
