"""Positions of the joints of links and cylinders as signals: what swing, boom and stick determine."""

import math
from collections.abc import Mapping

from forest_description.derived.passive_joints import CYLINDER_JOINTS, cylinder_joint_positions
from forest_description.machine import Machine
from forest_description.types import AXES


def signal_of(joint: str) -> str:
    """Return the name of the signal that tells a joint's position [rad, m]."""
    return f"crane/{joint}.position"


CRANE_JOINTS = (*AXES, *CYLINDER_JOINTS)


def crane_signals(machine: Machine, joints: Mapping[str, float]) -> dict[str, float]:
    """Return the signals `crane/JOINT.position` of all `CRANE_JOINTS`; NaN where nobody knows one.

    Args:
        machine: Whose cylinders they are.
        joints: Angles of swing, boom and stick by name [rad]; absent or NaN: unknown.
    """
    swing, boom, stick = (joints.get(axis, math.nan) for axis in AXES)
    q = (swing, boom, stick)
    positions = (*q, *cylinder_joint_positions(q, machine))
    return dict(zip(map(signal_of, CRANE_JOINTS), positions, strict=True))
