"""How levers become commands: the controller's step, and the guard before it.

In the order in which data passes:

- `controller_topics`: The node's inputs from topics and its outputs to topics.
- `valve_feedback`: What the valve driver reports.
- `guarded_controller`: Asks `safety` whether the crane may move, then steps the controller.
- `control_state`: What the stages hand on.
- `controller`: One step: estimate, command, limit, servo, output.
- `motion_command`: What the levers ask for, or the stop without them.
- `stop_profile`: The stop along the path.
- `bumpless_transfer`: Changes while the crane moves, without a bump.
- `motion_limits`: What walls, machine and valves leave of it.
- `joint_servo`: Which joint rates follow what is left.

May import: `safety`, `config`, `servo`, `limits`, `valve`, `operator`.
"""
