"""A listener on the valves, and the graph as a process."""

from graph_fixtures import levers, lockstep_bag, start_graph, valves

__all__ = ["levers", "lockstep_bag", "start_graph", "valves"]
