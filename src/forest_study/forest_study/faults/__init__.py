"""Faults in every state that they can meet: what was done, what must happen, what happened at worst.

- `fault`: What a fault, a state and a bound are.
- `wires`: What a fault makes of what passes between joystick, machine, controller, driver and valves.
- `catalogue`: The one table of faults, each with its states, its bound and the reason.
- `faulty_loop`: The closed loop of the real cores, with a fault in one of its wires.
- `scenes`: The crane in each state: standing, in motion, at a limit, in taught work, in an experiment.
- `trials`: Every fault in every state, seed by seed, and what is measured.
- `fault_report`: The table, and the worst of it.
- `faults_command`: `forest-study faults`.
"""
