"""The monitor over hundreds of simulated hours: false alarms, detection, what is told apart.

In the order in which data passes:

- `faults`: What is broken, how much, and which findings name it.
- `population`: Healthy machines and their work.
- `monitored_loop`: The closed loop with the monitor beside it, as machine code.
- `diagnosis_trial`, `detection_figures`: One run, and what it came to: the kind `diagnosis` of
  `forest-study sweep`.
- `diagnosis_report`, `diagnosis_command`: Table and ROC pictures of such sweeps: `forest-study diagnosis`.

May import: `tracking`, `closed_loop`, `results`.
"""
