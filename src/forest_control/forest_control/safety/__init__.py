"""Whether the crane may move.

- `motion_guard`: Remembers for one controller, and tells the causes in sentences.
- `motion_permission`: Decides: move, hold, stop, and why. All causes stand in its table.
- `state_checks`: Whether a measured state can be true.
- `frozen_sensor`: Whether a sensor stands still while its joint is told to move.
- `machine_file_check`: Whether the machine is the one that its file tells of.
- `machine_answers`: How fast its joints first go, and whether the boom carries its own weight.
- `overloaded_joint`: Whether a load drives a joint back although its valve is open.
- `runaway`: Whether a joint goes by itself although its valve is shut.
- `driver_response`: Whether the valve driver is there, and obeys.

The joystick is watched in `operator.joystick_watch`. May import: `config`, `operator`,
`servo`, `limits`.
"""
