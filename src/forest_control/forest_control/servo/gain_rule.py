"""The gains of the coordinated scheme from the machine's file: as much as the oil's spring bears.

A joint hangs on the oil of its hoses and chambers, a spring with a mass. What its valve lets pass damps it.
The rule takes the greatest K_p up to `HIGHEST_GAIN` whose loop stays away from -1 by 1/`AMPLIFICATION` in
every stated motion. K_i goes with its square.

| symbol | name | unit |
|---|---|---|
| s | complex frequency | 1/s |
| A, C, G | area times lever arm; capacitance; conductance of the valve's edge, Q/(2 dp): of either side | |
| Z | torque of the oil per joint rate, the sum of A^2/(C s + G) | N m s/rad |
| M, B | inertia, and viscous damping | kg m^2, N m s/rad |
| H | joint rate over commanded rate, Z/(M s + B + Z); boom and stick as a pair, one valve shut | 1 |
| S, T | spool over voltage; lateness: a period and a half, and the valve's dead time | 1, s |
| L | open loop, (K_p + K_i/s + D s) S H e^(-T s)/s | 1 |

Left out: dry friction and load feedback, which damp; bending; the sway of what hangs; load-holding valves;
air in the oil.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from forest_control.servo.arm_feedforward import arm_inertia, arm_model
from forest_control.servo.schemes import ERROR_LAG, FULL_RATE
from forest_control.servo.swing_feedforward import inertia, swing_model
from forest_control.valve.valve_driver_parameters import AxisDriver, axis_drivers
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import cylinder_length, lever_arm
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.machine import Machine
from forest_description.types import Complexes, Floats, Vec3
from forest_msgs_py.types import PERIOD

HIGHEST_GAIN = (4.0, 5.0, 5.0)  # [1/s] of K_p: the noise of a slow swing, unfiltered, crosses its overlap
STEP = 0.25  # [1/s] in which K_p is looked for, and the least: a twentieth of the highest
AMPLIFICATION = 1.8  # [1] greatest |1/(1 + L)|: at least 7 dB and 32 degrees, under the usual 2
INTEGRAL_SHARE = (0.08, 0.25, 0.25)  # [1] K_i over K_p^2: at a quarter slow poles meet; the swing lags more
SWING_DAMPING = 0.4  # [1] D where the swing bears it: only the swing rocks slowly
PLACES = 0.2, 0.5, 0.8  # [1] of the ranges of boom and stick: nine poses, away from the strokes' ends
TIP_SPEEDS = 0.25, 0.5  # [m/s] of the tip by one joint alone: half and all of what a lever asks by default
FREQUENCY: Floats = np.geomspace(0.05, 30.0, 400)  # [Hz] from under the crossovers to over the spools


class JointGains(NamedTuple):
    """Per joint: swing, boom, stick."""

    feedback: Vec3  # K_p [1/s]
    integral: Vec3  # K_i [1/s^2]
    rate: Vec3  # D


@lru_cache(maxsize=16)  # a node that runs asks again whenever a parameter is set
def gains_by_rule(machine: Machine) -> JointGains:
    """Return the gains that a machine bears."""
    plain = _feedback(machine, 0, 0.0), _feedback(machine, 1, 0.0), _feedback(machine, 2, 0.0)
    # The damping of a swing whose spools are too slow for it would cost K_p.
    damped = _feedback(machine, 0, SWING_DAMPING)
    feedback, damping = max((damped, SWING_DAMPING), (plain[0], 0.0))
    return JointGains(
        feedback=(feedback, plain[1], plain[2]),
        integral=(integral(feedback, 0), integral(plain[1], 1), integral(plain[2], 2)),
        rate=(damping, 0.0, 0.0),
    )


def integral(feedback: float, axis: int) -> float:
    """Return the K_i [1/s^2] that goes with a joint's K_p [1/s]."""
    return INTEGRAL_SHARE[axis] * feedback * feedback


def servo_response(
    feedback: float, integral_gain: float, damping: float, axis: int, rate: float, s: Complexes
) -> Complexes:
    """Return C of a joint: K_p + K_i/s + D s, errors of boom and stick low-passed in slow motion.

    Args:
        feedback: K_p [1/s].
        integral_gain: K_i [1/s^2].
        damping: D.
        axis: whose.
        rate: at which it moves [rad/s].
        s: [n] complex frequencies [1/s].
    """
    weight = min(1.0, (rate / FULL_RATE) ** 2)
    quick = 1.0 if axis == 0 else weight
    passed = quick + (1.0 - quick) / (1.0 + ERROR_LAG * s)
    response: Complexes = feedback * passed + integral_gain / s + damping * weight * s
    return response


def joint_plant(machine: Machine, q: Vec3, axis: int, rate: float) -> Complexes:
    """Return the joint's angle over its commanded rate, at `FREQUENCY` [s].

    Args:
        machine: as the controller knows it.
        q: pose [rad].
        axis: that moves, alone.
        rate: at which it moves [rad/s].
    """
    s: Complexes = 2j * math.pi * FREQUENCY
    valve = machine.valve_of(axis)
    late = np.exp(-(1.5 * PERIOD + (valve.dead_time or 0.0)) * s)
    response: Complexes = _rate_response(machine, q, axis, rate, s) * late / s
    if valve.spool_bandwidth is None:
        return response
    x = s / (2.0 * math.pi * valve.spool_bandwidth)
    return response / (1.0 + x if not valve.spool_damping else 1.0 + 2.0 * valve.spool_damping * x + x * x)


def _feedback(machine: Machine, axis: int, damping: float) -> float:
    """Return the greatest K_p [1/s] that all stated motions bear; gains below it are borne, too."""
    s: Complexes = 2j * math.pi * FREQUENCY
    motions = [
        (rate, joint_plant(machine, q, axis, rate))
        for q in _poses(machine)
        for rate in (speed / _radius(machine, q, axis) for speed in TIP_SPEEDS)
    ]
    borne = STEP
    while borne + STEP <= HIGHEST_GAIN[axis]:
        tried = borne + STEP
        for rate, plant in motions:
            loop = servo_response(tried, integral(tried, axis), damping, axis, rate, s) * plant
            if float(np.min(np.abs(1.0 + loop))) < 1.0 / AMPLIFICATION:
                return borne
        borne = tried
    return borne


def _poses(machine: Machine) -> list[Vec3]:
    _, boom, stick = joint_limits(machine)
    return [
        (0.0, boom[0] + k * (boom[1] - boom[0]), stick[0] + i * (stick[1] - stick[0]))
        for k in PLACES
        for i in PLACES
    ]


def _radius(machine: Machine, q: Vec3, axis: int) -> float:
    """Return the tip's distance from a joint [m], and at least one."""
    links = machine.manipulator.links
    x, _, z = tip_position((0.0, q[1], q[2]), links)
    reach = abs(x) if axis == 0 else math.hypot(x - links.base_offset, z) if axis == 1 else links.stick
    return max(1.0, reach)


def _rate_response(machine: Machine, q: Vec3, axis: int, rate: float, s: Complexes) -> Complexes:
    """Return H."""
    axes = axis_drivers(machine)
    if axis == 0:
        swing, spring = swing_model(machine), _oil(machine, axes[0], 0, q, rate, s)
        alone: Complexes = spring / (inertia(q, swing) * s + swing.damping + spring)
        return alone
    m_22, m_23, m_33 = arm_inertia(q, arm_model(machine))
    boom = _oil(machine, axes[1], 1, q, rate if axis == 1 else 0.0, s)
    stick = _oil(machine, axes[2], 2, q, rate if axis == 2 else 0.0, s)
    on_boom = m_22 * s + boom + machine.boom.damping * lever_arm(q[1], machine.linkages[0]) ** 2
    on_stick = m_33 * s + stick + machine.stick.damping * lever_arm(q[2], machine.linkages[1]) ** 2
    moved, other = (boom, on_stick) if axis == 1 else (stick, on_boom)
    pair: Complexes = other * moved / (on_boom * on_stick - (m_23 * s) ** 2)
    return pair


def _oil(machine: Machine, driver: AxisDriver, axis: int, q: Vec3, rate: float, s: Complexes) -> Complexes:
    """Return Z of a joint that moves at a rate [rad/s]; 0: its valve is shut. Merritt, section 6.2."""
    x, arm = 0.0, 1.0
    if axis > 0:
        linkage = machine.linkages[axis - 1]
        x, arm = cylinder_length(q[axis], linkage), lever_arm(q[axis], linkage)
    inlet, outlet = _drops(machine, driver)
    speed, d_1, d_2 = abs(rate * arm), driver.displacement_1, driver.displacement_2
    one = driver.oil_1.fixed + driver.oil_1.growing * x
    two = driver.oil_2.fixed + driver.oil_2.growing * x
    leak = 2.0 * driver.slip * d_1 * d_1
    sides: Complexes = d_1 * d_1 / (one * s + leak + d_1 * speed / (2.0 * inlet))
    sides = sides + d_2 * d_2 / (two * s + leak + d_2 * speed / (2.0 * outlet))
    return sides * arm * arm


def _drops(machine: Machine, driver: AxisDriver) -> tuple[float, float]:
    """Return the pressure drops [Pa] over the edges from the pump and to the tank, the joint unloaded.

    Where a pump or a compensator keeps the inlet's drop, its flow heeds no pressure: it damps nothing.
    """
    if isinstance(machine.pump, LoadSensingPump):
        return math.inf, machine.pump.margin
    half = 0.5 * machine.pump.supply_pressure
    return (half if driver.metering_drop == math.inf else math.inf), half
