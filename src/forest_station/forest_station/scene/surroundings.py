"""Bunk, carrier and trees around the crane: for the eye only, the crane neither feels nor avoids them.

All of it is assumed. It gives a person scale, horizon and direction.
"""

import math

from forest_station.scene.scene_elements import Thing

TREES = 90
CLEARING = 2.7  # radius without trees, per reach: none stands between a camera and the crane
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
"""Between a tree and the next [rad]: they never stand in rows."""


def surroundings(reach: float, ground: float) -> list[Thing]:
    """Return carrier, bunk and trees for a crane of a reach [m] over the ground [m]."""
    carrier = Thing(kind="carrier", xyz=[0.0, 0.0, ground], size=[-ground], yaw=0.0)
    bunk = Thing(
        kind="bunk",
        xyz=[0.05 * reach, 0.62 * reach, ground],
        size=[0.55 * reach, 0.26 * reach, 0.8 * -ground],
        yaw=0.0,
    )
    return [carrier, bunk, *_trees(CLEARING * reach, ground)]


def _trees(clearing: float, ground: float) -> list[Thing]:
    """Return trees outside of a clearing of a radius [m], on a spiral."""
    trees = []
    for number in range(TREES):
        distance = clearing * (1.0 + 2.2 * number / TREES)
        angle = 0.4 + GOLDEN_ANGLE * number
        height = 9.0 + 5.0 * math.sin(2.3 * number) ** 2
        xyz = [distance * math.cos(angle), distance * math.sin(angle), ground]
        trees.append(Thing(kind="tree", xyz=xyz, size=[0.17 * height, height], yaw=angle))
    return trees
