"""The five paths of the tip that are tracked by name, and paths of waypoints from a file."""

import csv
import math
from functools import cache
from pathlib import Path

from forest_control.taught.tip_path import PathError, TipPath, polyline
from forest_description.types import Vec3

NAMES = ("sweep", "radial", "vertical", "circle_h", "circle_v")
CENTRE: Vec3 = (5.9, 0.0, 0.8)  # [m] of both circles, radius 1 m


def path_named(name: str) -> TipPath:
    """Return one of the five paths, or that of a CSV file of waypoints with the columns x, y, z [m].

    Raises:
        PathError: the file cannot be read, or holds no path.
    """
    return _named(name) if name in NAMES else polyline(Path(name).stem, _waypoints(Path(name)))


@cache
def _named(name: str) -> TipPath:
    """Return one of the five, each time the same."""
    if name == "sweep":
        return polyline(name, [(5.6, -2.5, 1.0), (5.6, 2.5, 1.0)])
    if name == "radial":
        return polyline(name, [(4.7, 0.0, 0.5), (7.2, 0.0, 0.5)])
    if name == "vertical":
        return polyline(name, [(6.0, 0.0, -0.5), (6.0, 0.0, 2.0)])
    return _circle(name)


def _circle(name: str) -> TipPath:
    x, y, z = CENTRE
    if name == "circle_h":
        return TipPath(
            name, 2.0 * math.pi, lambda s: (x - math.cos(s), y + math.sin(s), z), (0.0, 2.0 * math.pi)
        )
    return TipPath(name, 2.0 * math.pi, lambda s: (x - math.cos(s), y, z + math.sin(s)), (0.0, 2.0 * math.pi))


def _waypoints(file: Path) -> list[Vec3]:
    try:
        with file.open(newline="", encoding="utf-8-sig") as text:
            rows = [row for row in csv.reader(text) if row]
    except (OSError, ValueError, csv.Error) as error:  # a name may hold what no name may, a file no text
        known = ", ".join(NAMES)
        raise PathError(f"{file}: no path of this name ({known}), nor a readable file: {error}") from error
    if not rows or tuple(cell.strip() for cell in rows[0]) != ("x", "y", "z"):
        raise PathError(f"{file}: the header must be x,y,z")
    points = []
    for line, row in enumerate(rows[1:], start=2):
        try:
            x, y, z = map(float, row)
        except ValueError as error:
            raise PathError(f"{file}:{line}: not three numbers x, y, z [m]") from error
        if not all(map(math.isfinite, (x, y, z))):
            raise PathError(f"{file}:{line}: not three finite numbers x, y, z [m]")
        points.append((x, y, z))
    return points
