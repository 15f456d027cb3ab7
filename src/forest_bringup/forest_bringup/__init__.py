"""What *starts*, watches and stops a graph of nodes.

Its modules:

- `supervisor`: Starts the nodes' processes, watches them, and ends them together.
- `graph_monitor`: The supervisor's own node: sees who is in the graph, and publishes zero voltage.
- `graph_lock`: One graph per ROS domain and namespace.
- `graph`: The live graph of `scripts/graph.sh`; `graph_command` runs it until Ctrl-C.
- `lockstep_run`: A run in lockstep, for a number of steps, into a bag.
- `launch_description`: The same nodes for ROS's own launch.
- `profile_choice`: Which operator profile belongs to a joystick source.
- `process_priority`: Precedence of live nodes over other programs.
- `terminal`: Questions to the person at the terminal.

May import: `forest_ident`, `forest_control`, `forest_sim`, `forest_bag`, `forest_msgs_py`,
`forest_description`.
"""
