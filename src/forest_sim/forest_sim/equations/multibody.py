"""The links together: crane, hanging head and force on the tip, M q'' + bias = tau, up to five coordinates.

| symbol | name | unit |
|---|---|---|
| q | swing, boom, stick; with a hanging head also its α, β | rad |
| M | mass matrix: the crane's 3x3 block, the head's diagonal 2x2 block, 3x2 in between | kg m^2 |
| bias | V + G, less the outer force's torques, less the head joint's damping | N m |

Without a hanging head the swing is on its own (M_12 = M_13 = 0), and its equations stay as short as
that.
"""

from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.mechanics.manipulator import Dynamics, Pair, dynamics, tip_load_torques
from forest_sim.mechanics.pendulum import pendulum_damping, pendulum_dynamics


class HeadState(NamedTuple):
    """The hanging head's angles α, β [rad] and their rates [rad/s]; also holds their time derivatives."""

    alpha: float
    beta: float
    alpha_rate: float
    beta_rate: float


class Inertia(NamedTuple):
    """The symmetric mass matrix [kg m^2]; `m_alpha` is 0 when nothing hangs."""

    m_11: float
    m_12: float
    m_13: float
    m_22: float
    m_23: float
    m_33: float
    coupling: tuple[Pair, Pair, Pair]  # rows swing, boom, stick; columns α, β
    m_alpha: float
    m_beta: float


class Mechanics(NamedTuple):
    """M and bias at one state."""

    inertia: Inertia
    bias: Vec3
    head_bias: Pair


NOT_COUPLED = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
HANGING_STILL = HeadState(0.0, 0.0, 0.0, 0.0)


def mechanics(q: Vec3, rates: Vec3, head: HeadState, p: PlantParameters) -> Mechanics:
    """Return M and bias. Thesis eq. 3.15, section 4.4.

    Args:
        q: joint angles [rad].
        rates: joint rates [rad/s].
        head: the hanging head's state.
        p: the machine.
    """
    d = dynamics(q, rates, p.body)
    bias = d.bias
    if p.tip_force[0] != 0.0 or p.tip_force[1] != 0.0 or p.tip_force[2] != 0.0:
        load = tip_load_torques(q, p.tip_force, p.body)
        bias = (bias[0] - load[0], bias[1] - load[1], bias[2] - load[2])
    if p.head.mass == 0.0:
        return Mechanics(_without_head(d), bias, (0.0, 0.0))
    angle_rates = head.alpha_rate, head.beta_rate
    h = pendulum_dynamics(q, rates, (head.alpha, head.beta), angle_rates, p.head, p.body)
    damping = pendulum_damping(rates, angle_rates, p.head)
    return Mechanics(
        Inertia(
            m_11=d.m_11 + h.m_11,
            m_12=h.m_12,
            m_13=h.m_13,
            m_22=d.m_22 + h.m_22,
            m_23=d.m_23 + h.m_23,
            m_33=d.m_33 + h.m_33,
            coupling=h.coupling,
            m_alpha=h.m_alpha,
            m_beta=h.m_beta,
        ),
        (
            bias[0] + h.crane_bias[0] - damping.crane[0],
            bias[1] + h.crane_bias[1] - damping.crane[1],
            bias[2] + h.crane_bias[2] - damping.crane[2],
        ),
        (h.head_bias[0] - damping.head[0], h.head_bias[1] - damping.head[1]),
    )


def _without_head(d: Dynamics) -> Inertia:
    """Return the matrix of a crane from which nothing hangs."""
    return Inertia(
        m_11=d.m_11,
        m_12=0.0,
        m_13=0.0,
        m_22=d.m_22,
        m_23=d.m_23,
        m_33=d.m_33,
        coupling=NOT_COUPLED,
        m_alpha=0.0,
        m_beta=0.0,
    )


def times(m: Inertia, a: Vec3, b: Pair) -> tuple[Vec3, Pair]:
    """Return M applied to three joint accelerations and two of the head [N m]."""
    if m.m_alpha == 0.0:
        return (m.m_11 * a[0], m.m_22 * a[1] + m.m_23 * a[2], m.m_23 * a[1] + m.m_33 * a[2]), (0.0, 0.0)
    c_1, c_2, c_3 = m.coupling
    return (
        m.m_11 * a[0] + m.m_12 * a[1] + m.m_13 * a[2] + c_1[0] * b[0] + c_1[1] * b[1],
        m.m_12 * a[0] + m.m_22 * a[1] + m.m_23 * a[2] + c_2[0] * b[0] + c_2[1] * b[1],
        m.m_13 * a[0] + m.m_23 * a[1] + m.m_33 * a[2] + c_3[0] * b[0] + c_3[1] * b[1],
    ), (
        c_1[0] * a[0] + c_2[0] * a[1] + c_3[0] * a[2] + m.m_alpha * b[0],
        c_1[1] * a[0] + c_2[1] * a[1] + c_3[1] * a[2] + m.m_beta * b[1],
    )


def resisted(m: Inertia, resistance: Vec3, damping: float, h: float) -> Inertia:
    """Return M + h times what resists the joints, -d(torque)/d(rate), and the head joint's damping.

    Args:
        m: the mass matrix.
        resistance: of the three actuators [N m s].
        damping: of the head's joint [N m s].
        h: the implicit step [s].
    """
    b = h * damping
    if m.m_alpha == 0.0:
        b = 0.0
    c = m.coupling
    return Inertia(
        m_11=m.m_11 + h * resistance[0],
        m_12=m.m_12,
        m_13=m.m_13,
        m_22=m.m_22 + h * resistance[1] + b,
        m_23=m.m_23 + b,
        m_33=m.m_33 + h * resistance[2] + b,
        coupling=(c[0], (c[1][0] - b, c[1][1]), (c[2][0] - b, c[2][1])),
        m_alpha=m.m_alpha + b,
        m_beta=m.m_beta + b,
    )


def solve(m: Inertia, r: Vec3, s: Pair) -> tuple[Vec3, Pair]:
    """Return M^-1 applied to three torques on the joints and two on the head's axes.

    The head's diagonal block is eliminated first.
    """
    if m.m_alpha == 0.0:
        return _solve_crane(m, r), (0.0, 0.0)
    c_1, c_2, c_3 = m.coupling
    e_1, e_2, e_3 = c_1[0] / m.m_alpha, c_2[0] / m.m_alpha, c_3[0] / m.m_alpha
    f_1, f_2, f_3 = c_1[1] / m.m_beta, c_2[1] / m.m_beta, c_3[1] / m.m_beta
    reduced = Inertia(
        m_11=m.m_11 - e_1 * c_1[0] - f_1 * c_1[1],
        m_12=m.m_12 - e_1 * c_2[0] - f_1 * c_2[1],
        m_13=m.m_13 - e_1 * c_3[0] - f_1 * c_3[1],
        m_22=m.m_22 - e_2 * c_2[0] - f_2 * c_2[1],
        m_23=m.m_23 - e_2 * c_3[0] - f_2 * c_3[1],
        m_33=m.m_33 - e_3 * c_3[0] - f_3 * c_3[1],
        coupling=NOT_COUPLED,
        m_alpha=0.0,
        m_beta=0.0,
    )
    a = _solve_crane(
        reduced,
        (
            r[0] - e_1 * s[0] - f_1 * s[1],
            r[1] - e_2 * s[0] - f_2 * s[1],
            r[2] - e_3 * s[0] - f_3 * s[1],
        ),
    )
    return a, (
        s[0] / m.m_alpha - e_1 * a[0] - e_2 * a[1] - e_3 * a[2],
        s[1] / m.m_beta - f_1 * a[0] - f_2 * a[1] - f_3 * a[2],
    )


def _solve_crane(m: Inertia, r: Vec3) -> Vec3:
    """Return the inverse of the 3x3 block applied to r."""
    d_11 = m.m_22 * m.m_33 - m.m_23 * m.m_23
    if m.m_12 == 0.0 and m.m_13 == 0.0:  # quotients of M alone, which serve a second right-hand side as well
        per_swing, per_links = 1.0 / m.m_11, 1.0 / d_11
        return (
            r[0] * per_swing,
            (m.m_33 * r[1] - m.m_23 * r[2]) * per_links,
            (m.m_22 * r[2] - m.m_23 * r[1]) * per_links,
        )
    d_12 = m.m_13 * m.m_23 - m.m_12 * m.m_33
    d_13 = m.m_12 * m.m_23 - m.m_13 * m.m_22
    d_22 = m.m_11 * m.m_33 - m.m_13 * m.m_13
    d_23 = m.m_12 * m.m_13 - m.m_11 * m.m_23
    d_33 = m.m_11 * m.m_22 - m.m_12 * m.m_12
    determinant = m.m_11 * d_11 + m.m_12 * d_12 + m.m_13 * d_13
    return (
        (d_11 * r[0] + d_12 * r[1] + d_13 * r[2]) / determinant,
        (d_12 * r[0] + d_22 * r[1] + d_23 * r[2]) / determinant,
        (d_13 * r[0] + d_23 * r[1] + d_33 * r[2]) / determinant,
    )
