"""Where the links are, by the angles of their joints: a boom that bends under its load, a column that twists.

Actuators and sensors are at a link's root; the tip is at its end. Between them the link gives way like a
spring at its joint. The controller counts with the angles of the links, so that the tip keeps its path.

| symbol | name | unit |
|---|---|---|
| theta, q | measured angle of a joint; angle of its link | rad |
| G | torque of gravity on boom and stick, with the load that is weighed | N m |
| M, b | inertia about the joints; reference acceleration | kg m^2, rad/s^2 |
| k | stiffness of a link; infinite where the machine's file tells none | N m/rad |

    q = theta - (G(theta) + M b)/k

Gravity's part is taken from what is measured (`link_angles`). The reference's acceleration adds the rest
(`pushed`), and the rates that go with both are fed forward (`arm_feedforward`, `swing_feedforward`).

Left out: the links' own vibration, some 5 Hz and up; the sway of what hangs; the platform's tilt.
"""

import math

from forest_control.limits.actuator_speed_limits import SpeedLimitParameters, gravity_torques
from forest_control.servo.arm_feedforward import ArmModel, arm_inertia
from forest_description.types import Vec3


def link_angles(theta: Vec3, mass: float, crane: SpeedLimitParameters, arm: ArmModel) -> Vec3:
    """Return q [rad] of links at rest that carry a weighed load.

    Args:
        theta: angles of the joints [rad].
        mass: of the load [kg]; NaN: not known, none is assumed.
        crane: for the torques of its own weight.
        arm: constants of boom and stick.
    """
    if arm.compliance[0] == 0.0 and arm.compliance[1] == 0.0:
        return theta
    own, load = gravity_torques(theta, crane), 0.0 if math.isnan(mass) else arm.gravity * mass
    on_stick = load * arm.stick_length * math.cos(theta[1] + theta[2])
    on_boom = load * arm.boom_length * math.cos(theta[1]) + on_stick
    boom, stick = (own[0] + on_boom) * arm.compliance[0], (own[1] + on_stick) * arm.compliance[1]
    return theta[0], theta[1] - boom, theta[2] - stick


def pushed(q: Vec3, b: Vec3, m_11: float, column: float, arm: ArmModel) -> Vec3:
    """Return M b/k [rad]: how far the joints of links that are speeded up run ahead of them.

    Args:
        q: angles of the links [rad].
        b: their reference acceleration [rad/s^2].
        m_11: inertia about the swing axis [kg m^2].
        column: 1/k of the column [rad/(N m)].
        arm: constants of boom and stick.
    """
    m_22, m_23, m_33 = arm_inertia(q, arm)
    return (
        m_11 * b[0] * column,
        (m_22 * b[1] + m_23 * b[2]) * arm.compliance[0],
        (m_23 * b[1] + m_33 * b[2]) * arm.compliance[1],
    )
