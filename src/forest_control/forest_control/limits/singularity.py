"""The way out of a singular pose: joint rates where J has no inverse.

On the swing axis no swing moves the tip sideways. With the stick straight or folded flat nothing
moves the tip along the stick at first. A command is then carried out as at the nearest regular
pose. The direction is not kept, but a joint moves, and J has its inverse again a moment later.

| symbol | name | unit |
|---|---|---|
| q | joint angles | rad |
| r | distance of the tip from the swing axis, negative behind it | m |
"""

import math

from forest_description.geometry.kinematics import Links, is_singular, joint_rates
from forest_description.types import Vec3

BENT = 0.05  # [rad] least angle of the stick from straight or flat: 1/sin bounds J^-1 by 20; chosen
ASIDE = 0.02  # [1] least |r| as a share of the arm's length, in tip schemes kept, too; chosen, not measured


def rates_near_singularity(q: Vec3, velocity: Vec3, links: Links) -> Vec3:
    """Return J^-1(q) x' [rad/s] of a tip velocity x' [m/s]; if it is singular, that of the nearest pose."""
    if not is_singular(q, links):
        return joint_rates(q, velocity, links)
    bent = q[0], q[1], _bent(q[2])
    reach = links.boom * math.cos(bent[1]) + links.stick * math.cos(bent[1] + bent[2])
    r, least = links.base_offset + reach, ASIDE * (links.boom + links.stick)
    if abs(r) >= least:
        return joint_rates(bent, velocity, links)
    # A longer or shorter offset puts the tip beside the axis and leaves boom and stick as they are.
    offset = (least if r >= 0.0 else -least) - reach
    return joint_rates(bent, velocity, Links(offset, links.boom, links.stick))


def _bent(angle: float) -> float:
    """Return the stick's angle [rad], at least `BENT` from straight and flat."""
    turns = math.floor(angle / math.pi + 0.5)
    away = angle - turns * math.pi  # from the nearest of straight and flat
    if abs(away) >= BENT:
        return angle
    folds = away if away != 0.0 else (-1.0 if turns % 2 == 0 else 1.0)
    return turns * math.pi + math.copysign(BENT, folds)
