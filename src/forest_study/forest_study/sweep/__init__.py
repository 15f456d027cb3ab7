"""Thousands of closed loops at once: machines, schemes, paths, parameters and seeds from one file.

In the order in which data passes:

- `trials`: What one run is, and which figures it has.
- `changes`: A machine, and settings, with numbers of their own by dotted key.
- `study`: The file of a study, read and checked before anything runs.
- `design`: Its cases: lists as a grid, ranges sampled.
- `workers`: The cases on all cores, or on a Dask cluster; a worker that dies loses nothing.
- `store`: The figures as Parquet, with what made them; a study that was stopped goes on.
- `shares`: How much of a figure's variance each factor makes.
- `summary`: Table and picture.
- `sweep_command`: `forest-study sweep`.

May import: `tracking`, `closed_loop`, `latency`, `log_work`, `results`.
"""
