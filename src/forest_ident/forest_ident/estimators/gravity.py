"""Check masses against the cylinders' forces at rest in several poses.

| symbol | name | unit |
|---|---|---|
| F | force of a cylinder from the pressures at its ports | N |
| J | lever arm dx/dq | m/rad |
| G_m(q) | torque of gravity per mass m of boom, stick, head | N m/kg |

    F J - G_rest(q) = G_m(q) m       boom and stick, at every pose

Rests identify two sums along the links and two across them, not every mass: stick and head pull alike. Not in
the thesis, which has its masses from drawings (section 4.4.1).
"""

import dataclasses

import numpy as np

from forest_description.config.parameter import replace_unchecked
from forest_description.machine import Machine
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.types import AXES, Floats
from forest_ident.estimators.least_squares import LinearFit, solve
from forest_ident.measurements.readings import length_and_arm
from forest_ident.measurements.session import Session
from forest_sim.mechanics.manipulator import dynamics, fold_head

SETTLED = 2.0  # [s] at zero voltage until the crane has stopped swinging


def poses(machine: Machine, session: Session) -> tuple[Floats, Floats]:
    """Return (angles, torques) of every rest: n x 3 rad, n x 2 N m of boom and stick."""
    period = session.period
    still = np.all(session.voltages == 0.0, axis=1)
    edges = np.flatnonzero(np.diff(still.astype(int), prepend=0, append=0))
    found = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        begin = first + round(SETTLED / period) if first > 0 else first
        if last - begin >= round(0.4 / period):
            found.append(_pose(machine, session, slice(begin, last)))
    table = np.array(found).reshape(-1, 5)
    return table[:, :3], table[:, 3:]


def _pose(machine: Machine, session: Session, rows: slice) -> list[float]:
    """Return mean angles [rad] of all axes, and the torques [N m] of boom and stick."""
    q = [float(np.mean(session.column(f"{axis}_resolver")[rows])) for axis in AXES]
    torques = []
    for axis, angle, drive in zip(AXES[1:], q[1:], machine.drives[1:], strict=True):
        one, two = (float(np.mean(column[rows])) for column in session.pressures(axis, "actuator"))
        arm = float(length_and_arm(np.array([angle]), drive.linkage)[1][0])
        torques.append((drive.head_area * one - drive.rod_area * two) * arm)
    return [*q, *torques]


def masses(machine: Machine, session: Session, names: tuple[str, ...] = ("head_mass",)) -> LinearFit:
    """Return some masses [kg] from forces at rest, the others from the file; three or more poses, no log.

    Args:
        machine: whose geometry, other masses and areas hold.
        session: with rests.
        names: of `Manipulator`'s masses.
    """
    m = dataclasses.replace(machine.manipulator, pendulum=None)  # what hangs at rest pulls at the tip
    angles, torques = poses(machine, session)
    empty = replace_unchecked(m, **dict.fromkeys(names, 0.0))  # no link, but what is linear in the masses
    without = _torques(empty, angles)
    columns = [
        (_torques(replace_unchecked(empty, **{name: 1.0}), angles) - without).ravel() for name in names
    ]
    return solve(columns, (torques - without).ravel(), block=2)


def _torques(m: Manipulator, angles: Floats) -> Floats:
    """Return what gravity asks of boom and stick [N m], n x 2."""
    body, still = fold_head(m), (0.0, 0.0, 0.0)
    biases = [dynamics((q[0], q[1], q[2]), still, body).bias for q in angles.tolist()]
    return np.array([bias[1:] for bias in biases])
