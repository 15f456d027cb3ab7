"""How a lever becomes *voltage*: joystick, limits, schemes, valve driver; their nodes.

In the order in which data passes:

- `operator`: The operator's side: input devices, levers and their sources, stick curves, the watch over
  the joystick.
- `limits`: What bounds a motion: joints, flow, actuator speeds, load, walls, singular poses.
- `servo`: The schemes' loops: from a tip velocity to joint rates, closed on the tip's position.
- `valve`: The valve driver: deadband, gain and pressure drop compensated and adapted.
- `config`: What a user sets: parameters with units and ranges, profiles, workspaces, joysticks,
  live changes.
- `safety`: Whether the crane may move: what stops it, and why.
- `pipeline`: The guarded controller: its step from levers to commands of ideal valves.
- `taught`: Taught work: poses and paths that are repeated, under the same guard.
- `compiled`: The controller's and the valve driver's step as machine code, for their nodes.
- `cli`: `forest-control` from the command line.
- `joystick_node`: A joystick on /joy: the device under a hand, the thesis' test input, recorded
  levers, or a bag's joystick.
- `controller_node`: The controller as a node: /joy and /joint_states in, /valve_commands and the tip's
  motion out.
- `cycle_node`: Taught work as a node: the tip's pose in, a piece of path on tip/taught_command out.
- `twist_node`: A program's tip velocity as a node: TwistStamped on delta_twist_cmds in, taught commands out.
- `valve_driver_node`: The valve driver as a node: /valve_commands of ideal valves in, /valve_voltages of
  the real ones out.

May import: `forest_msgs_py`, `forest_bag`, `forest_description`, `forest_compile`.
"""
