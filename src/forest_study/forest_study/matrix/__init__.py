"""The matrix: what control reaches on plants that nobody knows exactly, the worst of many seeds.

- `matrix_rows`: The rows: what is driven, on which plants, and what is aimed at.
- `rivals`: Control laws that it compares.
- `matrix_runs`: Every seed's plant, sensors and joystick in every row, over all cores.
- `figures`, `load_change`: What a run is judged by; a log that is grasped and dropped.
- `matrix_report`: The table, and the picture of how the seeds spread.
- `matrix_command`: `forest-study matrix`.
"""
