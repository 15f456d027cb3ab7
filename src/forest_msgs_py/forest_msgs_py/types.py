"""Time on the wire."""

NS_PER_S = 1_000_000_000
PERIOD_NS = 5_000_000  # [ns] between two states of the machine, unless a node is told otherwise
PERIOD = 0.005  # [s] the same
WATCHDOG_PERIOD = 0.02  # [s] between two looks for inputs that stay away: a fifth of the shortest timeout
