"""The machine as URDF, for viewers and for whatever else reads /robot_description.

Frames: base_link is fixed to the carrier, origin on the swing axis at the height of the boom pivot, x
forward, y left, z up. Every link frame has x along the link and z up when the link is horizontal; boom and
stick turn about −y, so that a positive angle lifts. The joints are named as in /joint_states: swing, boom,
stick.

Inertias: the thesis' link frames have z along the joint axis and y across, so its I_zz is iyy here and its
I_yy is izz. It prints I_xx = 0, which no body can have; ixx = |iyy − izz| is the least possible, and the
dynamics hardly feel it.
"""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree

from forest_description.actuation import rated_speeds
from forest_description.kinematics import Vector
from forest_description.limits import Interval, joint_limits
from forest_description.linkage import lever_arm
from forest_description.machine import CylinderDrive, Machine

ORIGIN: Vector = (0.0, 0.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
LIFTING: Vector = (0.0, -1.0, 0.0)
HEAD_RADIUS = 0.35
"""Of the ball that stands for the head [m]; its inertia must be positive for most readers of URDF."""


class Inertial(NamedTuple):
    """Mass [kg], centre of mass [m] and principal inertias about it (ixx, iyy, izz) [kg·m²]."""

    mass: float
    centre: Vector
    inertia: Vector


def robot_description(machine: Machine) -> str:
    """Return the URDF text of a machine.

    Links base_link, platform, boom, stick, head and tip; revolute joints swing, boom, stick with the limits
    of the strokes; the tip frame at the end of the stick.
    """
    parts, robot = machine.manipulator, ElementTree.Element("robot", name=machine.name)
    ElementTree.SubElement(robot, "link", name="base_link")
    _platform(robot, machine)
    _beam(robot, "boom", parts.boom_length, 0.30, _boom_inertial(machine))
    _beam(robot, "stick", parts.stick_length, 0.22, _stick_inertial(machine))
    _head(robot, machine)
    ElementTree.SubElement(robot, "link", name="tip")
    _moving_joints(robot, machine)
    _joint(robot, "head", "fixed", "stick", "head", (parts.stick_length, 0.0, 0.0))
    _joint(robot, "tip", "fixed", "stick", "tip", (parts.stick_length, 0.0, 0.0))
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def _boom_inertial(machine: Machine) -> Inertial:
    """Return the boom's mass properties in its URDF frame."""
    m = machine.manipulator
    inertia = (abs(m.boom_zz - m.boom_yy), m.boom_zz, m.boom_yy)
    return Inertial(m.boom_mass, (m.boom_x, 0.0, m.boom_y), inertia)


def _stick_inertial(machine: Machine) -> Inertial:
    """Return the stick's mass properties, without the head, in its URDF frame."""
    m = machine.manipulator
    inertia = (abs(m.stick_zz - m.stick_yy), m.stick_zz, m.stick_yy)
    return Inertial(m.stick_mass, (m.stick_x, 0.0, m.stick_y), inertia)


def _platform(robot: ElementTree.Element, machine: Machine) -> None:
    """Add the turning platform.

    Only its inertia about the vertical is known; half of it is the least there can be about x and y.
    """
    m = machine.manipulator
    inertia = (0.5 * m.base_zz, 0.5 * m.base_zz, m.base_zz)
    link = _link(robot, "platform", Inertial(m.base_mass, (m.base_x, 0.0, 0.0), inertia))
    _visual(link, (0.0, 0.0, -0.4), "cylinder", radius="0.35", length="0.8")


def _beam(robot: ElementTree.Element, name: str, length: float, side: float, inertial: Inertial) -> None:
    """Add a link that looks like a square beam from its joint to the next."""
    link = _link(robot, name, inertial)
    _visual(link, (0.5 * length, 0.0, 0.0), "box", size=_text((length, side, side)))


def _head(robot: ElementTree.Element, machine: Machine) -> None:
    """Add the head as a small solid ball around the tip."""
    mass = machine.manipulator.head_mass
    moment = 0.4 * mass * HEAD_RADIUS**2
    link = _link(robot, "head", Inertial(mass, ORIGIN, (moment, moment, moment)))
    _visual(link, ORIGIN, "sphere", radius=f"{HEAD_RADIUS:g}")


def _moving_joints(robot: ElementTree.Element, machine: Machine) -> None:
    """Add swing, boom and stick with range, greatest torque and greatest rated speed."""
    swing_range, boom_range, stick_range = joint_limits(machine)
    speed, parts = rated_speeds(machine), machine.manipulator
    torque = machine.swing.gear_ratio * machine.swing.motor_displacement * machine.pump.supply_pressure
    swing = _joint(robot, "swing", "revolute", "base_link", "platform", ORIGIN, UP)
    _limit(swing, swing_range, torque, speed[0])
    boom = _joint(robot, "boom", "revolute", "platform", "boom", (parts.base_offset, 0.0, 0.0), LIFTING)
    _cylinder_limit(boom, boom_range, machine.boom, machine.pump.supply_pressure, speed[1])
    stick = _joint(robot, "stick", "revolute", "boom", "stick", (parts.boom_length, 0.0, 0.0), LIFTING)
    _cylinder_limit(stick, stick_range, machine.stick, machine.pump.supply_pressure, speed[2])


def _cylinder_limit(
    joint: ElementTree.Element, interval: Interval, drive: CylinderDrive, pressure: float, speed: float
) -> None:
    """Add the limits of a cylinder's joint: torque at the longest lever arm, speed at the shortest.

    The arm grows to min(a, b) and falls again along the stroke, so its least value is at an end.
    """
    longest = min(drive.pivot_to_base, drive.pivot_to_rod)
    shortest = min(lever_arm(angle, drive.linkage) for angle in interval)
    _limit(joint, interval, longest * drive.head_area * pressure, speed / shortest)


def _link(robot: ElementTree.Element, name: str, inertial: Inertial) -> ElementTree.Element:
    """Add a link with its mass properties."""
    link = ElementTree.SubElement(robot, "link", name=name)
    element = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(element, "origin", xyz=_text(inertial.centre), rpy=_text(ORIGIN))
    ElementTree.SubElement(element, "mass", value=repr(inertial.mass))
    moments = dict(zip(("ixx", "iyy", "izz"), map(repr, inertial.inertia), strict=True))
    ElementTree.SubElement(element, "inertia", {**moments, "ixy": "0", "ixz": "0", "iyz": "0"})
    return link


def _visual(link: ElementTree.Element, centre: Vector, shape: str, **size: str) -> None:
    """Add what a viewer draws for a link."""
    visual = ElementTree.SubElement(link, "visual")
    ElementTree.SubElement(visual, "origin", xyz=_text(centre), rpy=_text(ORIGIN))
    ElementTree.SubElement(ElementTree.SubElement(visual, "geometry"), shape, size)


def _joint(
    robot: ElementTree.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    place: Vector,
    axis: Vector | None = None,
) -> ElementTree.Element:
    """Add a joint at ``place`` in the parent's frame."""
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=_text(place), rpy=_text(ORIGIN))
    if axis is not None:
        ElementTree.SubElement(joint, "axis", xyz=_text(axis))
    return joint


def _limit(joint: ElementTree.Element, interval: Interval, effort: float, speed: float) -> None:
    """Add the range [rad], greatest torque [N·m] and greatest speed [rad/s] of a joint."""
    lower, upper = map(repr, interval)
    ElementTree.SubElement(
        joint, "limit", lower=lower, upper=upper, effort=repr(effort), velocity=repr(speed)
    )


def _text(numbers: Vector) -> str:
    """Return three numbers as URDF writes them, with all their digits."""
    return " ".join(repr(number) for number in numbers)
