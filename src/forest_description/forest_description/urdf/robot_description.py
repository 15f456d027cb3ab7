"""The machine as URDF, for viewers and for whatever else reads /robot_description.

Frames: base_link is fixed to the carrier, origin on the swing axis at the height of the boom pivot,
x forward, y left, z up. Every link frame has x along the link and z up when the link is horizontal;
boom and stick turn about −y, so that a positive angle lifts. The joints are named as in
/joint_states: swing, boom, stick.

Inertias are those of the dynamics, exactly: head and log are in the stick's unless they hang. The
thesis' link frames have z along the joint axis and y across, so its I_zz is iyy here, its I_yy izz
and its product I_xy -ixz. Appendix B's I_xx = 0, which no body can have, stays zero in
`c180_thesis`. Of the platform only the inertia about the vertical is known; half of it is the least
there can be about x and y.

Cylinders are drawn, without mass. URDF has no closed loops: barrel and rod hang in the tree by
joints of their own (`passive_joints.CYLINDER_JOINTS`). Their positions may stand in the same
message as swing, boom and stick; where they do not, they follow boom and stick about (mimic; the
rod's eye is up to 0.17 m off). The two joints of a hanging head (`HEAD_JOINTS`) need their
positions in the message.
"""

import dataclasses
import math
from xml.etree import ElementTree

from forest_description.derived.actuator_kinematics import rated_speeds
from forest_description.derived.bodies import PlanarBody, boom_body, hanging_body, stick_body
from forest_description.derived.limits import Interval, joint_limits
from forest_description.derived.passive_joints import (
    CYLINDER_JOINTS,
    HEAD_JOINTS,
    barrel_pivot,
    cylinder_followers,
)
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import Machine
from forest_description.mechanics.drives import CylinderDrive
from forest_description.mechanics.load import Log
from forest_description.types import Vec3
from forest_description.urdf.urdf_elements import (
    ORIGIN,
    Inertial,
    joint,
    limit,
    link,
    material,
    mimic,
    text,
    visual,
)

FORWARD: Vec3 = (1.0, 0.0, 0.0)
UP: Vec3 = (0.0, 0.0, 1.0)
LIFTING: Vec3 = (0.0, -1.0, 0.0)
ALONG_X: Vec3 = (0.0, 0.5 * math.pi, 0.0)
"""Roll, pitch, yaw that lay a cylinder's axis along x."""
ALONG_Y: Vec3 = (0.5 * math.pi, 0.0, 0.0)
COLOURS: dict[str, Vec3] = {
    "paint": (0.90, 0.66, 0.18),
    "cast": (0.29, 0.33, 0.36),
    "barrel": (0.18, 0.22, 0.25),
    "rod": (0.87, 0.91, 0.93),
    "wood": (0.60, 0.45, 0.31),
}
"""Red, green, blue 0..1, as the operator's page has them."""
BOOM_SLENDERNESS, STICK_SLENDERNESS = 14.0, 20.0
"""Length over thickness of the beams that stand for boom and stick."""
HEAD_DENSITY = 3900.0
"""Of the ball that stands for the head [kg/m^3]: half steel, half air; only its mass is known."""
LOG_LENGTH, LOG_DENSITY = 4.0, 850.0
"""Of the cylinder that stands for a log [m], [kg/m^3]: green spruce; only its mass is known."""
WALL, EYE = 0.01, 0.1
"""Of a cylinder's barrel, and the length of its eye [m]."""
BAR = 0.3
"""Thickness of the bar that a head hangs from, over the head's radius."""
PASSIVE_SPEED = 10.0
"""Greatest speed of joints that nothing drives [rad/s, m/s]."""


def robot_description(machine: Machine) -> str:
    """Return the URDF text of a machine.

    Links base_link, platform, boom, stick, head and tip; revolute joints swing, boom, stick with
    the limits of the strokes; the tip frame at the end of the stick; barrels and rods of the two
    cylinders.
    """
    parts, robot = machine.manipulator, ElementTree.Element("robot", name=machine.name)
    for name, colour in COLOURS.items():
        material(robot, name, colour)
    link(robot, "base_link")
    _platform(robot, machine)
    _beam(robot, "boom", parts.boom_length, BOOM_SLENDERNESS, boom_body(parts))
    _beam(robot, "stick", parts.stick_length, STICK_SLENDERNESS, stick_body(parts))
    _moving_joints(robot, machine)
    _head(robot, machine)
    link(robot, "tip")
    joint(robot, "tip", "fixed", ("stick", "tip"), (parts.stick_length, 0.0, 0.0))
    _cylinders(robot, machine)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def _platform(robot: ElementTree.Element, machine: Machine) -> None:
    """Add the turning platform."""
    m = machine.manipulator
    diagonal = (0.5 * m.base_zz, 0.5 * m.base_zz, m.base_zz)
    platform = link(robot, "platform", Inertial(m.base_mass, (m.base_x, 0.0, 0.0), diagonal, 0.0))
    visual(platform, "cast", "cylinder", (0.0, 0.0, -0.4), radius="0.35", length="0.8")


def _beam(robot: ElementTree.Element, name: str, length: float, slenderness: float, body: PlanarBody) -> None:
    """Add a link that looks like a square beam from its joint to the next."""
    side = length / slenderness
    inertial = Inertial(body.mass, (body.x, 0.0, body.y), (body.xx, body.zz, body.yy), -body.xy)
    size = text((length, side, side))
    visual(link(robot, name, inertial), "paint", "box", (0.5 * length, 0.0, 0.0), size=size)


def _head(robot: ElementTree.Element, machine: Machine) -> None:
    """Add the head as a ball, and its log: at the tip, part of the stick, or under a joint with two axes."""
    m, hanging = machine.manipulator, hanging_body(machine.manipulator)
    tip = (m.stick_length, 0.0, 0.0)
    ball = max(0.05, (0.75 * m.head_mass / (math.pi * HEAD_DENSITY)) ** (1.0 / 3.0))
    if m.pendulum is None or hanging is None:
        head = link(robot, "head")
        visual(head, "cast", "sphere", radius=repr(ball))
        if m.log is not None:
            _log(head, m.log, (m.log.x, 0.0, m.log.y))
        joint(robot, "head", "fixed", ("stick", "head"), tip)
        return
    pitch, yaw = hanging.inertia + hanging.log_inertia, hanging.log_inertia
    diagonal, centre = (hanging.inertia, pitch, yaw), (0.0, 0.0, -hanging.length)
    link(robot, "head_cross")
    head = link(robot, "head", Inertial(hanging.mass, centre, diagonal, 0.0))
    empty = hanging_body(dataclasses.replace(m, log=None)) or hanging
    visual(head, "cast", "sphere", (0.0, 0.0, -empty.length), radius=repr(ball))
    bar = text((BAR * ball, BAR * ball, empty.length))
    visual(head, "barrel", "box", (0.0, 0.0, -0.5 * empty.length), size=bar)
    if m.log is not None:
        _log(head, m.log, (0.0, 0.0, -m.log.x))
    in_plane = joint(robot, HEAD_JOINTS[0], "revolute", ("stick", "head_cross"), tip, LIFTING)
    limit(in_plane, (-2.0 * math.pi, 2.0 * math.pi), 0.0, PASSIVE_SPEED)
    out_of_plane = joint(robot, HEAD_JOINTS[1], "revolute", ("head_cross", "head"), ORIGIN, FORWARD)
    limit(out_of_plane, (-0.5 * math.pi, 0.5 * math.pi), 0.0, PASSIVE_SPEED)


def _log(head: ElementTree.Element, log: Log, centre: Vec3) -> None:
    """Draw a log as thick as its mass makes it: in the crane's plane; one without length, across that."""
    length, direction = (log.length, ALONG_X) if log.length else (LOG_LENGTH, ALONG_Y)
    radius = math.sqrt(log.mass / (math.pi * length * LOG_DENSITY))
    visual(head, "wood", "cylinder", centre, direction, radius=repr(max(radius, 0.05)), length=repr(length))


def _moving_joints(robot: ElementTree.Element, machine: Machine) -> None:
    """Add swing, boom and stick with range, greatest torque and greatest rated speed."""
    swing_range, boom_range, stick_range = joint_limits(machine)
    speed, parts = rated_speeds(machine), machine.manipulator
    torque = machine.swing.gear_ratio * machine.swing.motor_displacement * machine.pump.supply_pressure
    swing = joint(robot, "swing", "revolute", ("base_link", "platform"), ORIGIN, UP)
    limit(swing, swing_range, torque, speed[0])
    boom = joint(robot, "boom", "revolute", ("platform", "boom"), (parts.base_offset, 0.0, 0.0), LIFTING)
    _cylinder_limit(boom, boom_range, machine.boom, machine.pump.supply_pressure, speed[1])
    stick = joint(robot, "stick", "revolute", ("boom", "stick"), (parts.boom_length, 0.0, 0.0), LIFTING)
    _cylinder_limit(stick, stick_range, machine.stick, machine.pump.supply_pressure, speed[2])


def _cylinder_limit(
    of: ElementTree.Element, interval: Interval, drive: CylinderDrive, pressure: float, speed: float
) -> None:
    """Add the limits of a cylinder's joint: torque at the longest lever arm, speed at the shortest.

    The arm grows to min(a, b) and falls again along the stroke, so its least value is at an end.
    """
    longest = min(drive.pivot_to_base, drive.pivot_to_rod)
    shortest = min(lever_arm(angle, drive.linkage) for angle in interval)
    limit(of, interval, longest * drive.head_area * pressure, speed / shortest)


def _cylinders(robot: ElementTree.Element, machine: Machine) -> None:
    """Add barrel and rod of boom and stick, pivot by pivot, without mass."""
    parts, followers = machine.manipulator, cylinder_followers(machine)
    for number, (name, parent, drive, at) in enumerate(
        (
            ("boom", "platform", machine.boom, parts.base_offset),
            ("stick", "boom", machine.stick, parts.boom_length),
        )
    ):
        barrel, rod = f"{name}_barrel", f"{name}_rod"
        _tube(
            robot,
            barrel,
            "barrel",
            math.sqrt(drive.head_area / math.pi) + WALL,
            (0.0, drive.retracted_length - EYE),
        )
        _tube(
            robot,
            rod,
            "rod",
            math.sqrt((drive.head_area - drive.rod_area) / math.pi),
            (-drive.stroke - EYE, 0.0),
        )
        along, up = barrel_pivot(drive.linkage)
        pivot, slide = CYLINDER_JOINTS[2 * number : 2 * number + 2]
        turning = joint(robot, pivot, "revolute", (parent, barrel), (at + along, 0.0, up), LIFTING)
        sliding = joint(robot, slide, "prismatic", (barrel, rod), (drive.retracted_length, 0.0, 0.0), FORWARD)
        for moving, follower in zip((turning, sliding), followers[2 * number :], strict=False):
            limit(moving, follower.interval, 0.0, PASSIVE_SPEED)
            mimic(moving, name, follower.multiplier, follower.offset)


def _tube(
    robot: ElementTree.Element, name: str, colour: str, radius: float, ends: tuple[float, float]
) -> None:
    """Add a massless link that looks like a tube along its x axis."""
    middle, length = 0.5 * (ends[0] + ends[1]), ends[1] - ends[0]
    tube = link(robot, name)
    visual(tube, colour, "cylinder", (middle, 0.0, 0.0), ALONG_X, radius=repr(radius), length=repr(length))
