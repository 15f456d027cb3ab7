"""The parameters of the thesis' circuits (`actuation_graphs`) for a machine, by name."""

from forest_description.machine import Machine
from forest_description.types import AXES


def actuation_parameters(
    machine: Machine, axis: str, to_port_1: float, from_port_2: float
) -> dict[str, float]:
    """Return the parameters of `swing` or `cylinder` for an axis of a machine, SI.

    Args:
        machine: whose hoses, motor and pistons the circuit has.
        axis: swing, boom or stick.
        to_port_1: C_R, the orifice from the supply to port 1 [Pa s^2/m^6].
        from_port_2: C_R', the orifice from port 2 to the tank [Pa s^2/m^6].
    """
    place = AXES.index(axis)
    values = {"C_R": to_port_1, "C_R'": from_port_2}
    for port in (1, 2):
        line = machine.line(place, port)
        values |= {f"R_{port}": line.resistance, f"I_{port}": line.inertance, f"C_{port}": line.capacitance}
    if place == 0:
        drive = machine.swing
        values |= {"D_m": drive.motor_displacement, "N": drive.gear_ratio, "B_sw": drive.damping}
        leak = drive.external_leakage_resistance
        return values | {"R_in": drive.internal_leakage_resistance, "R_e1": leak, "R_e2": leak}
    piston = (machine.boom, machine.stick)[place - 1]
    return values | {"gy_1": piston.head_area, "gy_2": piston.rod_area, "B": piston.damping}
