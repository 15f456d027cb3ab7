"""Positions of every moving joint of the crane, the passive ones included, as signals."""

import math
from collections.abc import Mapping

from forest_description.derived.passive_joints import (
    CYLINDER_JOINTS,
    HEAD_JOINTS,
    cylinder_joint_positions,
    head_joint_positions,
)
from forest_description.machine import Machine
from forest_description.types import AXES


def signal_of(joint: str) -> str:
    """Return the name of the signal that tells a joint's position [rad, m]."""
    return f"crane/{joint}.position"


def crane_joints(machine: Machine) -> tuple[str, ...]:
    """Return every moving joint of a machine's URDF."""
    hanging = HEAD_JOINTS if machine.manipulator.pendulum is not None else ()
    return (*AXES, *CYLINDER_JOINTS, *hanging)


def crane_signals(
    machine: Machine, joints: Mapping[str, float], head: tuple[float, float] = (math.nan, math.nan)
) -> dict[str, float]:
    """Return the signals `crane/JOINT.position` of all `crane_joints`; NaN where nobody knows one.

    Args:
        machine: Whose cylinders and head they are.
        joints: Angles of swing, boom and stick by name [rad]; absent or NaN: unknown.
        head: α, β of a hanging head from the platform's vertical [rad], as `head_joint_positions`
            takes them.
    """
    swing, boom, stick = (joints.get(axis, math.nan) for axis in AXES)
    q = (swing, boom, stick)
    positions = [*q, *cylinder_joint_positions(q, machine)]
    if machine.manipulator.pendulum is not None:
        positions += head_joint_positions(q, head)
    return dict(zip(map(signal_of, crane_joints(machine)), positions, strict=True))
