"""The valve's inverse: from an actuator speed to the voltage at which the spool shall stand.

Symbols and units: `valve_driver`.
"""

import math
from typing import NamedTuple

from forest_control.valve.inlet_oil import lacking_oil, shut_share
from forest_control.valve.valve_driver_parameters import AxisDriver, Parameters
from forest_description.hydraulics.valve_characteristic import ValveLaw, voltage_for_opening

LEAST_DROP = 0.03  # [1] of the pump's pressure, taken to remain over an edge to it; chosen
LEAST_PART = 0.1  # [1] of a port's usual root of the pressure drop, taken to remain; chosen
PASSES = 0.5  # [1] of the metering drop, from which oil comes back through the outlet's edge; chosen
PRESSING = 0.1  # [s] in which an empty port's air is pressed; chosen


class OilState(NamedTuple):
    """Pressures of an axis, as the driver knows them [Pa] but for the loads [N; N m]."""

    load: float  # low-passed
    rocking: float  # load now, less that
    mean: float  # of both ports, see `_filling_factor`; negative: not known
    supply: float
    tank: float  # of the tank line
    outlet: float = 0.0  # at the valve, where the oil comes back; NaN: not measured


def spool_voltage(
    fed: float, oil: OilState, position: float, axis: AxisDriver, law: ValveLaw, p: Parameters
) -> float:
    """Return the voltage [V] for a command [V] of the ideal valve; beyond the rated one, if it does not do.

    Args:
        fed: command, with what leaks.
        oil: what is measured of the axis.
        position: of the actuator [m; rad]; NaN: not known.
        axis: what is known of the actuator.
        law: the valve, as known by now.
        p: what is known of the machine.
    """
    speed = axis.rated_speed * fed / axis.valve.forward.rated_voltage
    x, fills = position if math.isfinite(position) else axis.middle, oil.mean >= 0.0
    if axis.metering_drop < math.inf:
        speed = _with_pressing(speed, oil, x, axis) if fills else speed
    elif fills and (axis.throttled_2 if speed > 0.0 else axis.throttled_1):
        return voltage_for_opening(_inlet_opening(speed, oil, axis, p), law)
    opening = required_opening(speed, oil.load, oil.supply, oil.tank, axis, p)
    if fills and axis.metering_drop == math.inf:
        opening *= _filling_factor(speed > 0.0, oil.load, oil.mean, oil.supply, oil.tank, x, axis)
    return voltage_for_opening(opening, law)


def required_opening(
    speed: float, load: float, supply: float, tank: float, axis: AxisDriver, p: Parameters
) -> float:
    """Return the opening -1..1 for an actuator speed [m/s; rad/s] against a load [N; N m].

    A compensator's valve is opened for the flow at its inlet alone. Thesis eq. 3.1, 3.14.
    """
    inlet = axis.displacement_1 if speed > 0.0 else axis.displacement_2
    outlet = axis.displacement_2 if speed > 0.0 else axis.displacement_1
    way = axis.valve.forward if speed > 0.0 else axis.valve.backward
    if axis.metering_drop < math.inf:
        return _metered_opening(speed, axis.metering_drop, axis)
    nominal = inlet * supply
    opposing = load if speed > 0.0 else -load
    square = axis.ahead_square if speed > 0.0 else axis.back_square
    beyond = (axis.hose_linear + square * abs(speed)) * abs(speed) + outlet * tank
    drive = max(p.minimum_drop * inlet * p.supply_pressure, nominal - opposing - beyond)
    orifices = way.resistance_1 * axis.displacement_1**3 + way.resistance_2 * axis.displacement_2**3
    return max(-1.0, min(1.0, speed * math.sqrt(orifices / drive)))


def _with_pressing(speed: float, oil: OilState, x: float, axis: AxisDriver) -> float:
    """Return the speed [m/s; rad/s] whose flow moves an actuator at a speed, and presses its oil.

    See `inlet_oil`. Air counts at the higher of inlet and mean: an actuator that brakes empties its
    inlet, and is not fed. A holding valve counts as shut only while nothing comes back through the valve: a
    dead transducer must not make an actuator faster.
    """
    a_1, a_2 = axis.displacement_1, axis.displacement_2
    half = 0.5 * (oil.load + oil.rocking) / a_1
    port_1, port_2 = oil.mean + half, (oil.mean - half) * a_1 / a_2
    c_1 = axis.oil_1.fixed + axis.oil_1.growing * x
    c_2 = axis.oil_2.fixed + axis.oil_2.growing * x
    spring_1, spring_2 = a_1 * a_1 / c_1, a_2 * a_2 / c_2
    held = 1.0 if oil.outlet < PASSES * axis.metering_drop else 0.0
    if speed > 0.0:
        trapped = held * spring_2 / spring_1 * shut_share(port_1, port_2, axis.holding_2)
        return speed * (1.0 + trapped) + c_1 * lacking_oil(max(port_1, oil.mean), axis.air) / (a_1 * PRESSING)
    trapped = held * spring_1 / spring_2 * shut_share(port_2, port_1, axis.holding_1)
    return speed * (1.0 + trapped) - c_2 * lacking_oil(max(port_2, oil.mean), axis.air) / (a_2 * PRESSING)


def _metered_opening(speed: float, drop: float, axis: AxisDriver) -> float:
    """Return the opening -1..1 at which the inlet's edge passes a speed's oil at a drop [Pa] over it."""
    forward = speed > 0.0
    inlet = axis.displacement_1 if forward else axis.displacement_2
    edge = axis.valve.forward.resistance_1 if forward else axis.valve.backward.resistance_2
    return max(-1.0, min(1.0, speed * inlet * math.sqrt(edge / drop)))


def _inlet_opening(speed: float, oil: OilState, axis: AxisDriver, p: Parameters) -> float:
    """Return the opening -1..1 where a counterbalance valve throttles what comes out; see `_filling_factor`.

    It opens as its pilot, the inlet's pressure, lets it: the outlet's edge has what it leaves. So the inlet's
    edge alone sets the speed, and its drop is what is measured.
    """
    half = 0.5 * oil.load / axis.displacement_1
    inlet = oil.mean + half if speed > 0.0 else (oil.mean - half) * axis.displacement_1 / axis.displacement_2
    return _metered_opening(speed, max(LEAST_DROP * p.supply_pressure, oil.supply - inlet), axis)


def _filling_factor(
    forward: bool, load: float, mean: float, supply: float, tank: float, x: float, axis: AxisDriver
) -> float:
    """Return how much further a valve must open while its oil is not at its usual pressure.

    The piston hangs between two springs of oil, A^2/C. Each edge's flow moves the far end of one,
    so the load follows the mean of both, weighted by the springs. Both edges agree at the pressures
    of steady motion; after a rest, and while the oil is being pressed, they do not.

    Args:
        forward: whether port 1 is the inlet.
        load: F, low-passed slowly [N; N m]: a load that swings must not move the valve.
        mean: (P_1 + P_2 A_2/A_1)/2, low-passed quickly [Pa].
        supply: [Pa].
        tank: pressure of the tank line [Pa].
        x: actuator position [m; rad].
        axis: what is known of the actuator.
    """
    a_1, a_2 = axis.displacement_1, axis.displacement_2
    spring_1 = a_1 * a_1 / (axis.oil_1.fixed + axis.oil_1.growing * x)
    spring_2 = a_2 * a_2 / (axis.oil_2.fixed + axis.oil_2.growing * x)
    way = axis.valve.forward if forward else axis.valve.backward
    s_1, s_2 = way.resistance_1 * a_1 * a_1 * a_1, way.resistance_2 * a_2 * a_2 * a_2
    # P_1 = m + h and P_2 = (m - h) A_1/A_2; `half`, h, is counted against the motion.
    half, ratio_in, ratio_out = 0.5 * load / a_1, 1.0, a_1 / a_2
    weight_in, share_in, area = spring_1 / (spring_1 + spring_2), s_1 / (s_1 + s_2), a_1 / a_2
    if not forward:
        half, ratio_in, ratio_out = -half, a_1 / a_2, 1.0
        weight_in, share_in, area = spring_2 / (spring_1 + spring_2), s_2 / (s_1 + s_2), a_2 / a_1
    left = max(LEAST_PART * supply, 0.5 * supply - ratio_in * half - 0.5 * tank / area)
    usual_in, usual_out = 2.0 * share_in * left, 2.0 * (1.0 - share_in) * area * left
    inlet = max(LEAST_PART * LEAST_PART * usual_in, supply - ratio_in * mean - ratio_in * half)
    outlet = max(LEAST_PART * LEAST_PART * usual_out, ratio_out * (mean - half) - tank)
    of_outlet = (1.0 - weight_in) * math.sqrt(usual_in / usual_out) * math.sqrt(outlet)
    return math.sqrt(usual_in) / (weight_in * math.sqrt(inlet) + of_outlet)
