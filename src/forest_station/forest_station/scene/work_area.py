"""Where the tip can be: the outline of its reach in the crane's plane, and its trace on the ground."""

import math

import numpy as np

from forest_station.scene.scene_elements import Joint, WorkArea
from forest_station.scene.urdf_tree import TIP, SceneError, frames

STEPS = 24  # of an edge of the outline: its chords stay within a centimetre of the arcs


def work_area(joints: list[Joint], ground: float) -> WorkArea:
    """Return the tip's reach over the ranges of boom and stick, the stick folded.

    The outline follows the image of the four edges of the box of angles. With a stick that is
    folded (-180 to 0 deg) over its whole range no pose within the box lies outside of it.

    Args:
        joints: As `urdf_tree.joints_of` returns them.
        ground: Height of the ground [m].

    Raises:
        SceneError: There is no swing, boom or stick with limits, or no tip.
    """
    swing, boom, stick = (_limit(joints, name) for name in ("swing", "boom", "stick"))
    folded = [max(stick[0], -math.pi), min(stick[1], 0.0)]
    section = [_tip(joints, boom_angle, stick_angle) for boom_angle, stick_angle in _edges(boom, folded)]
    return WorkArea(section=section, ground=_radii(section, ground), swing=swing)


def _limit(joints: list[Joint], name: str) -> list[float]:
    joint = next((joint for joint in joints if joint["name"] == name), None)
    if joint is None or joint["limit"] is None:
        raise SceneError(f"robot description: no joint {name!r} with limits")
    return joint["limit"]


def _edges(boom: list[float], stick: list[float]) -> list[tuple[float, float]]:
    """Return angles once around the box, without the first pose again."""
    up, out = (np.linspace(low, high, STEPS).tolist() for low, high in (boom, stick))
    around = [(angle, stick[1]) for angle in up[:-1]]
    around += [(boom[1], angle) for angle in out[:0:-1]]
    around += [(angle, stick[0]) for angle in up[:0:-1]]
    return [*around, *((boom[0], angle) for angle in out[:-1])]


def _tip(joints: list[Joint], boom: float, stick: float) -> list[float]:
    """Return the tip (r, z) [m] with the swing straight ahead."""
    found = frames(joints, {"boom": boom, "stick": stick})
    if TIP not in found:
        raise SceneError(f"robot description: no link {TIP!r} hangs from the base")
    return [float(found[TIP][0, 3]), float(found[TIP][2, 3])]


def _radii(section: list[list[float]], ground: float) -> list[float] | None:
    """Return least and greatest distance from the swing axis on the ground [m], None if out of reach."""
    crossings = []
    for (r, z), (next_r, next_z) in zip(section, section[1:] + section[:1], strict=True):
        if (z > ground) != (next_z > ground):
            crossings.append(r + (next_r - r) * (ground - z) / (next_z - z))
    return [max(0.0, min(crossings)), max(crossings)] if crossings else None
