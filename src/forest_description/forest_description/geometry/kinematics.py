"""Kinematics of the tip: where the stick ends, how it moves, and which joint motion a tip motion needs.

Symbols:
    q             joint angles (swing, boom, stick) [rad]; c2 = cos q2, s23 = sin(q2 + q3) and so on
    l1, l2, l3    base_offset, boom, stick [m]
    r             distance of the tip from the swing axis, l1 + l2 c2 + l3 c23 [m]
    p = (x, y, z) tip position [m]

Frame: origin on the swing axis at the height of the boom pivot, x forward, y left, z up. Signs:
swing to the left, boom above the horizontal, stick unfolding are positive; a folded stick is
negative. Everything is a closed form on floats, tuples and NamedTuples of floats.
"""

import math
from typing import NamedTuple

from forest_description.types import Matrix3, Quaternion, Vec3

SINGULAR_SHARE = 1e-6
"""|det J| below this share of l2 l3 (l1 + l2 + l3), the bound of |det J|, counts as singular."""


class Links(NamedTuple):
    """Lengths of the kinematic chain: base_offset l1, boom l2, stick l3 [m]."""

    base_offset: float
    boom: float
    stick: float


def tip_position(q: Vec3, links: Links) -> Vec3:
    """Return the tip p = (r cos q1, r sin q1, l2 sin q2 + l3 sin(q2 + q3)) [m].

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        links: Link lengths.
    """
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    r = l1 + l2 * math.cos(q[1]) + l3 * math.cos(q[1] + q[2])
    z = l2 * math.sin(q[1]) + l3 * math.sin(q[1] + q[2])
    return (r * math.cos(q[0]), r * math.sin(q[0]), z)


def tip_orientation(q: Vec3) -> Quaternion:
    """Return the orientation of the stick, and so of the frame at its tip, as a unit quaternion (x, y, z, w).

    A turn by q1 about z, then by −(q2 + q3) about the y axis that turned with it: x points along
    the stick towards the tip, y stays level. With s, c of q1/2 and s', c' of (q2 + q3)/2: (s s', −c
    s', s c', c c').

    Args:
        q: Joint angles (swing, boom, stick) [rad].
    """
    s, c = math.sin(0.5 * q[0]), math.cos(0.5 * q[0])
    s_pitch, c_pitch = math.sin(0.5 * (q[1] + q[2])), math.cos(0.5 * (q[1] + q[2]))
    return (s * s_pitch, -c * s_pitch, s * c_pitch, c * c_pitch)


def jacobian(q: Vec3, links: Links) -> Matrix3:
    """Return the tip Jacobian J = dp/dq, 3x3, rows x, y, z, columns swing, boom, stick [m/rad].

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        links: Link lengths.
    """
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    x3, z3 = l3 * math.cos(q[1] + q[2]), l3 * math.sin(q[1] + q[2])  # stick, in the crane's plane
    x2, z2 = l2 * math.cos(q[1]) + x3, l2 * math.sin(q[1]) + z3  # tip from the boom pivot
    r = l1 + x2
    return ((-r * s1, -z2 * c1, -z3 * c1), (r * c1, -z2 * s1, -z3 * s1), (0.0, x2, x3))


def jacobian_determinant(q: Vec3, links: Links) -> float:
    """Return det J = −r l2 l3 sin q3 [m³]; zero on the swing axis and with the stick straight or folded flat.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        links: Link lengths.
    """
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    r = l1 + l2 * math.cos(q[1]) + l3 * math.cos(q[1] + q[2])
    return -r * l2 * l3 * math.sin(q[2])


def is_singular(q: Vec3, links: Links) -> bool:
    """Tell whether |det J| is under ``SINGULAR_SHARE`` of its bound: the tip cannot move in every direction.

    Args:
        q: Joint angles (swing, boom, stick) [rad]. Not-a-number angles count as singular.
        links: Link lengths.
    """
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    return not abs(jacobian_determinant(q, links)) > SINGULAR_SHARE * l2 * l3 * (l1 + l2 + l3)


def tip_velocity(q: Vec3, rates: Vec3, links: Links) -> Vec3:
    """Return the tip velocity J(q) q̇ [m/s].

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        rates: Joint rates q̇ [rad/s].
        links: Link lengths.
    """
    x, y, z = jacobian(q, links)
    return (
        x[0] * rates[0] + x[1] * rates[1] + x[2] * rates[2],
        y[0] * rates[0] + y[1] * rates[1] + y[2] * rates[2],
        z[0] * rates[0] + z[1] * rates[1] + z[2] * rates[2],
    )


def joint_rates(q: Vec3, velocity: Vec3, links: Links) -> Vec3:
    """Return the joint rates J⁻¹(q) v [rad/s] of a tip velocity.

    With v_t, v_r, v_z the velocity along the tangent, the radius and up:
    q̇1 = v_t / r, q̇2 = (c23 v_r + s23 v_z) / (l2 s3),
    q̇3 = −((l2 c2 + l3 c23) v_r + (l2 s2 + l3 s23) v_z) / (l2 l3 s3).

    Where ``is_singular`` no finite rates exist for every velocity: the result is (0, 0, 0), stand
    still.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        velocity: Tip velocity (x, y, z) [m/s].
        links: Link lengths.
    """
    if is_singular(q, links):
        return (0.0, 0.0, 0.0)
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    c1, s1, s3 = math.cos(q[0]), math.sin(q[0]), math.sin(q[2])
    c23, s23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    x2, z2 = l2 * math.cos(q[1]) + l3 * c23, l2 * math.sin(q[1]) + l3 * s23
    tangential = c1 * velocity[1] - s1 * velocity[0]
    radial = c1 * velocity[0] + s1 * velocity[1]
    vertical = velocity[2]
    swing = tangential / (l1 + x2)
    boom = (c23 * radial + s23 * vertical) / (l2 * s3)
    stick = -(x2 * radial + z2 * vertical) / (l2 * l3 * s3)
    return (swing, boom, stick)


def inverse_kinematics(position: Vec3, links: Links) -> Vec3:
    """Return the joint angles q that put the tip at a position, elbow up (stick angle in [−π, 0]) [rad].

    The law of cosines in the triangle of boom, stick and the line from boom pivot to tip; swing and
    boom in (−π, π]. Joint limits are not regarded; ``limits.joint_limits`` has them. On the swing
    axis the swing angle is taken as 0.

    Args:
        position: Tip position (x, y, z) [m].
        links: Link lengths.

    Raises:
        ValueError: The tip is further from the boom pivot than l2 + l3, nearer than |l2 − l3|, or
            not a number.
    """
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    outward = math.hypot(position[0], position[1]) - l1
    distance = math.hypot(outward, position[2])
    nearest, farthest = abs(l2 - l3), l2 + l3
    slack = 1e-9 * farthest  # rounding at full reach is not an error
    if not nearest - slack <= distance <= farthest + slack:
        x, y, z = position
        raise ValueError(
            f"tip position ({x:g}, {y:g}, {z:g}) m is {distance:g} m from the boom pivot: "
            f"the reach from there is {nearest:g} .. {farthest:g} m"
        )
    cosine = (distance * distance - l2 * l2 - l3 * l3) / (2.0 * l2 * l3)
    stick = -math.acos(min(1.0, max(-1.0, cosine)))
    boom = math.atan2(position[2], outward) - math.atan2(l3 * math.sin(stick), l2 + l3 * math.cos(stick))
    if boom > math.pi:
        boom -= 2.0 * math.pi
    return (math.atan2(position[1], position[0]), boom, stick)


def nearest_pose(position: Vec3, near: Vec3, links: Links) -> Vec3:
    """Return the joint angles q that put the tip at a position, on the branch of a pose [rad].

    The branch is the elbow's side, the tip's side of the swing axis and the swing's and boom's
    whole turns. A position out of reach counts as the nearest of the same direction from the boom
    pivot: a loop needs an answer.

    Args:
        position: Tip position (x, y, z) [m].
        near: Joint angles near the wanted [rad].
        links: Link lengths.
    """
    l1, l2, l3 = links.base_offset, links.boom, links.stick
    side = 1.0 if l1 + l2 * math.cos(near[1]) + l3 * math.cos(near[1] + near[2]) >= 0.0 else -1.0
    outward = side * math.sqrt(position[0] * position[0] + position[1] * position[1]) - l1
    distance = math.sqrt(outward * outward + position[2] * position[2])
    cosine = (distance * distance - l2 * l2 - l3 * l3) / (2.0 * l2 * l3)
    stick = math.copysign(math.acos(min(1.0, max(-1.0, cosine))), math.sin(near[2]))
    boom = math.atan2(position[2], outward) - math.atan2(l3 * math.sin(stick), l2 + l3 * math.cos(stick))
    swing = math.atan2(side * position[1], side * position[0])
    return (_same_turn(swing, near[0]), _same_turn(boom, near[1]), _same_turn(stick, near[2]))


def _same_turn(angle: float, near: float) -> float:
    """Return an angle plus the whole turns that bring it nearest to another one [rad]."""
    return angle + 2.0 * math.pi * math.floor((near - angle) / (2.0 * math.pi) + 0.5)
