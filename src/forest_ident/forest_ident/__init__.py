"""System identification from *records*: experiments, estimators, refinement through the simulator, reports.

In the order in which data passes:

- `experiments`: The experiments: what a person prepares, what is driven, how far.
- `measurements`: A record for the estimators: readings on one time base, derivatives, masks of rows.
- `driving`: An experiment carried out on a simulated machine or on a running graph, within its bounds.
- `experiment_operator_node`: The scripted operator as a node: an experiment's voltages on /valve_commands,
  on the simulator or on a real crane.
- `output_error`: Fit the simulator's readings to the recorded ones.
- `estimators`: The thesis's estimators (chapter 4), one parameter or a few at a time.
- `refinement`: All experiments together: from sessions to a machine, with intervals.
- `validation`: A model against a record that it was not fitted to.
- `model_choice`: Physics that the model lacks: named from residuals, fitted when allowed, judged by held-out
  records.
- `everyday`: What everyday work tells without experiments: has the machine drifted?
- `report`: The results as a page, plots and a machine file.
- `diagnosis`: Is the machine still what it was? Faults found from the topics of everyday work.
- `monitor_node`: Self-diagnosis as a node: what is wrong with the machine, on /diagnostics.
- `online`: Running estimates while the machine works.
- `online_node`: On-line identification as a node: running estimates of overlap, gain and damping beside the
  off-line fit.
- `actuator`: One actuator of any scale, fitted to a CSV record.
- `cli`: `forest-ident`: a module for each verb.

May import: `forest_sim`, `forest_bag`, `forest_msgs_py`, `forest_description`, `forest_compile`.
"""
