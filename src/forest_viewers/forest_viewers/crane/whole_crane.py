"""Every moving joint of the crane: swing, boom and stick as told, cylinders and head by computation."""

from forest_description.derived.passive_joints import (
    CYLINDER_JOINTS,
    HEAD_JOINTS,
    cylinder_joint_positions,
    head_joint_positions,
)
from forest_description.machine import Machine
from forest_description.types import AXES, Vec3

PLUMB = (0.0, 0.0)
"""α, β of a head that hangs still [rad]."""


def joint_names(machine: Machine) -> tuple[str, ...]:
    """Return the names of the URDF's moving joints, in the order of `joint_positions`."""
    return (*AXES, *CYLINDER_JOINTS, *(HEAD_JOINTS if machine.manipulator.pendulum else ()))


def joint_positions(q: Vec3, head: tuple[float, float] | None, machine: Machine) -> tuple[float, ...]:
    """Return the positions of all moving joints [rad, m].

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        head: Positions of the hanging head's joints [rad]; None: nobody tells, it hangs plumb.
        machine: For linkages, and whether a head hangs.
    """
    hanging: tuple[float, ...] = ()
    if machine.manipulator.pendulum:
        hanging = head if head is not None else head_joint_positions(q, PLUMB)
    return (*q, *cylinder_joint_positions(q, machine), *hanging)
