"""The valve driver: deadband, gain, hysteresis and pressure drop compensated; deadband and gain adapted.

- `command_gate`: Whether a command reaches the valves.
- `load_estimate`: Which pressures are believed, and the loads and mean pressures by them.
- `valve_driver`: The step: load, adaptation, hold, inverse; dither against hysteresis.
- `valve_inverse`: From an actuator speed to a voltage: deadband, valve curve, pressure drop.
- `inlet_oil`: Behind a compensator: oil that must be pressed before the actuator moves.
- `load_feedback`: Behind a compensator: a valve that gives way to a load that rocks.
- `spool_model`: The spool's lag and slew limit, as the driver knows them.
- `valve_hold`: When a small command opens a valve.
- `valve_adaptation`: Deadband and gain learnt by recursive least squares.
- `valve_flow`: A valve's opening from measured motion and pressures, for the adaptation.
- `unlearnt_valves`: Which valves cannot be learnt, and why.
- `tracking_limit`: For the controller: the opening that each valve reaches; joints that cannot follow.
- `valve_driver_parameters`, `valve_driver_configuration`, `valve_driver_topics`: Settings, machine, topics.
"""
