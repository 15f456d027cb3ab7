"""A node's time: the system's clock live, the graph's steps in lockstep."""
