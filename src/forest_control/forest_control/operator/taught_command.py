"""A taught command: a piece of a path near the tip, which the tip follows while the levers are centred.

| symbol | name | unit |
|---|---|---|
| p, t, k | place on the path; direction there (a unit vector); curvature, d t / d s | m, 1, 1/m |
| x | place of the tip that is led | m |
| d | way from p at which the path is beside x: (x - p) . t | m |
| l | way that is left from p to the path's next stop | m |

The path near p is p + d t + d^2 k / 2. The tip goes along it, and back to it:

    x' = min(v, B (l - d)) (t + d k) / |t + d k| + K (p + d t + d^2 k / 2 - x)

and no faster than the operator's profile allows. There is no time in it. Whatever slows the tip slows it
along the path; a command that comes late is still a piece of the path.
"""

from typing import NamedTuple

from forest_description.geometry.vectors import dot, minus, norm, scaled
from forest_description.types import ZERO, Vec3

APPROACH_RATE = 3.0  # [1/s] K, speed per distance from the path: as of position mode
STOP_RATE = 10.0  # [1/s] B, speed per way left to a stop: the last centimetre, after the sender's ramp
WITHIN = 0.05  # [m] of p, along the path: beyond, the piece tells nothing of it
SHARPEST = 15.0  # [1/m] of k: with `WITHIN` the direction never turns round
UNIT = 1e-3  # [1] by which the length of t may differ from 1: rounding of a sender


class TaughtCommand(NamedTuple):
    """A piece of a path."""

    place: Vec3 = ZERO  # p [m]
    tangent: Vec3 = ZERO  # t, a unit vector
    curvature: Vec3 = ZERO  # k [1/m]
    speed: float = 0.0  # v [m/s], wished; 0: there is nothing to follow
    left: float = 0.0  # l [m]


NO_COMMAND = TaughtCommand()


def to_values(run: float, c: TaughtCommand) -> tuple[float, ...]:
    """Return the values of `tip/taught_command`."""
    return run, *c.place, *c.tangent, *c.curvature, c.speed, c.left


def from_values(values: tuple[float, ...]) -> tuple[float, TaughtCommand]:
    """Return a run's number and its command, of the values of `tip/taught_command`."""
    run, x, y, z, t_x, t_y, t_z, k_x, k_y, k_z, speed, left = values
    return run, TaughtCommand((x, y, z), (t_x, t_y, t_z), (k_x, k_y, k_z), speed, left)


def taught_velocity(c: TaughtCommand, x: Vec3, most: float) -> Vec3:
    """Return the tip velocity x' [m/s] that a command asks for.

    Args:
        c: the command.
        x: place of the tip that is led [m].
        most: greatest speed [m/s].
    """
    d, beside = _beside(c, x)
    t, k = c.tangent, c.curvature
    along = t[0] + d * k[0], t[1] + d * k[1], t[2] + d * k[2]
    speed = max(0.0, min(c.speed, STOP_RATE * (c.left - d))) / norm(along)
    velocity = (
        speed * along[0] + APPROACH_RATE * beside[0],
        speed * along[1] + APPROACH_RATE * beside[1],
        speed * along[2] + APPROACH_RATE * beside[2],
    )
    return scaled(velocity, most / max(most, norm(velocity)))


def distance_from_path(c: TaughtCommand, x: Vec3) -> float:
    """Return how far a place x [m] is from the piece of path [m]."""
    _, beside = _beside(c, x)
    return norm(beside)


def implausible(c: TaughtCommand) -> str:
    """Return what of a command cannot be, or ""."""
    if c.speed == 0.0:
        return ""
    if not abs(norm(c.tangent) - 1.0) <= UNIT:
        return "taught command: its direction is no unit vector; allowed: length 1"
    if not norm(c.curvature) <= SHARPEST:
        return f"taught command: its curvature is over {SHARPEST:g} 1/m; allowed: less"
    if not (c.speed > 0.0 and c.left >= 0.0):
        return "taught command: speed or way left is negative; allowed: 0 or more"
    return ""


def _beside(c: TaughtCommand, x: Vec3) -> tuple[float, Vec3]:
    """Return d [m], within the piece and its stop, and the way from x to the path there [m]."""
    away = minus(x, c.place)
    d = max(-WITHIN, min(dot(away, c.tangent), c.left, WITHIN))
    bow = 0.5 * d * d
    return d, (
        d * c.tangent[0] + bow * c.curvature[0] - away[0],
        d * c.tangent[1] + bow * c.curvature[1] - away[1],
        d * c.tangent[2] + bow * c.curvature[2] - away[2],
    )
