"""The crane's slow oscillations over its workspace, valves shut; with dry friction, small and large ones."""

from typing import NamedTuple

import numpy as np

from forest_description.derived.limits import workspace_limits
from forest_description.machine import Machine
from forest_description.types import AXES
from forest_sim.analysis.friction_linearisation import without_dry_friction
from forest_sim.analysis.modes import SHUT, Mode, modes, slow_modes
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.open_loop import RunError, start_angles


class MapPoint(NamedTuple):
    """The slow modes by axis with the tip at a place of the crane's plane, valves shut."""

    reach: float  # [m] from the swing axis
    height: float  # [m] over the boom's pivot
    modes: dict[str, Mode | None]  # of small oscillations
    sliding: dict[str, Mode | None]  # of large ones, without dry friction; the same where there is none


def mode_map(machine: Machine, spacing: float) -> list[MapPoint]:
    """Return the slow modes over the workspace, on a square grid [m] of tip places that the strokes reach."""
    w, p = workspace_limits(machine), plant_parameters(machine)
    free = without_dry_friction(p)
    points = []
    for reach in np.arange(max(spacing, w.reach_min), w.reach_max, spacing).tolist():
        for height in np.arange(w.height_min, w.height_max, spacing).tolist():
            try:
                angles = start_angles(machine, (reach, 0.0, height))
            except RunError:
                continue
            small = slow_modes(modes(angles, SHUT, p))
            large = small if free == p else slow_modes(modes(angles, SHUT, free))
            points.append(MapPoint(reach, height, small, large))
    return points


def map_csv(points: list[MapPoint]) -> str:
    """Return the map as CSV: frequency and damping of each axis, empty where it has no oscillation."""
    names = [
        f"{axis}{which}_{what}"
        for which in ("", "_sliding")
        for axis in AXES
        for what in ("frequency[Hz]", "damping[1]")
    ]
    lines = [",".join(("reach[m]", "height[m]", *names))]
    for point in points:
        cells = [
            "," if mode is None else f"{mode.frequency:.6g},{mode.damping:.6g}"
            for found in (point.modes, point.sliding)
            for mode in (found[axis] for axis in AXES)
        ]
        lines.append(",".join((f"{point.reach:.4f}", f"{point.height:.4f}", *cells)))
    return "\n".join(lines) + "\n"


def ranges(found: list[dict[str, Mode | None]]) -> str:
    """Return the extremes of each axis' slow mode over many poses, a line for each axis."""
    lines = []
    for axis in AXES:
        oscillations = [mode for modes_by_axis in found if (mode := modes_by_axis[axis]) is not None]
        if not oscillations:
            lines.append(f"  {axis:<6} no oscillation")
            continue
        frequency, damping = zip(*((m.frequency, m.damping) for m in oscillations), strict=True)
        part = "" if len(oscillations) == len(found) else f", in {len(oscillations)} of {len(found)} poses"
        lines.append(
            f"  {axis:<6} {min(frequency):6.2f} .. {max(frequency):6.2f} Hz, "
            f"damping ratio {min(damping):.3f} .. {max(damping):.3f}{part}"
        )
    return "\n".join(lines)
