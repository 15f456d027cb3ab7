"""What follows from the equations: modes, checks of a machine file, comparisons, plots."""
