"""Rigid-body dynamics of swing, boom and stick: M(q) q'' + V(q, q') + G(q) = tau. Thesis eq. 3.15, App. B.

| symbol | name | unit |
|---|---|---|
| q | angles of swing, boom (from the platform's plane, up positive), stick (relative to the boom) | rad |
| r_b, r_s | distance of the boom's, stick's centre of mass from the swing axis | m |
| h_b, h_s | its height above the boom's pivot | m |
| k_s | the part of h_s that turns with the stick alone | m |
| m | mass | kg |
| I_xx, I_yy, I_zz | moments of inertia about the centre of mass | kg m^2 |
| I_xy | product of inertia about it, the integral of x y dm | kg m^2 |

In these words Appendix B's long sums are short: M_11 = m_3 r_s^2 + m_2 r_b^2 + ..., and V follows
from its derivatives. The swing axis is inertially decoupled (M_12 = M_13 = 0), because every body
is symmetric about the crane's plane.

The base frame has x forward, y left, z up, origin on the swing axis at the height of the boom's
pivot; a tilt of the platform turns it about its x axis, so that gravity pulls along -z and -y.
"""

import math
from typing import NamedTuple

from forest_description.derived.bodies import boom_body, stick_body
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.types import Vec3

Pair = tuple[float, float]


class Body(NamedTuple):
    """Constants of the moving bodies; the stick's hold what it carries rigidly (head, log)."""

    base_offset: float  # l1 [m]
    boom_length: float  # l2 [m]
    stick_length: float  # l3 [m]
    base_inertia: float  # about the swing axis, base alone [kg m^2]
    base_moment: float  # m1 x1 [kg m]
    boom_mass: float
    boom_x: float
    boom_y: float
    boom_xx: float
    boom_yy: float
    boom_zz: float
    boom_xy: float
    stick_mass: float
    stick_x: float
    stick_y: float
    stick_xx: float
    stick_yy: float
    stick_zz: float
    stick_xy: float
    gravity_across: float  # g sin(tilt) [m/s^2], along the platform's y
    gravity_down: float  # g cos(tilt) [m/s^2]


class Dynamics(NamedTuple):
    """M, V and G at one state; M_12 = M_13 = 0."""

    m_11: float  # [kg m^2]
    m_22: float
    m_23: float
    m_33: float
    bias: Vec3  # V + G [N m]


def fold_head(m: Manipulator) -> Body:
    """Return the constants of the dynamics, head and log folded into the stick. Thesis App. B.

    Differs: unless the head hangs (`pendulum`); `forest_description.derived.bodies` tells what the
    thesis' folding
    leaves out and what may be added.
    """
    boom, stick = boom_body(m), stick_body(m)
    return Body(
        m.base_offset,
        m.boom_length,
        m.stick_length,
        m.base_zz + m.base_mass * m.base_x**2,
        m.base_mass * m.base_x,
        *boom,
        *stick,
        gravity_across=m.gravity * math.sin(m.platform_tilt),
        gravity_down=m.gravity * math.cos(m.platform_tilt),
    )


def dynamics(q: Vec3, rates: Vec3, body: Body) -> Dynamics:
    """Return M(q), and V(q, q') + G(q). Thesis eq. 3.15, App. B.

    Args:
        q: joint angles [rad].
        rates: joint rates [rad/s].
        body: inertial constants, from `fold_head`.
    """
    b = body
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_3, s_3 = math.cos(q[2]), math.sin(q[2])
    c_23, s_23 = c_2 * c_3 - s_2 * s_3, s_2 * c_3 + c_2 * s_3
    x_b, h_b = b.boom_x * c_2 - b.boom_y * s_2, b.boom_x * s_2 + b.boom_y * c_2
    x_s, k_s = b.stick_x * c_23 - b.stick_y * s_23, b.stick_x * s_23 + b.stick_y * c_23
    h_s = b.boom_length * s_2 + k_s
    r_b, r_s = b.base_offset + x_b, b.base_offset + b.boom_length * c_2 + x_s

    stick_own = b.stick_mass * (b.stick_x * b.stick_x + b.stick_y * b.stick_y) + b.stick_zz
    coupling = b.stick_mass * b.boom_length * (b.stick_x * c_3 - b.stick_y * s_3)
    coriolis = b.stick_mass * b.boom_length * (b.stick_x * s_3 + b.stick_y * c_3)
    boom_turn = (b.boom_yy - b.boom_xx) * c_2 * s_2 + b.boom_xy * (c_2 * c_2 - s_2 * s_2)
    stick_turn = (b.stick_yy - b.stick_xx) * c_23 * s_23 + b.stick_xy * (c_23 * c_23 - s_23 * s_23)
    half_dm11_dq3 = -b.stick_mass * r_s * k_s - stick_turn
    half_dm11_dq2 = -b.stick_mass * r_s * h_s - b.boom_mass * r_b * h_b - boom_turn - stick_turn

    u_1, u_2, u_3 = rates
    g_y, g_z = b.gravity_across, b.gravity_down
    s_1, c_1 = (math.sin(q[0]), math.cos(q[0])) if g_y != 0.0 else (0.0, 1.0)
    first_moment = b.stick_mass * r_s + b.boom_mass * r_b + b.base_moment
    return Dynamics(
        m_11=b.stick_mass * (r_s * r_s)
        + b.boom_mass * (r_b * r_b)
        + b.base_inertia
        + (b.boom_yy * (c_2 * c_2) + b.boom_xx * (s_2 * s_2) - 2.0 * b.boom_xy * s_2 * c_2)
        + (b.stick_yy * (c_23 * c_23) + b.stick_xx * (s_23 * s_23) - 2.0 * b.stick_xy * s_23 * c_23),
        m_22=stick_own
        + 2.0 * coupling
        + b.stick_mass * (b.boom_length * b.boom_length)
        + b.boom_mass * (b.boom_x * b.boom_x + b.boom_y * b.boom_y)
        + b.boom_zz,
        m_23=stick_own + coupling,
        m_33=stick_own,
        bias=(
            2.0 * (half_dm11_dq2 * u_2 + half_dm11_dq3 * u_3) * u_1 + g_y * c_1 * first_moment,
            -half_dm11_dq2 * (u_1 * u_1)
            - coriolis * (2.0 * u_2 + u_3) * u_3
            + g_z * (b.stick_mass * (b.boom_length * c_2 + x_s) + b.boom_mass * x_b)
            - g_y * s_1 * (b.stick_mass * h_s + b.boom_mass * h_b),
            -half_dm11_dq3 * (u_1 * u_1)
            + coriolis * (u_2 * u_2)
            + g_z * b.stick_mass * x_s
            - g_y * s_1 * b.stick_mass * k_s,
        ),
    )


def tip_load_torques(q: Vec3, force: Vec3, body: Body) -> Vec3:
    """Return the joint torques J^T F [N m] of an external force on the tip, to be added to the actuators'.

    Args:
        q: joint angles [rad].
        force: F [N] in the base frame (x forward at swing 0, y left, z up).
        body: for the links' lengths.
    """
    c_1, s_1 = math.cos(q[0]), math.sin(q[0])
    x_3, z_3 = body.stick_length * math.cos(q[1] + q[2]), body.stick_length * math.sin(q[1] + q[2])
    x_2, z_2 = body.boom_length * math.cos(q[1]) + x_3, body.boom_length * math.sin(q[1]) + z_3
    outward, left, up = c_1 * force[0] + s_1 * force[1], c_1 * force[1] - s_1 * force[0], force[2]
    return ((body.base_offset + x_2) * left, x_2 * up - z_2 * outward, x_3 * up - z_3 * outward)
