"""Pivots of a cylinder's linkage, where a record has both its length and the joint's angle.

| symbol | name | unit |
|---|---|---|
| x, q | cylinder's length, joint's angle as read | m, rad |
| a, b | pivot_to_base, pivot_to_rod | m |
| φ | angle_offset, plus the resolver's static error | rad |

    x^2 = A - B cos q + C sin q,   A = a^2 + b^2,  B = 2 a b cos φ,  C = 2 a b sin φ

It is linear in A, B and C. Of a and b the start says which is the greater. φ is not taken: no record tells
an offset of the drawing from one of the resolver.
"""

import math
from collections.abc import Sequence

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.estimators.least_squares import solve
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.measurements.session import Session

MEAN = 20  # rows: noise of single angles would pull the fit, as it does where a regressor is noisy
MOVED = 1e-3  # [rad] meanwhile: at rest the step of the length's transducer is no noise
SWEPT = 0.3  # [rad] over which the length bends enough to tell both pivots apart
KEYS = ("pivot_to_base", "pivot_to_rod")


def pivots(machine: Machine, sessions: Sequence[Session]) -> list[Estimate]:
    """Return both pivots of boom and stick [m]; none of a cylinder that no record tells. Thesis App. A.

    Args:
        machine: as stated.
        sessions: any; those of the crane with a transducer and a resolver at an axis count.
    """
    found = []
    for axis in AXES[1:]:
        read = [np.zeros((2, 0)), *(_rows(axis, session) for session in sessions if session.on_crane)]
        q, x = np.concatenate(read, axis=1)
        if len(q) and np.ptp(q) > SWEPT:
            found += _pivots(machine, axis, q, x)
    return found


def _rows(axis: str, session: Session) -> Floats:
    """Return means of angle [rad] and length [m] over short times in motion; none without both sensors."""
    names = f"{axis}_resolver", f"{axis}_transducer"
    if not session.has(*names):
        return np.zeros((2, 0))
    both = np.array([session.column(name) for name in names])
    means = both[:, : len(session.time) // MEAN * MEAN].reshape(2, -1, MEAN).mean(axis=2)
    moved = np.abs(np.gradient(means[0])) > MOVED
    return np.asarray(means[:, moved], dtype=np.float64)


def _pivots(machine: Machine, axis: str, q: Floats, x: Floats) -> list[Estimate]:
    fit = solve([np.ones(len(q)), -np.cos(q), np.sin(q)], x * x, block=1)
    total, double = float(fit.values[0]), math.hypot(*fit.values[1:].tolist())
    if total <= double:  # no triangle
        return []
    add, less = math.sqrt(total + double), math.sqrt(total - double)
    told = [getattr(getattr(machine, axis), key) for key in KEYS]
    sign = 1.0 if told[0] >= told[1] else -1.0
    one, way = np.array([1.0, 0.0, 0.0]), np.array([0.0, *(fit.values[1:] / double)])
    sums, gaps = (one + way) / (2.0 * add), (one - way) / (2.0 * less)  # a + b, |a - b| by A, B, C
    slopes = 0.5 * (sums + sign * gaps), 0.5 * (sums - sign * gaps)
    values = 0.5 * (add + sign * less), 0.5 * (add - sign * less)
    return [
        Estimate(
            key=f"{axis}.{key}",
            value=value,
            standard_error=math.sqrt(float(slope @ fit.covariance @ slope)),
            unit="m",
            condition=fit.condition,
            method="length over angle (App. A)",
        )
        for key, value, slope in zip(KEYS, values, slopes, strict=True)
    ]
