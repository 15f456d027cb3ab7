"""Whether a measured state of the joints can be true."""

from forest_control.config.controller_settings import Parameters
from forest_description.types import AXES, Vec3

BEYOND_LIMIT = 0.1  # [rad] outside the joint limits: end stops give, encoders are not perfect
FASTEST = 5.0  # [rad/s] no joint of such a crane moves faster
ROUGH = 0.005  # [rad] noise and steps of two readings: over ten deviations of a resolver's


def plausible(angles: Vec3, rates: Vec3, p: Parameters) -> bool:
    """Tell whether a measured state can be true; `implausible` says what of it cannot."""
    for i in range(3):
        low, high = p.velocity_limits.lower[i] - BEYOND_LIMIT, p.velocity_limits.upper[i] + BEYOND_LIMIT
        if not low <= angles[i] <= high or not abs(rates[i]) <= FASTEST:
            return False
    return True


def implausible(angles: Vec3, rates: Vec3, p: Parameters) -> str:
    """Return what cannot be true of a measured state, or "": degrees for radians, a broken encoder.

    Args:
        angles: joint angles [rad]; at most `BEYOND_LIMIT` outside the joint limits.
        rates: joint rates [rad/s]; at most `FASTEST`.
        p: the controller's parameters.
    """
    for i, name in enumerate(AXES):
        low, high = p.velocity_limits.lower[i] - BEYOND_LIMIT, p.velocity_limits.upper[i] + BEYOND_LIMIT
        if not low <= angles[i] <= high:
            return f"joint state: {name} is {angles[i]:g} rad; allowed: {low:.3f} .. {high:.3f}"
        if not abs(rates[i]) <= FASTEST:
            return f"joint state: {name} moves at {rates[i]:g} rad/s; allowed: up to {FASTEST:g}"
    return ""


def jumps(before: Vec3, angles: Vec3, seconds: float) -> bool:
    """Tell whether a joint would have moved too fast since its last sample; `jump` says which.

    A rate may be true beside an angle that is not: a glitch of a resolver, or one that comes back.
    """
    most = FASTEST * seconds + ROUGH
    return (
        abs(angles[0] - before[0]) > most
        or abs(angles[1] - before[1]) > most
        or abs(angles[2] - before[2]) > most
    )


def jump(before: Vec3, angles: Vec3, seconds: float) -> str:
    """Return which joint [rad] jumps within a time [s], or ""."""
    for i, name in enumerate(AXES):
        way = abs(angles[i] - before[i])
        if way > FASTEST * seconds + ROUGH:
            told = f"joint state: {name} jumps by {way:.3f} rad in {seconds:.3f} s"
            return f"{told}; allowed: up to {FASTEST:g} rad/s"
    return ""
