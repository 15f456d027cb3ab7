"""The rows of the matrix: what is driven, on which plants, and what is aimed at.

A seed's plant is the same in every row, but for what the row takes away or adds. Controller and driver
believe the machine's file. Sensors sample at 200 Hz (even half of eight seeds) or 50 Hz, calibrated; the
joystick has 8 bits and speaks at 200, 100, 50 or 20 Hz, by the seed.
"""

import math
from typing import NamedTuple

from forest_control.taught.tip_path import TipPath, polyline
from forest_description.types import Vec3
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.tracking.paths import NAMES, path_named

HIDDEN = Ranges(
    deadband=0.2, gain=0.2, head_mass=1.0, spool=math.sqrt(2.0), stiffness=0.2, tilt=10.0, head=2000.0,
    dead_time=0.02, hysteresis=0.0, backlash=0.0, oil=80.0,
)  # fmt: skip
HYSTERESIS, BACKLASH = 0.3, 0.2  # [V]; [deg]
INCHES: dict[str, Vec3] = {"out": (0.02, 0.0, 0.0), "left": (0.0, 0.02, 0.0), "up": (0.0, 0.0, 0.02)}
INCH_FROM: Vec3 = (5.9, 0.0, 0.8)  # [m]
INCH_SPEED = 0.05  # [m/s] 2 cm take 0.5 s with ramps of 0.5 m/s^2
SHORT = 0.4  # [m] of the slow paths: at 0.02 m/s one takes 20 s


class Aim(NamedTuple):
    """What a row shall reach with its worst seed; None: nothing is aimed at."""

    rms_mm: float | None = None  # cross-track, and from the governed reference
    max_mm: float | None = None
    velocity_rms: float | None = None  # [m/s]
    end_mm: float | None = None
    overshoot_mm: float | None = None


class MatrixRow(NamedTuple):
    """A row of the matrix."""

    name: str
    text: str
    ranges: Ranges | None  # None: the machine itself, its sensors and joystick at 200 Hz
    paths: tuple[TipPath, ...]
    speeds: tuple[float, ...]  # [m/s], by the seed in turn
    aim: Aim


def matrix_rows() -> dict[str, MatrixRow]:
    """Return the rows by their names."""
    five = tuple(path_named(name) for name in NAMES)
    both = HIDDEN._replace(hysteresis=HYSTERESIS, backlash=BACKLASH)
    plain, played = Aim(3.0, 8.0), Aim(5.0, 10.0)
    rows = (
        MatrixRow("exact", "the machine as believed, 0.5 m/s", None, five, (0.5,), Aim(0.8, 3.0)),
        MatrixRow("plain", "0.5 m/s, no hysteresis, no backlash", HIDDEN, five, (0.5,), plain),
        MatrixRow(
            "hysteresis",
            "0.5 m/s, 0 to 0.3 V of hysteresis",
            HIDDEN._replace(hysteresis=HYSTERESIS),
            five,
            (0.5,),
            played,
        ),
        MatrixRow(
            "backlash",
            "0.5 m/s, 0 to 0.2° of backlash",
            HIDDEN._replace(backlash=BACKLASH),
            five,
            (0.5,),
            played,
        ),
        MatrixRow("both", "0.5 m/s, hysteresis and backlash", both, five, (0.5,), played),
        MatrixRow("fast", "1 m/s, no hysteresis, no backlash", HIDDEN, five, (1.0,), Aim(8.0, 20.0)),
        MatrixRow(
            "slow",
            "0.4 m at 0.02, 0.05, 0.1 m/s, both",
            both,
            tuple(map(_middle, five[:3])),
            (0.02, 0.05, 0.1),
            Aim(velocity_rms=0.01),
        ),
        MatrixRow(
            "inch",
            "2 cm in 0.5 s from rest, both",
            both,
            tuple(map(_inch, INCHES)),
            (INCH_SPEED,),
            Aim(end_mm=2.0, overshoot_mm=3.0),
        ),
    )
    return {row.name: row for row in rows}


def _middle(path: TipPath) -> TipPath:
    """Return the middle of a straight path."""
    begin, end = (0.5 * (path.length + side * SHORT) for side in (-1.0, 1.0))
    return polyline(path.name, [path.at(begin), path.at(end)])


def _inch(name: str) -> TipPath:
    x, y, z = (a + b for a, b in zip(INCH_FROM, INCHES[name], strict=True))
    return polyline(name, [INCH_FROM, (x, y, z)])
