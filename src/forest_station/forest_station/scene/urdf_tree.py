"""A URDF's links and joints, and where they are at given joint positions."""

import math
from collections.abc import Mapping
from functools import lru_cache
from xml.etree import ElementTree

import numpy as np

from forest_description.types import AXES, Floats
from forest_msgs_py.interfaces import topics
from forest_station.scene.scene_elements import Joint, Mimic, Visual

MOVING = ("revolute", "continuous", "prismatic")
BASE = "base_link"
TIP = "tip"
SOURCES = {joint: row.name for row in (topics.JOINT_STATES, topics.GROUND_TRUTH_HEAD) for joint in row.labels}
"""Topics that tell a joint's position; those of the cylinders the server computes."""


class SceneError(ValueError):
    """A robot description that cannot be drawn; the text tells what is wrong with it."""


def robot_of(text: str) -> ElementTree.Element:
    """Return the root element of a URDF text.

    Raises:
        SceneError: The text is no URDF.
    """
    try:
        robot = ElementTree.fromstring(text.encode())
    except ElementTree.ParseError as error:
        raise SceneError(f"robot description: {error}; allowed: a URDF text") from error
    if robot.tag != "robot":
        raise SceneError(f"robot description: its root is <{robot.tag}>; allowed: <robot>")
    return robot


def links_of(robot: ElementTree.Element) -> dict[str, list[Visual]]:
    """Return each link's visuals; a mesh, which the page does not draw, is left out."""
    return {
        link.get("name", ""): [drawn for visual in link.iter("visual") if (drawn := _visual(visual))]
        for link in robot.iter("link")
    }


def joints_of(robot: ElementTree.Element) -> list[Joint]:
    """Return the joints, each behind the one that moves its parent.

    Raises:
        SceneError: A joint hangs from nothing, or in a circle.
    """
    waiting = [_joint(element) for element in robot.findall("joint")]
    children = {joint["child"] for joint in waiting}
    known = {name for name in links_of(robot) if name not in children}
    ordered: list[Joint] = []
    while waiting:
        ready = [joint for joint in waiting if joint["parent"] in known]
        if not ready:
            lost = waiting[0]
            raise SceneError(f"robot description: joint {lost['name']!r} hangs from {lost['parent']!r}")
        ordered += ready
        known |= {joint["child"] for joint in ready}
        waiting = [joint for joint in waiting if joint not in ready]
    return ordered


def frames(joints: list[Joint], positions: Mapping[str, float]) -> dict[str, Floats]:
    """Return the frame of every link that hangs from `BASE`, 4x4 [m].

    Args:
        joints: As `joints_of` returns them.
        positions: Joint positions by name [rad, m]; a joint that is absent stands at 0.
    """
    found: dict[str, Floats] = {BASE: np.eye(4)}
    for joint in joints:
        if joint["parent"] in found:
            placed = found[joint["parent"]] @ _fixed(tuple(joint["xyz"]), tuple(joint["rpy"]))
            found[joint["child"]] = placed @ _motion(joint, positions.get(joint["name"], 0.0))
    return found


def _visual(element: ElementTree.Element) -> Visual | None:
    """Return a visual, None for a shape that the page does not draw."""
    geometry = element.find("geometry")
    shape = geometry[0] if geometry is not None and len(geometry) else None
    if shape is None:
        return None
    sizes = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}
    if shape.tag not in sizes:
        return None
    size = [float(number) for key in sizes[shape.tag] for number in shape.get(key, "").split()]
    xyz, rpy = _origin(element)
    return Visual(shape=shape.tag, size=size, xyz=xyz, rpy=rpy)


def _joint(element: ElementTree.Element) -> Joint:
    """Return a joint with its signal: of a driven one as measured, of a cylinder's as computed."""
    name, kind = element.get("name", ""), element.get("type", "fixed")
    xyz, rpy = _origin(element)
    limit, source = element.find("limit"), SOURCES.get(name, "crane")
    return Joint(
        name=name,
        type=kind,
        parent=_attribute(element, "parent", "link", ""),
        child=_attribute(element, "child", "link", ""),
        xyz=xyz,
        rpy=rpy,
        axis=_numbers(_attribute(element, "axis", "xyz", "1 0 0")),
        limit=None if limit is None else [float(limit.get(end, "0")) for end in ("lower", "upper")],
        mimic=_mimic(element),
        signal=f"{source}/{name}.position" if kind in MOVING else None,
        deflection=f"{topics.GROUND_TRUTH_DEFLECTIONS.name}/{name}" if name in AXES else None,
    )


def _mimic(element: ElementTree.Element) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
    return Mimic(joint=mimic.get("joint", ""), multiplier=multiplier, offset=offset)


def _origin(element: ElementTree.Element) -> tuple[list[float], list[float]]:
    xyz, rpy = (_numbers(_attribute(element, "origin", key, "0 0 0")) for key in ("xyz", "rpy"))
    return xyz, rpy


def _attribute(element: ElementTree.Element, child: str, key: str, default: str) -> str:
    found = element.find(child)
    return default if found is None else found.get(key, default)


def _numbers(text: str) -> list[float]:
    return [float(number) for number in text.split()]


@lru_cache(maxsize=128)  # a scene asks for the same joints at a hundred poses
def _fixed(xyz: tuple[float, ...], rpy: tuple[float, ...]) -> Floats:
    """Return a displacement, then turns about z, y and x: URDF's fixed-axis roll, pitch, yaw."""
    roll, pitch, yaw = rpy
    matrix = _turn([0.0, 0.0, 1.0], yaw) @ _turn([0.0, 1.0, 0.0], pitch) @ _turn([1.0, 0.0, 0.0], roll)
    matrix[:3, 3] = xyz
    return matrix


def _motion(joint: Joint, position: float) -> Floats:
    """Return what a joint's position [rad, m] adds to its frame."""
    if joint["type"] == "prismatic":
        matrix: Floats = np.eye(4)
        matrix[:3, 3] = np.array(joint["axis"]) * position
        return matrix
    return _turn(joint["axis"], position if joint["type"] in MOVING else 0.0)


def _turn(axis: list[float], angle: float) -> Floats:
    """Return the turn by an angle [rad] about an axis through the origin (Rodrigues)."""
    x, y, z = np.array(axis) / math.hypot(*axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix: Floats = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return matrix
