"""Laws of supply and tank line, valves, ports, hoses and actuators.

From the voltage to the actuator:

- `command_history`: Dead time of the valves' electronics.
- `spool_dynamics`: From voltage to spool position: lag, slew limit, hysteresis; `flow_force` pushes it back.
- `port`: Flow through the two edges of the spool at a port, with leakage and load check.
- `compensator`: A pressure compensator before the spool.
- `hydraulic_line`: The hose, with its relief and anti-cavitation valves.
- `load_holding`: Counterbalance and other valves at the actuator.
- `oil_law`, `oil_volume`: Compressible oil with air; the volume between hose and piston.
- `actuator`: Cylinder and motor: flow and force.
- `side`: Port, hose and chamber of one side of an axis together.
- `supply`, `pump_drive`, `tank_line`: The manifold with its pumps, what drives these, the return.

The law from spool position to orifice resistance is `forest_description.hydraulics.valve_characteristic`.
"""
