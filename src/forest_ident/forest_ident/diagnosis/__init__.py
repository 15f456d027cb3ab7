"""Is the machine still what it was? Faults found from the topics of everyday work.

In the order in which data passes:

- `monitor_readings`: What is read in one sample; NaN for what is not there.
- `residual_parameters`: The machine file's numbers, as the residuals need them.
- `residuals`: What the machine does beside what its file says: `axis_residuals` of swing, boom and
  stick, `machine_residuals` of supply and sensors.
- `sensor_watch`: Each sensor by itself: missing, frozen.
- `sequential_test`, `residual_limits`: Has a residual moved, and what a healthy machine may do.
- `monitor`: All of it in one step.
- `signatures`, `findings`: Which cause a pattern means, what it may be confused with, what to do.
- `monitor_parameters`: What a user may set of the node.
- `recorded_readings`: A bag as the monitor would have read it.
"""
