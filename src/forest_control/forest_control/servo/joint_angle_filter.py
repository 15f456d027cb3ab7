"""The angles of boom and stick: their resolvers', or these corrected by the cylinders' transducers.

| symbol | name | unit |
|---|---|---|
| s | angle that the resolver reads: smooth, but off by its static error | rad |
| q(x) | angle at which the linkage has the length that the transducer reads: true, but noisier | rad |
| c | correction, the low-passed q(x) - s | rad |
| T | time constant | s |

The filter is complementary: the angle s + c follows the transducer slowly and the resolver quickly.
When samples are lost, the last c stays, so nothing jumps. Whether c is used is decided while the
machine stands still, and kept until it does so again.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_description.derived.actuator_kinematics import Linkages
from forest_description.geometry.linkage import angle_at
from forest_description.types import Vec3

Lengths = tuple[float, float]

SMOOTHING = 5.0  # [s] T, in which the transducers' noise averages out; chosen, not measured
FARTHEST = 0.1  # [rad] by which both may differ: beyond, one of them is broken, and nobody knows which


class Source(IntEnum):
    """What the angles of boom and stick are taken from."""

    JOINTS = 0
    CYLINDERS = 1


class AngleCorrection(NamedTuple):
    """The estimated errors of the resolvers."""

    boom: float = 0.0  # c [rad]
    stick: float = 0.0
    samples: int = 0  # of both transducers so far
    used: bool = False


UNREAD: Lengths = (math.nan, math.nan)  # [m] of cylinders that were not measured
NONE = AngleCorrection()


def updated_correction(
    c: AngleCorrection, s: Vec3, lengths: Lengths, linkages: Linkages, dt: float
) -> AngleCorrection:
    """Return the correction after a sample of the resolvers [rad] and of both cylinders [m; NaN: none].

    Thesis App. A, first two equations.
    """
    boom = angle_at(lengths[0], linkages[0]) - s[1]
    stick = angle_at(lengths[1], linkages[1]) - s[2]
    if not (abs(boom) <= FARTHEST and abs(stick) <= FARTHEST):  # neither is NaN
        return c
    count = c.samples + 1
    weight = max(1.0 / count, 1.0 - math.exp(-dt / SMOOTHING))  # the mean at first
    return AngleCorrection(
        c.boom + weight * (boom - c.boom), c.stick + weight * (stick - c.stick), count, c.used
    )


def latched_correction(c: AngleCorrection, wanted: int) -> AngleCorrection:
    """Return the correction of a machine at rest: from now on used, or not."""
    return AngleCorrection(c.boom, c.stick, c.samples, wanted == Source.CYLINDERS and c.samples > 0)


def corrected_angles(s: Vec3, c: AngleCorrection) -> Vec3:
    """Return the angles [rad] to control by."""
    return (s[0], s[1] + c.boom, s[2] + c.stick) if c.used else s
