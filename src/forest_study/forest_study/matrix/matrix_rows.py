"""The rows of the matrix: what is driven, on which plants, and what is aimed at.

A seed's plant is the same in every row, but for what the row takes away or adds. Controller and driver
believe the machine's file. Sensors sample at 200 Hz (even half of eight seeds) or 50 Hz, calibrated; the
joystick has 8 bits and speaks at 200, 100, 50 or 20 Hz, by the seed.

What differs from the file comes in factors. A row may be drawn with one factor only, or with all but one:
a seed's values of the factors that stay are the same.
"""

import math
from collections.abc import Collection
from typing import NamedTuple

from forest_control.taught.tip_path import TipPath, polyline
from forest_description.types import Vec3
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.tracking.paths import NAMES, path_named

HIDDEN = Ranges(
    deadband=0.2, gain=0.2, head_mass=1.0, spool=math.sqrt(2.0), stiffness=0.2, tilt=10.0, head=2000.0,
    dead_time=0.02, hysteresis=0.0, backlash=0.0, oil=80.0,
)  # fmt: skip
AS_FILED = Ranges(deadband=0.0, gain=0.0, head_mass=1.0, spool=1.0)
PLANT = (
    *("gain", "deadband", "stiffness", "spool", "dead_time", "oil", "head", "tilt", "hysteresis", "backlash"),
    "bending",
)
FACTORS = (*PLANT, "sensors", "joystick")
HYSTERESIS, BACKLASH = 0.3, 0.2  # [V]; [deg]
BENDING = 0.5  # [1] by which the links' stiffness is off: an assumed beam, not a measured one
LOG = 1200.0  # [kg]
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
    ranges: Ranges
    paths: tuple[TipPath, ...]
    speeds: tuple[float, ...]  # [m/s], by the seed in turn
    aim: Aim
    sensors: bool = True  # sampled at 200 or 50 Hz; else as the file says
    joystick: bool = True  # of 8 bits at 20 to 200 Hz; else exact, at 200 Hz
    load: float = 0.0  # [kg] of a log that is grasped and dropped where the path starts; 0: it is driven


def matrix_rows() -> dict[str, MatrixRow]:
    """Return the rows by their names."""
    five = tuple(path_named(name) for name in NAMES)
    plain = MatrixRow("plain", "0.5 m/s, no hysteresis, no backlash", HIDDEN, five, (0.5,), Aim(3.0, 8.0))
    exact = plain._replace(name="exact", text="the machine as believed, 0.5 m/s", aim=Aim(0.8, 3.0))
    fast = plain._replace(
        name="fast", text="1 m/s, no hysteresis, no backlash", speeds=(1.0,), aim=Aim(8.0, 20.0)
    )
    hysteresis = plain._replace(
        name="hysteresis",
        text="0.5 m/s, 0 to 0.3 V of hysteresis",
        ranges=HIDDEN._replace(hysteresis=HYSTERESIS),
        aim=Aim(5.0, 10.0),
    )
    backlash = hysteresis._replace(
        name="backlash", text="0.5 m/s, 0 to 0.2° of backlash", ranges=HIDDEN._replace(backlash=BACKLASH)
    )
    both = HIDDEN._replace(hysteresis=HYSTERESIS, backlash=BACKLASH)
    bending = plain._replace(
        name="bending",
        text="as believed but for links 50 % softer to stiffer, 0.5 m/s",
        ranges=HIDDEN._replace(bending=BENDING),
        aim=Aim(),
    )
    rows = (
        drawn_from(exact, ()),
        plain,
        hysteresis,
        backlash,
        hysteresis._replace(name="both", text="0.5 m/s, hysteresis and backlash", ranges=both),
        fast,
        *_short_rows(five, both),
        drawn_from(bending, ("bending",)),
        _load_row(),
    )
    return {row.name: row for row in rows}


def _short_rows(paths: tuple[TipPath, ...], ranges: Ranges) -> tuple[MatrixRow, MatrixRow]:
    """Return the rows of slow motion, on the middles of three paths, and of short motion."""
    aim = Aim(velocity_rms=0.01)
    slow = tuple(map(_middle, paths[:3]))
    inch = Aim(end_mm=2.0, overshoot_mm=3.0)
    return (
        MatrixRow("slow", "0.4 m at 0.02, 0.05, 0.1 m/s, both", ranges, slow, (0.02, 0.05, 0.1), aim),
        MatrixRow(
            "inch", "2 cm in 0.5 s from rest, both", ranges, tuple(map(_inch, INCHES)), (INCH_SPEED,), inch
        ),
    )


def _load_row() -> MatrixRow:
    """Return the row in which a log is grasped and dropped."""
    return MatrixRow(
        "load",
        "1.2 t grasped and dropped at rest; overshoot beyond shut valves', time until within 5 mm",
        HIDDEN._replace(head=None),
        (_inch("up"),),
        (INCH_SPEED,),
        Aim(),
        load=LOG,
    )


def drawn_from(row: MatrixRow, factors: Collection[str]) -> MatrixRow:
    """Return a row whose plants differ from the file in these factors alone."""
    own = {name: getattr(row.ranges, name) for name in PLANT if name in factors}
    return row._replace(
        ranges=AS_FILED._replace(**own), sensors="sensors" in factors, joystick="joystick" in factors
    )


def apart(row: MatrixRow, only: Collection[str], without: Collection[str]) -> list[MatrixRow]:
    """Return a row with each factor alone, then with all but each; the row itself if none is named."""
    alone = [_named(row, f"only {name}", (name,)) for name in only]
    others = [_named(row, f"without {name}", {*FACTORS} - {name}) for name in without]
    return [*alone, *others] or [row]


def _named(row: MatrixRow, text: str, factors: Collection[str]) -> MatrixRow:
    return drawn_from(row, factors)._replace(name=f"{row.name}, {text}", text=row.text)


def _middle(path: TipPath) -> TipPath:
    """Return the middle of a straight path."""
    begin, end = (0.5 * (path.length + side * SHORT) for side in (-1.0, 1.0))
    return polyline(path.name, [path.at(begin), path.at(end)])


def _inch(name: str) -> TipPath:
    x, y, z = (a + b for a, b in zip(INCH_FROM, INCHES[name], strict=True))
    return polyline(name, [INCH_FROM, (x, y, z)])
