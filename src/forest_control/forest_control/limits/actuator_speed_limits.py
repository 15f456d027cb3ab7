"""Actuator speed limits: how fast the valves can move the joints at a pose, against the crane's weight.

| symbol | name | unit |
|---|---|---|
| G | torque of gravity on boom, stick | N m |
| F | load of a cylinder, G over its lever arm; positive against extending | N |
| N | force left for valve and hoses: A_in P_s - sgn(v) F | N |
| S, S_h | resistance of the open valve, of what lies beyond, at the actuator; h its linear part | N s^2/m^2 |

The greatest speed solves (S + S_h) v^2 + h v = N.
"""

import math
from typing import NamedTuple

from forest_control.valve.tracking_limit import OpeningRatio
from forest_control.valve.valve_driver_parameters import AxisDriver
from forest_description.derived.actuator_kinematics import Linkages
from forest_description.derived.bodies import bearing_stick, boom_body
from forest_description.geometry.linkage import lever_arm
from forest_description.hydraulics.pump import LoadSensingPump, Pump
from forest_description.machine import Machine
from forest_description.types import Vec3

RESERVE = 0.85  # [1] of the greatest speed: feedback and another load than expected need the rest; chosen
LEAST_SHARE = 0.1  # [1] of the unloaded force, taken to remain under any load: as the driver's minimum_drop


class SpeedLimitParameters(NamedTuple):
    """What the greatest speeds depend on."""

    axes: tuple[AxisDriver, AxisDriver, AxisDriver]
    supply_pressure: float  # [Pa]
    idle_pressure: float  # [Pa], the least that the pump keeps
    flow_limit: float  # [m^3/s] of the pumps
    boom_length: float  # [m]
    boom_moment: tuple[float, float]  # g m (x, y) of its centre of mass [N m]
    stick_moment: tuple[float, float]  # alike, with what it carries
    stick_weight: float  # [N]
    linkages: Linkages
    build_up: float  # [s] in which the pump comes from idle to its highest pressure, see `build_up_time`


def gravity_torques(q: Vec3, c: SpeedLimitParameters) -> tuple[float, float]:
    """Return G of boom and stick [N m] on a level platform. Thesis eq. 3.15."""
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    stick = c.stick_moment[0] * c_23 - c.stick_moment[1] * s_23
    boom = c.boom_moment[0] * c_2 - c.boom_moment[1] * s_2
    return boom + c.stick_weight * c.boom_length * c_2 + stick, stick


def joint_rate_limits(q: Vec3, rates: Vec3, c: SpeedLimitParameters, opening_ratio: OpeningRatio) -> Vec3:
    """Return the joint rates [rad/s], not negative, that the valves can give in the commanded directions.

    Args:
        q: joint angles [rad].
        rates: commanded joint rates [rad/s]; their signs count.
        c: what the speeds depend on.
        opening_ratio: of the valves.
    """
    boom_load, stick_load = gravity_torques(q, c)
    boom, stick = lever_arm(q[1], c.linkages[0]), lever_arm(q[2], c.linkages[1])
    return (
        _greatest_rate(0, rates[0], 1.0, 0.0, c, opening_ratio),
        _greatest_rate(1, rates[1], boom, boom_load, c, opening_ratio),
        _greatest_rate(2, rates[2], stick, stick_load, c, opening_ratio),
    )


def _greatest_rate(
    i: int, rate: float, arm: float, torque: float, c: SpeedLimitParameters, opening_ratio: OpeningRatio
) -> float:
    """Return one joint's greatest rate [rad/s] in its commanded direction, against a torque [N m]."""
    direction = math.copysign(1.0, arm * rate)
    ratio = opening_ratio.forward[i] if direction > 0.0 else opening_ratio.backward[i]
    return RESERVE * _greatest_speed(direction, torque / arm, ratio, c.axes[i], c) / abs(arm)


def _greatest_speed(
    direction: float, load: float, ratio: float, axis: AxisDriver, c: SpeedLimitParameters
) -> float:
    """Return one actuator's speed [m/s; rad/s] at an opening ratio: S goes with 1/ratio^2."""
    extends = direction > 0.0
    inlet = axis.displacement_1 if extends else axis.displacement_2
    way = axis.valve.forward if extends else axis.valve.backward
    valve = way.resistance_1 * axis.displacement_1**3 + way.resistance_2 * axis.displacement_2**3
    beyond, linear = axis.ahead_square if extends else axis.back_square, axis.hose_linear
    square = valve / (ratio * ratio) + beyond
    force = max(LEAST_SHARE * inlet * c.supply_pressure, inlet * c.supply_pressure - direction * load)
    speed = (math.sqrt(linear * linear + 4.0 * square * force) - linear) / (2.0 * square)
    if axis.metering_drop < math.inf:
        edge = way.resistance_1 if extends else way.resistance_2
        speed = min(speed, ratio * math.sqrt(axis.metering_drop / edge) / inlet)
    return min(speed, c.flow_limit / inlet)


def speed_limit_parameters(
    machine: Machine, axes: tuple[AxisDriver, AxisDriver, AxisDriver]
) -> SpeedLimitParameters:
    """Return the constants for a machine and its valve driver's axes."""
    m = machine.manipulator
    boom, stick = boom_body(m), bearing_stick(m)
    return SpeedLimitParameters(
        axes=axes,
        supply_pressure=machine.pump.supply_pressure,
        idle_pressure=machine.pump.idle_pressure,
        flow_limit=machine.pump.flow_limit,
        boom_length=m.boom_length,
        boom_moment=(m.gravity * boom.mass * boom.x, m.gravity * boom.mass * boom.y),
        stick_moment=(m.gravity * stick.mass * stick.x, m.gravity * stick.mass * stick.y),
        stick_weight=m.gravity * stick.mass,
        linkages=machine.linkages,
        build_up=build_up_time(machine.pump),
    )


def build_up_time(pump: Pump) -> float:
    """Return the time [s] in which a pump comes from idle to its highest pressure, under a load of that.

    What opens a valve lets a load-sensing pump see its own pressure there, until it reaches the load. So it
    rises by its margin in its response time, at an even rate.
    """
    if not isinstance(pump, LoadSensingPump):
        return 0.0
    return pump.response_time * (pump.supply_pressure - pump.margin) / pump.margin
