"""The valve's inverse: from an actuator speed to the voltage at which the spool shall stand.

Symbols and units: `valve_driver`.
"""

import math

from forest_control.valve.valve_driver_parameters import AxisDriver, Parameters
from forest_description.components.valve_characteristic import ValveLaw, voltage_for_opening

LEAST_PART = 0.1  # [1] of a port's usual root of the pressure drop, taken to remain; chosen


def spool_voltage(
    fed: float, load: float, mean: float, supply: float, axis: AxisDriver, law: ValveLaw, p: Parameters
) -> float:
    """Return the voltage [V] for a command [V] of the ideal valve; beyond the rated one, if it does not do.

    Args:
        fed: command, with what leaks.
        load: low-passed [N; N m].
        mean: of both ports' pressures [Pa] of a motor, see `_filling_factor`; negative: not known.
        supply: pressure [Pa].
        axis: what is known of the actuator.
        law: the valve, as known by now.
        p: what is known of the machine.
    """
    speed = axis.rated_speed * fed / axis.valve.forward.rated_voltage
    opening = required_opening(speed, load, supply, axis, p)
    if mean >= 0.0 and axis.metering_drop == math.inf:
        opening *= _filling_factor(math.copysign(1.0, speed) * load, mean, supply, axis)
    return voltage_for_opening(opening, law)


def required_opening(speed: float, load: float, supply: float, axis: AxisDriver, p: Parameters) -> float:
    """Return the opening -1..1 for an actuator speed [m/s; rad/s] against a load [N; N m].

    A compensator's valve is opened for the flow at its inlet alone. Thesis eq. 3.1, 3.14.
    """
    inlet = axis.displacement_1 if speed > 0.0 else axis.displacement_2
    way = axis.valve.forward if speed > 0.0 else axis.valve.backward
    if axis.metering_drop < math.inf:
        edge = way.resistance_1 if speed > 0.0 else way.resistance_2
        return max(-1.0, min(1.0, speed * inlet * math.sqrt(edge / axis.metering_drop)))
    nominal = inlet * supply
    opposing = load if speed > 0.0 else -load
    hoses = (axis.hose_linear + axis.hose_square * abs(speed)) * abs(speed)
    drive = max(p.minimum_drop * inlet * p.supply_pressure, nominal - opposing - hoses)
    orifices = way.resistance_1 * axis.displacement_1**3 + way.resistance_2 * axis.displacement_2**3
    return max(-1.0, min(1.0, speed * math.sqrt(orifices / drive)))


def _filling_factor(opposing: float, mean: float, supply: float, axis: AxisDriver) -> float:
    """Return how much further a motor's valve must open while its hoses are not at their usual pressure.

    The mean of inlet and outlet flow moves the load, and goes with sqrt(P_s - P_in) + sqrt(P_out).
    Both roots are equal when the ports' mean pressure is half the supply's; after a rest it is
    less.
    """
    half = 0.5 * opposing / axis.displacement_1
    usual = max(LEAST_PART * supply, 0.5 * supply - half)
    floor = LEAST_PART * LEAST_PART * usual
    inlet, outlet = max(floor, supply - mean - half), max(floor, mean - half)
    return 2.0 * math.sqrt(usual) / (math.sqrt(inlet) + math.sqrt(outlet))
