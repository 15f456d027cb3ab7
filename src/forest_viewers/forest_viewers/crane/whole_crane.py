"""Every moving joint of the crane: swing, boom and stick as told, cylinders and head by computation.

Links of a simulated machine may bend. The model has the bending at the joint, so a link is drawn
ahead of its joint; the cylinders lie as the joint stands.
"""

from typing import NamedTuple

from forest_description.derived.passive_joints import (
    CYLINDER_JOINTS,
    HEAD_JOINTS,
    cylinder_joint_positions,
    head_joint_positions,
)
from forest_description.machine import Machine
from forest_description.types import AXES, ZERO, Vec3
from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader

PLUMB = (0.0, 0.0)
"""α, β of a head that hangs still [rad]."""


class Pose(NamedTuple):
    """Where the joints are."""

    stamp_ns: int
    positions: tuple[float, ...]  # in the order of `WholeCrane.names` [rad, m]


class WholeCrane:
    """The crane, as far as somebody tells.

    Args:
        machine: For linkages, and whether a head hangs.
    """

    def __init__(self, machine: Machine) -> None:
        self.names = joint_names(machine)
        self._machine = machine
        self._joints, self._hanging = JointReader(topics.JOINTS), JointReader(topics.HEAD_JOINTS)
        self._bending = ArrayReader(topics.GROUND_TRUTH_DEFLECTIONS)
        self._head: tuple[float, float] | None = None
        self._deflections = ZERO

    def hear_head(self, data: bytes) -> None:
        """Take in the head's joints."""
        told = self._hanging.read(data)
        if not told.problem:
            in_plane, across = told.values.position
            self._head = in_plane, across

    def hear_deflections(self, data: bytes) -> None:
        """Take in by how much the links are ahead of their joints."""
        told = self._bending.read(data, 0)
        if not told.problem:
            swing, boom, stick = told.values
            self._deflections = swing, boom, stick

    def pose(self, data: bytes) -> Pose | None:
        """Return where all joints are at a message of swing, boom and stick; None: it cannot be read."""
        told = self._joints.read(data)
        if told.problem:
            return None
        swing, boom, stick = told.values.position
        positions = joint_positions((swing, boom, stick), self._deflections, self._head, self._machine)
        return Pose(told.stamp_ns, positions)


def joint_names(machine: Machine) -> tuple[str, ...]:
    """Return the names of the URDF's moving joints, in the order of `joint_positions`."""
    return (*AXES, *CYLINDER_JOINTS, *(HEAD_JOINTS if machine.manipulator.pendulum else ()))


def joint_positions(
    q: Vec3, deflections: Vec3, head: tuple[float, float] | None, machine: Machine
) -> tuple[float, ...]:
    """Return the positions of all moving joints [rad, m].

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        deflections: By how much the links are ahead of them [rad].
        head: Positions of the hanging head's joints [rad]; None: nobody tells, it hangs plumb.
        machine: For linkages, and whether a head hangs.
    """
    swing, boom, stick = (angle + bent for angle, bent in zip(q, deflections, strict=True))
    links = swing, boom, stick
    hanging: tuple[float, ...] = ()
    if machine.manipulator.pendulum:
        hanging = head if head is not None else head_joint_positions(links, PLUMB)
    return (*links, *cylinder_joint_positions(q, machine), *hanging)
