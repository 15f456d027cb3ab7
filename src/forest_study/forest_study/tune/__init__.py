"""The gains of a machine file, searched for on the matrix' plants and judged on others.

- `gains`: What is searched: numbers, the controller's settings of them, the profile.
- `robustness`: How far the joints' loops are from instability with them.
- `bench`: Runs of the matrix by gains, each done once and kept.
- `search`: The optimiser.
- `tune_report`: What was gained on plants that the search has not seen.
- `tune_command`: `forest-study tune`.

May import: `logs`, `matrix`, `stability`, `results`.
"""
