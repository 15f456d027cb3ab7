"""How a joint answers its valve: the machine's file, linearised at a pose and a rate.

A joint hangs on the oil of its hoses and chambers, a spring with a mass. What its valve lets pass damps it.

| symbol | name | unit |
|---|---|---|
| s | complex frequency | 1/s |
| A, C, G | area times lever arm; capacitance; conductance of the valve's edge, Q/(2 dp): of either side | |
| Z | torque of the oil per joint rate, the sum of A^2/(C s + G) | N m s/rad |
| M, B | inertia, and viscous damping | kg m^2, N m s/rad |
| H | joint rate over commanded rate, Z/(M s + B + Z); boom and stick as a pair, one valve shut | 1 |

Left out: dry friction and load feedback, which damp; bending; the sway of what hangs; load-holding valves;
air in the oil.
"""

import math
from typing import NamedTuple

from forest_control.servo.arm_feedforward import ArmModel, arm_inertia, arm_model
from forest_control.servo.swing_feedforward import SwingModel, inertia, swing_model
from forest_control.valve.valve_driver_parameters import Axes, AxisDriver, axis_drivers
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import cylinder_length, lever_arm
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.machine import Machine
from forest_description.types import Complexes, Vec3

PLACES = 0.2, 0.5, 0.8  # [1] of the ranges of boom and stick: nine poses, away from the strokes' ends


class ResponseModel(NamedTuple):
    """What the answers of a machine have in common, whatever the pose."""

    machine: Machine  # as the controller knows it
    axes: Axes
    swing: SwingModel
    arm: ArmModel


def response_model(machine: Machine) -> ResponseModel:
    """Return the constants for a machine."""
    return ResponseModel(machine, axis_drivers(machine), swing_model(machine), arm_model(machine))


def rate_response(
    model: ResponseModel, q: Vec3, axis: int, rate: float, s: Complexes, emptied: bool = False
) -> Complexes:
    """Return H.

    Args:
        model: of the machine.
        q: pose [rad].
        axis: that moves, alone.
        rate: at which it moves [rad/s].
        s: [n] complex frequencies [1/s].
        emptied: by a rest are the joint's ports; where its flow heeds no pressure, the outlet stays so.
    """
    if axis == 0:
        swing, spring = model.swing, _oil(model, 0, q, rate, s, emptied)
        alone: Complexes = spring / (inertia(q, swing) * s + swing.damping + spring)
        return alone
    machine = model.machine
    m_22, m_23, m_33 = arm_inertia(q, model.arm)
    boom = _oil(model, 1, q, rate if axis == 1 else 0.0, s, emptied and axis == 1)
    stick = _oil(model, 2, q, rate if axis == 2 else 0.0, s, emptied and axis == 2)
    on_boom = m_22 * s + boom + machine.boom.damping * lever_arm(q[1], machine.linkages[0]) ** 2
    on_stick = m_33 * s + stick + machine.stick.damping * lever_arm(q[2], machine.linkages[1]) ** 2
    moved, other = (boom, on_stick) if axis == 1 else (stick, on_boom)
    pair: Complexes = other * moved / (on_boom * on_stick - (m_23 * s) ** 2)
    return pair


def poses(machine: Machine) -> list[Vec3]:
    """Return poses [rad] all over the ranges of boom and stick."""
    _, boom, stick = joint_limits(machine)
    return [
        (0.0, boom[0] + k * (boom[1] - boom[0]), stick[0] + i * (stick[1] - stick[0]))
        for k in PLACES
        for i in PLACES
    ]


def tip_radius(machine: Machine, q: Vec3, axis: int) -> float:
    """Return the tip's distance from a joint [m], and at least one."""
    links = machine.manipulator.links
    x, _, z = tip_position((0.0, q[1], q[2]), links)
    reach = abs(x) if axis == 0 else math.hypot(x - links.base_offset, z) if axis == 1 else links.stick
    return max(1.0, reach)


def _oil(model: ResponseModel, axis: int, q: Vec3, rate: float, s: Complexes, emptied: bool) -> Complexes:
    """Return Z of a joint that moves at a rate [rad/s]; 0: its valve is shut. Merritt, section 6.2."""
    driver, x, arm = model.axes[axis], 0.0, 1.0
    if axis > 0:
        linkage = model.machine.linkages[axis - 1]
        x, arm = cylinder_length(q[axis], linkage), lever_arm(q[axis], linkage)
    inlet, outlet = _drops(model.machine, driver)
    speed, d_1, d_2 = abs(rate * arm), driver.displacement_1, driver.displacement_2
    one = driver.oil_1.fixed + driver.oil_1.growing * x
    two = driver.oil_2.fixed + driver.oil_2.growing * x
    leak = 2.0 * driver.slip * d_1 * d_1
    side_1: Complexes = d_1 * d_1 / (one * s + leak + d_1 * speed / (2.0 * inlet))
    side_2: Complexes = d_2 * d_2 / (two * s + leak + d_2 * speed / (2.0 * outlet))
    if emptied and inlet == math.inf:
        return (side_1 if rate > 0.0 else side_2) * arm * arm
    return (side_1 + side_2) * arm * arm


def _drops(machine: Machine, driver: AxisDriver) -> tuple[float, float]:
    """Return the pressure drops [Pa] over the edges from the pump and to the tank, the joint unloaded.

    Where a pump or a compensator keeps the inlet's drop, its flow heeds no pressure: it damps nothing.
    """
    if isinstance(machine.pump, LoadSensingPump):
        return math.inf, machine.pump.margin
    half = 0.5 * machine.pump.supply_pressure
    return (half if driver.metering_drop == math.inf else math.inf), half
