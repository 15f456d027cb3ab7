"""Damping of gear train and cylinders, once everything else is known. Thesis section 4.3.6.

| symbol | name | unit |
|---|---|---|
| q | joint angles | rad |
| F | force (torque) of an actuator from the pressures at its ports | N (N m) |
| J | lever arm dx/dq; 1 for the swing | m/rad |
| B | viscous damping | N s/m (N m s/rad) |
| v | actuator speed | m/s (rad/s) |

    alpha = F - (M(q) q'' + V(q, q') + G(q))_axis / J = B v + c_0 + c_1 (q - mean q)

The last two terms take the static errors of pressures, angles and masses; moving both ways through the same
angles separates them from B.
"""

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.estimators.least_squares import LinearFit, solve
from forest_ident.measurements.differentiator import derivative, inner, smooth
from forest_ident.measurements.readings import length_and_arm
from forest_ident.measurements.session import Session
from forest_sim.mechanics.friction import friction, friction_force
from forest_sim.mechanics.manipulator import dynamics, fold_head

BANDWIDTH = 5.0  # [Hz]
EVERY = 4  # rows of the mass matrix taken, of those that the bandwidth makes alike


def equation(machine: Machine, session: Session, axis: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Return (alpha, v, q, dry friction) along a session. Thesis eq. 4.10, 4.11.

    Differs: J in front of the cylinder's force is Appendix A's 1/j. The dry friction is the file's, at the
    pressures read; the swing's is left out.

    Args:
        machine: whose masses, areas and linkages hold.
        session: of an axis going both ways.
        axis: 0 swing, 1 boom, 2 stick.
    """
    period, rows = session.period, inner(len(session.time), BANDWIDTH, session.period)
    angles = [session.column(f"{name}_resolver") for name in AXES]
    q, rate, acceleration = (
        np.array([derivative(angle, BANDWIDTH, period, order)[rows][::EVERY] for angle in angles])
        for order in (0, 1, 2)
    )
    pressures = session.pressures(AXES[axis], "actuator")
    one, two = (smooth(column, BANDWIDTH, period)[rows][::EVERY] for column in pressures)
    if axis == 0:
        displacement = machine.swing.gear_ratio * machine.swing.motor_displacement
        force, arm = displacement * (one - two), np.ones(q.shape[1])
    else:
        drive = machine.boom if axis == 1 else machine.stick
        force = drive.head_area * one - drive.rod_area * two
        arm = length_and_arm(q[axis], drive.linkage)[1]
    load, speed = _load(machine, q, rate, acceleration)[axis], rate[axis] * arm
    return force - load / arm, speed, q[axis], _dry_friction(machine, axis, speed, one, two)


def _dry_friction(machine: Machine, axis: int, speed: Floats, one: Floats, two: Floats) -> Floats:
    """Return a cylinder's dry friction [N] at speeds [m/s] and pressures at both ports [Pa]."""
    if axis == 0:
        return np.zeros_like(speed)
    law = friction(machine.boom.friction if axis == 1 else machine.stick.friction)
    rows = zip(speed.tolist(), one.tolist(), two.tolist(), strict=True)
    return np.array([friction_force(v, law, p_1, p_2) for v, p_1, p_2 in rows])


def damping(machine: Machine, session: Session, axis: int) -> LinearFit:
    """Return B with c_0 and c_1; arguments as `equation`. Thesis eq. 4.11.

    Differs: the file's dry friction is subtracted first, or it would become damping.
    """
    alpha, speed, angle, dry = equation(machine, session, axis)
    columns = [speed, np.ones(len(speed)), angle - np.mean(angle)]
    return solve(columns, alpha - dry, block=max(1, round(1.0 / (EVERY * session.period))))


def _load(machine: Machine, q: Floats, rate: Floats, acceleration: Floats) -> Floats:
    """Return M q'' + V + G [N m], 3 rows."""
    body, found = fold_head(machine.manipulator), np.zeros_like(q)
    for k in range(q.shape[1]):
        d = dynamics((q[0, k], q[1, k], q[2, k]), (rate[0, k], rate[1, k], rate[2, k]), body)
        a = acceleration[:, k]
        found[0, k] = d.m_11 * a[0] + d.bias[0]
        found[1, k] = d.m_22 * a[1] + d.m_23 * a[2] + d.bias[1]
        found[2, k] = d.m_23 * a[1] + d.m_33 * a[2] + d.bias[2]
    return found
