"""Cylinder linkage of boom and stick: a triangle of two pivots on the links and the cylinder between them.

Symbols:
    a  pivot_to_base, from the joint to one end of the cylinder [m] (l1b, l1s)
    b  pivot_to_rod, from the joint to its other end [m] (l2b, l2s)
    φ  angle_offset [rad]
    q  joint angle [rad]
    x  cylinder length, pin to pin [m]

One law serves both joints: the angle between a and b is q + φ, so x² = a² + b² − 2 a b cos(q + φ).
The boom has φ = δ + si2; the stick's printed "+ 2 l1s l2s cos(q + si1)" is the same law with φ = π
+ si1.

Sign: for q + φ in (0, π) the cylinder extends when the joint angle grows (boom up, stick out).
"""

import math
from typing import NamedTuple


class Linkage(NamedTuple):
    """Geometry of one cylinder, made by `linkage_of`."""

    pivot_to_base: float  # a [m]
    pivot_to_rod: float  # b [m]
    angle_offset: float  # φ [rad]
    cosine: float  # of φ
    sine: float  # of φ


def linkage_of(pivot_to_base: float, pivot_to_rod: float, angle_offset: float) -> Linkage:
    """Return the linkage of a [m], b [m] and φ [rad]."""
    return Linkage(pivot_to_base, pivot_to_rod, angle_offset, math.cos(angle_offset), math.sin(angle_offset))


def cylinder_length(angle: float, linkage: Linkage) -> float:
    """Return the pin-to-pin cylinder length x = sqrt(a² + b² − 2 a b cos(q + φ)) [m].

    Thesis App. A, solved for x; Thesis App. B, ``xb_bm`` and ``xs_sk``.

    Args:
        angle: Joint angle q [rad].
        linkage: The cylinder's pivots.
    """
    a, b, offset = linkage.pivot_to_base, linkage.pivot_to_rod, linkage.angle_offset
    return math.sqrt(a * a + b * b - 2.0 * a * b * math.cos(angle + offset))


def joint_angle(length: float, linkage: Linkage) -> float:
    """Return the joint angle q = acos((a² + b² − x²) / (2 a b)) − φ [rad], q + φ in [0, π].

    Thesis App. A, first two equations.

    Args:
        length: Pin-to-pin cylinder length x [m].
        linkage: The cylinder's pivots.

    Raises:
        ValueError: The triangle does not close at this length.
    """
    angle = angle_at(length, linkage)
    if math.isnan(angle):
        a, b = linkage.pivot_to_base, linkage.pivot_to_rod
        raise ValueError(
            f"cylinder length {length:g} m: the linkage closes only from {abs(a - b):g} to {a + b:g} m"
        )
    return angle


def angle_at(length: float, linkage: Linkage) -> float:
    """Return the joint angle [rad] as `joint_angle`, NaN where the triangle does not close.

    Thesis App. A, first two equations.
    """
    a, b = linkage.pivot_to_base, linkage.pivot_to_rod
    cosine = (a * a + b * b - length * length) / (2.0 * a * b)
    if not (length > 0.0 and -1.0 <= cosine <= 1.0):
        return math.nan
    return math.acos(cosine) - linkage.angle_offset


def lever_arm(angle: float, linkage: Linkage) -> float:
    """Return the lever arm dx/dq = a b sin(q + φ) / x [m]; joint torque = lever arm · cylinder force.

    Thesis eq. 3.16, App. A, B (J is this arm). Differs: Appendix A's j is dq/dx, the reciprocal;
    Appendix B's ``arm`` is the absolute value, equal to this one only while q + φ is in (0, π), as
    it is over the whole stroke.

    Args:
        angle: Joint angle q [rad].
        linkage: The cylinder's pivots.
    """
    return length_and_arm(math.cos(angle), math.sin(angle), linkage)[1]


def length_and_arm(cosine: float, sine: float, linkage: Linkage) -> tuple[float, float]:
    """Return cylinder length and lever arm [m] from the cosine and sine of the joint angle.

    Thesis eq. 3.16, App. A, as `cylinder_length` and `lever_arm`.
    """
    product = linkage.pivot_to_base * linkage.pivot_to_rod
    c, s = linkage.cosine, linkage.sine
    squares = linkage.pivot_to_base * linkage.pivot_to_base + linkage.pivot_to_rod * linkage.pivot_to_rod
    length = math.sqrt(squares - 2.0 * product * (cosine * c - sine * s))
    return length, product * (sine * c + cosine * s) / length
