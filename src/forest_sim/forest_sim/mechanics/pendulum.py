"""The head as a passive pendulum with two axes at the tip: what it adds to the crane's equations of motion.

Thesis section 4.4: such a head hung on its machine, and its model had none. Coordinates are q_1,
q_2, q_3 of swing, boom and stick, and

| symbol | name | unit |
|---|---|---|
| α | head's angle in the crane's plane, from the platform's vertical, outwards positive | rad |
| β | head's angle out of the crane's plane, to the left positive | rad |
| d | unit vector from the joint to the head's centre, (sin α cos β, sin β, -cos α cos β) | 1 |
| m, L | mass of head and log; distance of their centre from the joint | kg; m |
| I_t | their inertia about that centre, across the head's axis | kg m^2 |
| I_l | what a log's length adds: a slender rod in the crane's plane along e = (cos α, 0, sin α) | kg m^2 |

All vectors stand in the frame that turns with the swing: x away from the swing axis, y left, z up.
The head is a body of revolution that does not spin: T = 1/2 m |p'|^2 + 1/2 I_t |d'|^2 with p = tip
+ L d. With t_i and d_i, the columns of the tip's and of d's Jacobian,

    M_ij = m t_i·t_j + m L (t_i·d_j + d_i·t_j) + (m L^2 + I_t) d_i·d_j

and the bias is the same sum with t_j, d_j replaced by the accelerations that are there when no
joint accelerates, less gravity. At β = ±π/2 the angles are singular: α has no inertia there.

The rotator keeps a log in the crane's plane, where the crane lays it on its own load: T gains
1/2 I_l |e'|^2, with |e'|^2 = α'^2 + q_1'^2 cos^2 α. Its roll about β is that of a rod: none.

Everything in this module but `hanging_head` is in the subset of Python that Numba compiles, and
what the plant needs in that of `translate`.
"""

import math
from typing import NamedTuple

from forest_description.derived.bodies import hanging_body
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.types import Vec3
from forest_sim.mechanics.manipulator import Body, Pair


class HangingHead(NamedTuple):
    """Head and log under the joint; a mass of zero means that nothing hangs."""

    mass: float
    length: float  # joint to centre of mass [m]
    inertia: float  # about the centre of mass, across the axis [kg m^2]
    log_inertia: float  # of a log along the crane's plane, about its centre [kg m^2]
    damping: float  # of each of the joint's two axes [N m s/rad]


class PendulumDynamics(NamedTuple):
    """What the hanging head adds: rows of M and V + G for swing, boom, stick, α, β.

    The head's own 2x2 block is diagonal.
    """

    m_11: float  # to be added to the crane's mass matrix [kg m^2]
    m_12: float
    m_13: float
    m_22: float
    m_23: float
    m_33: float
    coupling: tuple[Pair, Pair, Pair]  # rows swing, boom, stick; columns α, β
    m_alpha: float
    m_beta: float
    crane_bias: Vec3  # V + G, to be added to the crane's [N m]
    head_bias: Pair


class PendulumDamping(NamedTuple):
    """Torques of the joint's viscous damping on swing, boom, stick and on α, β [N m].

    Their derivative by (q_1', q_2', q_3', α', β') is -damping (n n^T + e e^T), n = (0, -1, -1, 1,
    0) and e = (0, 0, 0, 0, 1).
    """

    crane: Vec3
    head: Pair


def hanging_head(m: Manipulator) -> HangingHead:
    """Return the constants of the hanging head; its mass is zero when the machine has no pendulum."""
    body = hanging_body(m)
    if body is None or m.pendulum is None:
        return HangingHead(0.0, 1.0, 0.0, 0.0, 0.0)
    return HangingHead(*body, m.pendulum.damping)


def pendulum_dynamics(
    q: Vec3, rates: Vec3, angles: Pair, angle_rates: Pair, head: HangingHead, body: Body
) -> PendulumDynamics:
    """Return the hanging head's share of M and of V + G. Thesis section 4.4.

    Differs: the thesis only names the swinging head.

    Args:
        q: joint angles [rad].
        rates: joint rates [rad/s].
        angles: α, β [rad].
        angle_rates: their rates [rad/s].
        head: from `hanging_head`.
        body: the crane's lengths and gravity, from `fold_head`.
    """
    mass, first = head.mass, head.mass * head.length
    second = first * head.length + head.inertia  # about the joint
    radius, (x_2, z_2), (x_3, z_3) = _tip(q, body)
    s_a, c_a = math.sin(angles[0]), math.cos(angles[0])
    s_b, c_b = math.sin(angles[1]), math.cos(angles[1])
    d_alpha, d_beta = (c_a * c_b, 0.0, s_a * c_b), (-s_a * s_b, c_b, c_a * s_b)
    d_swing = (-s_b, s_a * c_b, 0.0)  # z x d

    log, log_turn = head.log_inertia * (c_a * c_a), head.log_inertia * s_a * c_a * rates[0]
    tip, turning = _accelerations(q, rates, angles, angle_rates, body)
    force = _sum(mass, tip, first, turning)  # that the bias takes at the tip
    moment = _sum(first, tip, second, turning)  # and along the directions in which d moves
    return PendulumDynamics(
        m_11=mass * (radius * radius)
        + 2.0 * first * radius * d_swing[1]
        + second * _dot(d_swing, d_swing)
        + log,
        m_12=first * z_2 * s_b,
        m_13=first * z_3 * s_b,
        m_22=mass * (x_2 * x_2 + z_2 * z_2),
        m_23=mass * (x_2 * x_3 + z_2 * z_3),
        m_33=mass * (x_3 * x_3 + z_3 * z_3),
        coupling=(
            (second * _dot(d_swing, d_alpha), first * radius * c_b + second * _dot(d_swing, d_beta)),
            (first * (x_2 * d_alpha[2] - z_2 * d_alpha[0]), first * (x_2 * d_beta[2] - z_2 * d_beta[0])),
            (first * (x_3 * d_alpha[2] - z_3 * d_alpha[0]), first * (x_3 * d_beta[2] - z_3 * d_beta[0])),
        ),
        m_alpha=second * (c_b * c_b) + head.log_inertia,
        m_beta=second,
        crane_bias=(
            radius * force[1] + _dot(d_swing, moment) - 2.0 * log_turn * angle_rates[0],
            x_2 * force[2] - z_2 * force[0],
            x_3 * force[2] - z_3 * force[0],
        ),
        head_bias=(_dot(d_alpha, moment) + log_turn * rates[0], _dot(d_beta, moment)),
    )


def pendulum_damping(rates: Vec3, angle_rates: Pair, head: HangingHead) -> PendulumDamping:
    """Return the torques of the joint's damping: α against the stick's absolute pitch, β on its own."""
    in_plane = head.damping * (angle_rates[0] - rates[1] - rates[2])
    return PendulumDamping((0.0, in_plane, in_plane), (-in_plane, -head.damping * angle_rates[1]))


def hanging_angles(swing: float, body: Body) -> Pair:
    """Return α, β [rad] of a head at rest at a swing angle [rad]; both are zero on a level platform."""
    along, across = body.gravity_across * math.sin(swing), body.gravity_across * math.cos(swing)
    return math.atan2(-along, body.gravity_down), math.atan2(-across, math.hypot(along, body.gravity_down))


def _tip(q: Vec3, body: Body) -> tuple[float, Pair, Pair]:
    """Return the tip's radius and its x, z [m] from the boom's pivot and from the stick's."""
    x_3, z_3 = body.stick_length * math.cos(q[1] + q[2]), body.stick_length * math.sin(q[1] + q[2])
    x_2, z_2 = body.boom_length * math.cos(q[1]) + x_3, body.boom_length * math.sin(q[1]) + z_3
    return body.base_offset + x_2, (x_2, z_2), (x_3, z_3)


def _accelerations(q: Vec3, rates: Vec3, angles: Pair, angle_rates: Pair, body: Body) -> tuple[Vec3, Vec3]:
    """Return the tip's acceleration less gravity [m/s^2], and d'' [1/s^2], while no joint accelerates."""
    radius, (x_2, z_2), (x_3, z_3) = _tip(q, body)
    u_1, u_23 = rates[0], rates[1] + rates[2]
    pitch_2, pitch_3 = rates[1] * rates[1], u_23 * u_23
    tip = (
        (x_3 - x_2) * pitch_2 - x_3 * pitch_3 - radius * (u_1 * u_1) + body.gravity_across * math.sin(q[0]),
        -2.0 * u_1 * (z_2 * rates[1] + z_3 * rates[2]) + body.gravity_across * math.cos(q[0]),
        (z_3 - z_2) * pitch_2 - z_3 * pitch_3 + body.gravity_down,
    )
    s_a, c_a = math.sin(angles[0]), math.cos(angles[0])
    s_b, c_b = math.sin(angles[1]), math.cos(angles[1])
    a, b = angle_rates
    outward = c_a * c_b * a - s_a * s_b * b  # d' in the turning frame
    turning = (
        -s_a * c_b * (a * a + b * b) - 2.0 * c_a * s_b * a * b - 2.0 * u_1 * c_b * b - u_1 * u_1 * s_a * c_b,
        -s_b * b * b + 2.0 * u_1 * outward - u_1 * u_1 * s_b,
        c_a * c_b * (a * a + b * b) - 2.0 * s_a * s_b * a * b,
    )
    return tip, turning


def _dot(a: Vec3, b: Vec3) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _sum(k: float, a: Vec3, n: float, b: Vec3) -> Vec3:
    """Return k a + n b."""
    return (k * a[0] + n * b[0], k * a[1] + n * b[1], k * a[2] + n * b[2])
