"""Whether load and masses are as the machine file tells: forces of the cylinders at rest in several poses.

| symbol | name | unit |
|---|---|---|
| F | force of a cylinder from the pressures at its ports | N |
| J | lever arm dx/dq | m/rad |
| G_m(q) | torque of gravity per mass m of boom, stick, head | N m/kg |

    F J - G_rest(q) = G_m(q) m       boom and stick, at every pose; m: the head with what it holds

The links are taken from the machine file: their masses and the head's pull almost alike, and one pose's
torques do not tell them apart. Not in the thesis, which has its masses from drawings (section 4.4.1).
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from forest_description.machine import AXES, Machine, Manipulator
from forest_ident.least_squares import Line, solve
from forest_ident.readings import length_and_arm
from forest_ident.session import Session
from forest_sim.manipulator import dynamics, fold_head

Floats = NDArray[np.float64]

SETTLED = 2.0  # [s] at zero voltage until the crane has stopped swinging


def poses(machine: Machine, session: Session) -> tuple[Floats, Floats]:
    """Return (angles, torques) of every rest: n x 3 rad, n x 2 N m of boom and stick."""
    period = session.period
    still = np.all(session.voltages == 0.0, axis=1)
    edges = np.flatnonzero(np.diff(still.astype(int), prepend=0, append=0))
    found = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        begin = first + round(SETTLED / period) if first > 0 else first
        if last - begin < round(0.4 / period):
            continue
        rows = slice(begin, last)
        q = [float(np.mean(session.column(f"{axis}_resolver")[rows])) for axis in AXES]
        torques = []
        for place, drive in ((1, machine.boom), (2, machine.stick)):
            one, two = (
                float(np.mean(session.column(f"{AXES[place]}_pressure_{port}_actuator")[rows]))
                for port in (1, 2)
            )
            arm = float(length_and_arm(np.array([q[place]]), drive.linkage)[1][0])
            torques.append((drive.head_area * one - drive.rod_area * two) * arm)
        found.append((*q, *torques))
    table = np.array(found).reshape(-1, 5)
    return table[:, :3], table[:, 3:]


def head_mass(machine: Machine, session: Session) -> Line | None:
    """Return the head's mass [kg]; None for fewer than three poses, or a head that hangs or holds a log.

    Args:
        machine: whose geometry, links and areas hold.
        session: with rests.
    """
    m = machine.manipulator
    if m.pendulum is not None or m.log is not None:
        return None
    angles, torques = poses(machine, session)
    if len(angles) < 3:
        return None
    empty = _torques(dataclasses.replace(m, head_mass=0.0), angles)
    per_kilogram = _torques(dataclasses.replace(m, head_mass=1.0), angles) - empty
    return solve([per_kilogram.ravel()], (torques - empty).ravel(), block=2)


def _torques(m: Manipulator, angles: Floats) -> Floats:
    """Return what gravity asks of boom and stick [N m], n x 2."""
    body, still = fold_head(m), (0.0, 0.0, 0.0)
    biases = [dynamics((q[0], q[1], q[2]), still, body).bias for q in angles.tolist()]
    return np.array([bias[1:] for bias in biases])
