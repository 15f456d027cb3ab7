"""Where the links of a URDF are, for given joint positions.

Directions and frames as in REP-103: metres, radians, x forward, y left, z up; quaternions x, y, z, w.
A joint's frame is its child link's: the origin in the parent's frame, turned or shifted by the
joint's position along its axis.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from forest_description.types import Quaternion, Vec3

ZERO: Vec3 = (0.0, 0.0, 0.0)


class Joint(NamedTuple):
    """A joint of a URDF; a follower's position is offset + multiplier times its leader's."""

    name: str
    kind: str
    parent: str
    child: str
    xyz: Vec3  # [m]
    rpy: Vec3  # [rad]
    axis: Vec3
    leader: str = ""
    multiplier: float = 0.0
    offset: float = 0.0


class Transform(NamedTuple):
    """Frame `child` in frame `parent`."""

    parent: str
    child: str
    translation: Vec3  # [m]
    rotation: Quaternion


def urdf_joints(urdf: str) -> tuple[Joint, ...]:
    """Return the joints of a URDF.

    Raises:
        ValueError: the text is no URDF.
    """
    try:
        robot = ElementTree.fromstring(urdf)
        return tuple(_joint(element) for element in robot.iter("joint") if element.find("child") is not None)
    except (ElementTree.ParseError, AttributeError, KeyError) as error:
        raise ValueError(f"robot_description is no URDF: {error}") from error


def fixed_frames(joints: Sequence[Joint]) -> list[Transform]:
    """Return the frames that never move."""
    return [_transform(joint, 0.0) for joint in joints if joint.kind == "fixed"]


def moving_frames(joints: Sequence[Joint], positions: Mapping[str, float]) -> list[Transform]:
    """Return the frames of the moving joints.

    Args:
        joints: Of the URDF.
        positions: By joint [rad, m]; one that is not told follows its leader, or stands at 0.
    """
    return [_transform(joint, _position(joint, positions)) for joint in joints if joint.kind != "fixed"]


def _position(joint: Joint, positions: Mapping[str, float]) -> float:
    if joint.name in positions:
        return positions[joint.name]
    return joint.offset + joint.multiplier * positions.get(joint.leader, 0.0)


def _transform(joint: Joint, position: float) -> Transform:
    turned = _from_rpy(joint.rpy)
    if joint.kind == "prismatic":
        shift = _turned(turned, joint.axis)
        x, y, z = (a + position * b for a, b in zip(joint.xyz, shift, strict=True))
        return Transform(joint.parent, joint.child, (x, y, z), turned)
    if joint.kind == "fixed":
        return Transform(joint.parent, joint.child, joint.xyz, turned)
    return Transform(joint.parent, joint.child, joint.xyz, _product(turned, _about(joint.axis, position)))


def _joint(element: ElementTree.Element) -> Joint:
    parts = {part.tag: part.attrib for part in element}
    origin, mimic = parts.get("origin", {}), parts.get("mimic", {})
    return Joint(
        element.attrib["name"],
        element.attrib["type"],
        parts["parent"]["link"],
        parts["child"]["link"],
        _numbers(origin.get("xyz", "0 0 0")),
        _numbers(origin.get("rpy", "0 0 0")),
        _numbers(parts.get("axis", {}).get("xyz", "1 0 0")),
        mimic.get("joint", ""),
        float(mimic.get("multiplier", 1.0)) if mimic else 0.0,
        float(mimic.get("offset", 0.0)),
    )


def _numbers(text: str) -> Vec3:
    x, y, z = map(float, text.split())
    return x, y, z


def _about(axis: Vec3, angle: float) -> Quaternion:
    s, c = math.sin(0.5 * angle), math.cos(0.5 * angle)
    return axis[0] * s, axis[1] * s, axis[2] * s, c


def _from_rpy(rpy: Vec3) -> Quaternion:
    """Roll about x, then pitch about the fixed y, then yaw about the fixed z."""
    roll, pitch, yaw = (
        _about(axis, angle) for axis, angle in zip(((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)), rpy, strict=True)
    )
    return _product(yaw, _product(pitch, roll))


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _turned(q: Quaternion, v: Vec3) -> Vec3:
    back = (-q[0], -q[1], -q[2], q[3])
    x, y, z, _ = _product(_product(q, (*v, 0.0)), back)
    return x, y, z
