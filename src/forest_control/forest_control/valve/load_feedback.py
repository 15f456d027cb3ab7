"""Dynamic load feedback: a valve that heeds no load gives way to one that rocks.

A mass hangs on an actuator's oil as on a spring. A plain valve lets more oil pass under less load,
which damps it. A compensated valve keeps its flow, and damps nothing; a counterbalance valve at the other
port may even drive the oscillation. The driver therefore takes c (F - F_s) off the actuator's speed.

| symbol | name | unit |
|---|---|---|
| F, F_s | load, and what of it stays: low-passed | N; N m |
| k | stiffness of the oil, A_1^2/C_1 + A_2^2/C_2 | N/m; N m/rad |
| m | what moves with the actuator, all other joints held | kg; kg m^2 |
| zeta | damping ratio c sqrt(k m)/2 | 1 |

k and m are those of the middle of all ranges. Merritt, Hydraulic Control Systems, section 6.6.
"""

import math

from forest_description.derived.bodies import PlanarBody, bearing_stick, boom_body, stick_body
from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import Machine

DAMPING = 0.15  # [1] zeta; twice as much rocks the forwarder's sweep more; chosen


def load_feedback(machine: Machine, axis: int, stiffness: float) -> float:
    """Return c [m/s per N; rad/s per N m] of an axis, by the stiffness k of its oil [N/m; N m/rad]."""
    return 2.0 * DAMPING / math.sqrt(stiffness * moved_mass(machine, axis))


def moved_mass(machine: Machine, axis: int) -> float:
    """Return m [kg; kg m^2] of an axis in the middle of the joints' ranges."""
    m, (_, boom, stick) = machine.manipulator, joint_limits(machine)
    q_2, q_3 = 0.5 * (boom[0] + boom[1]), 0.5 * (stick[0] + stick[1])
    upper, lower = boom_body(m), bearing_stick(m)
    if axis == 2:
        return _inertia(lower, 0.0, 0.0) / lever_arm(q_3, machine.linkages[1]) ** 2
    if axis == 1:
        both = _inertia(upper, 0.0, 0.0) + _inertia(lower, m.boom_length, q_3)
        return both / lever_arm(q_2, machine.linkages[0]) ** 2
    elbow = m.base_offset + m.boom_length * math.cos(q_2)
    both = _about_swing(upper, m.base_offset, q_2) + _about_swing(stick_body(m), elbow, q_2 + q_3)
    return m.base_zz + m.base_mass * m.base_x**2 + both


def _inertia(body: PlanarBody, x: float, angle: float) -> float:
    """Return the inertia [kg m^2] of a body about a joint.

    Args:
        body: turned by an angle about its own joint.
        x: of that joint, along the link before it [m].
        angle: [rad].
    """
    c, s = math.cos(angle), math.sin(angle)
    along, across = x + c * body.x - s * body.y, s * body.x + c * body.y
    return body.zz + body.mass * (along**2 + across**2)


def _about_swing(body: PlanarBody, x: float, elevation: float) -> float:
    """Return the inertia [kg m^2] of a slender body about the swing's axis.

    Args:
        body: boom or stick.
        x: distance of its joint from the axis [m].
        elevation: of its link [rad].
    """
    radius = x + body.x * math.cos(elevation) - body.y * math.sin(elevation)
    return body.mass * radius**2 + body.zz * math.cos(elevation) ** 2
