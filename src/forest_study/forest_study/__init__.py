"""What happens when machine and control *meet*: closed loops, tracking, the thesis' studies, the demo.

In the order in which data passes:

- `closed_loop`: Machine, controller and driver in one loop without ROS, interpreted or compiled.
- `trial_measures`: How far a tip was from where it should be: four measures, of which none is told alone.
- `tracking`: The tip along a path, and how far it is from where it should be.
- `matrix`: What control reaches on plants that nobody knows exactly, the worst of many seeds.
- `faults`: Faults in every state of the crane: what must happen, and what happens at worst.
- `ablation`: What each constant and each mechanism of control is good for.
- `thesis`: The thesis's evaluation of its control schemes (chapter 5), run anew.
- `latency`: What late links cost.
- `log_work`: Logs from the ground to the bunk and back, by a simulated operator.
- `sweep`: Thousands of closed loops at once, from one file.
- `notebook`: The closed loop from a notebook: a machine, a loop, a trace of a run, its picture.
- `learning`: A Gymnasium environment of the closed loop, and what our controller reaches in it.
- `logs`: The log-moving benchmark: what tip control brings, over persons, with intervals.
- `tune`: Gains for a machine file, searched for on the matrix' plants and judged on others.
- `stability`: How far the position loops are from instability: Bode plots and margins.
- `delay_node`: A bad link as a node: what it hears on `topic_in` it says on `topic_out`, later, jittered,
  or not at all.
- `experiments`: The experiments of `forest_ident` in a graph, in lockstep or live.
- `demo`: The demo, its summary, the reference bags, replays.
- `journal`: Runs on disk as they are made, so that a command that was stopped goes on.
- `results`: Where a study leaves its results: a directory of its own, in which nothing is overwritten.
- `parameter_reference`: The parameters of all nodes as a page, from the tables that the nodes declare.
- `cli`: `forest-study`: studies of machine and control together, from the command line.

May import: all others.
"""
