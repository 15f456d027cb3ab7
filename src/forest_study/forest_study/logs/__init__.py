"""The log-moving benchmark: what tip control brings, over persons, with intervals.

- `statistics`: Means and paired differences, with their intervals.
- `tables`: The runs as tables.
- `logs_report`: The page for people: what tip control would bring a crane.
- `recorded_logs`: A person's run, from a bag.
- `logs_command`: `forest-study logs`.

May import: `sweep`, `log_work`, `results`.
"""
