"""Check masses against the cylinders' forces at rest in several poses.

| symbol | name | unit |
|---|---|---|
| F | force of a cylinder from the pressures at its ports | N |
| J | lever arm dx/dq | m/rad |
| G_m(q) | torque of gravity per mass m of boom, stick, head | N m/kg |

    F J - G_rest(q) = G_m(q) m       boom and stick, at every pose

Rests identify two sums along the links and two across them (`moments`), not every mass. Not in the thesis,
which has its masses from drawings (section 4.4.1).
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import replace_unchecked
from forest_description.machine import Machine, Manipulator
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


class Moment(NamedTuple):
    """A sum of masses times distances that forces at rest identify."""

    name: str
    value: float  # [kg m]
    error: float  # [kg m]
    known: float  # [kg m] by the machine file
    condition: float


def moments(machine: Machine, session: Session) -> list[Moment]:
    """Return the four sums that forces at rest identify; none for fewer than three poses, or with a log.

        stick: g ((m3 x3 + m4 l3) cos(q2 + q3) - m3 y3 sin(q2 + q3))
        boom:  g ((m2 x2 + (m3 + m4) l2) cos q2 - m2 y2 sin q2) + the stick's

    Thesis App. B, G(q).

    Args:
        machine: whose linkages and areas hold.
        session: with rests.
    """
    m = machine.manipulator
    angles, torques = poses(machine, session)
    if m.log is not None or len(angles) < 3:
        return []
    down, boom = m.gravity * math.cos(m.platform_tilt), angles[:, 1]
    stick, none = boom + angles[:, 2], np.zeros(len(angles))
    of_boom = [down * np.cos(boom), -down * np.sin(boom)]
    of_stick = [down * np.cos(stick), -down * np.sin(stick)]
    rows = [np.column_stack([column, none]).ravel() for column in of_boom]
    fit = solve([*rows, *(np.repeat(column, 2) for column in of_stick)], torques.ravel(), block=2)
    known = {
        "m2 x2 + (m3 + m4) l2": m.boom_mass * m.boom_x + (m.stick_mass + m.head_mass) * m.boom_length,
        "m2 y2": m.boom_mass * m.boom_y,
        "m3 x3 + m4 l3": m.stick_mass * m.stick_x + m.head_mass * m.stick_length,
        "m3 y3": m.stick_mass * m.stick_y,
    }
    pairs = zip(known, fit.values.tolist(), fit.errors.tolist(), strict=True)
    return [
        Moment(name=name, value=value, error=error, known=known[name], condition=fit.condition)
        for name, value, error in pairs
    ]


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
