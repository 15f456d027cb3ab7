"""The log-moving benchmark: what tip control brings, over persons, with intervals.

- `statistics`: Means and paired differences, with their intervals.
- `tables`: The runs as tables.
- `logs_command`: `forest-study logs`.

May import: `sweep`, `log_work`, `results`.
"""
