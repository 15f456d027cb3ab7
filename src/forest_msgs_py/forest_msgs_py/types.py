"""Time on the wire."""

NS_PER_S = 1_000_000_000
PERIOD = 0.005  # [s] between two states of the machine, unless a node is told otherwise
WATCHDOG_PERIOD = 0.02  # [s] between two looks for inputs that stay away: a fifth of the shortest timeout
