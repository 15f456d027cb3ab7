"""How near crane and log come to ground, bunk and stakes, as capsules against capsules and planes.

| moving | against |
|---|---|
| stick, from its root to the tip | stakes |
| grapple, from the tip to the grip | stakes |
| log, along the crane's plane, level with the grapple | stakes, ground, bunk's floor |

A contact is a run of looks in which two overlap. Ground and floor count where something is deeper than the
tolerance of the task: a log is laid on them. No force comes of a contact: the simulator's crane passes.
"""

import numpy as np

from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.types import Bools, Floats
from forest_study.log_work.site import Site

STICK, GRAPPLE = 0.15, 0.2  # [m] radius on a crane that reaches 8 m; assumed
SHARES = np.linspace(0.0, 1.0, 25)  # of a segment, at which its distance from a stake is taken


def contacts(m: Manipulator, site: Site, angles: Floats, head: Floats, loaded: Floats) -> int:
    """Return how many contacts there were.

    Args:
        m: lengths of the crane.
        site: what it may hit.
        angles: of the joints [N, 3] rad, a row a look.
        head: angles of the hanging head in the crane's plane and out of it [N, 2] rad.
        loaded: whether a log is in the grapple [N].
    """
    root, tip, grip, ends = chain(m, site, angles, head)
    found = 0
    for a, b, radius, there in (
        (root, tip, STICK * site.scale, np.ones(len(angles), dtype=bool)),
        (tip, grip, GRAPPLE * site.scale, np.ones(len(angles), dtype=bool)),
        (*ends, site.log_radius, loaded > 0.0),
    ):
        for foot in site.stakes:
            gap = _from_stake(a, b, np.array(foot), site.stake_top) - radius - site.stake_radius
            found += _events((gap < 0.0) & there)
    lowest = np.minimum(ends[0][:, 2], ends[1][:, 2])
    found += _events((lowest - site.log_radius < site.ground - site.near) & (loaded > 0.0))
    found += _events(grip[:, 2] < site.ground - site.near)
    return found + _events(_over_bunk(grip, site) & (grip[:, 2] < site.floor - site.near))


def chain(
    m: Manipulator, site: Site, angles: Floats, head: Floats
) -> tuple[Floats, Floats, Floats, tuple[Floats, Floats]]:
    """Return the stick's root, tip, grip and both ends of a log in it, each [N, 3] m."""
    c, s = np.cos(angles[:, 0]), np.sin(angles[:, 0])
    boom, pitch = angles[:, 1], angles[:, 1] + angles[:, 2]
    r, z = m.base_offset + m.boom_length * np.cos(boom), m.boom_length * np.sin(boom)
    root = _placed(r, z, c, s)
    tip = _placed(r + m.stick_length * np.cos(pitch), z + m.stick_length * np.sin(pitch), c, s)
    grip = tip + site.hang * hanging(head, c, s)
    alpha = head[:, 0]
    along = 0.5 * site.log_length * _placed(np.cos(alpha), np.sin(alpha), c, s)
    return root, tip, grip, (grip - along, grip + along)


def hanging(head: Floats, c: Floats, s: Floats) -> Floats:
    """Return unit vectors [N, 3] from the tip to the grapple's middle; c, s of the swing angle."""
    a, b = head[:, 0], head[:, 1]
    x, y, z = np.sin(a) * np.cos(b), np.sin(b), -np.cos(a) * np.cos(b)
    return np.column_stack([x * c - y * s, x * s + y * c, z])


def _placed(r: Floats, z: Floats, c: Floats, s: Floats) -> Floats:
    return np.column_stack([r * c, r * s, z])


def _from_stake(a: Floats, b: Floats, foot: Floats, top: float) -> Floats:
    """Return the least distance [N] m between segments a, b [N, 3] and a vertical stake."""
    points = a[:, None] + SHARES[:, None] * (b - a)[:, None]
    over = points[..., 2] - np.clip(points[..., 2], foot[2], top)
    apart = np.hypot(np.hypot(points[..., 0] - foot[0], points[..., 1] - foot[1]), over)
    least: Floats = apart.min(axis=1)
    return least


def _over_bunk(grip: Floats, site: Site) -> Bools:
    """Tell where the grip is over the bunk."""
    xs, ys = zip(*((x, y) for x, y, _ in site.stakes), strict=True)
    over: Bools = (grip[:, 0] > min(xs)) & (grip[:, 0] < max(xs)) & (np.abs(grip[:, 1]) < max(ys))
    return over


def _events(there: Bools) -> int:
    """Return how often something begins."""
    return int(np.count_nonzero(np.diff(there.astype(int), prepend=0) > 0))
