"""The swing's gear with play: teeth that touch on either side of a gap, between motor and joint.

| symbol | name | unit |
|---|---|---|
| theta, q | angle of the motor, seen at the joint (over the gear ratio); of the joint | rad |
| 2 b | backlash: the joint's free way with the motor held | rad |
| J | inertia of the motor, seen at the joint (times the gear ratio squared) | kg m^2 |
| T | torque of the teeth on the joint, its reverse on the motor | N m |

    J d2(theta)/dt2 = torque of the oil - T

The teeth are a spring and a damper beyond b on either side, and push only. That is the law of
`end_stop`, met by the motor in the joint's frame. Nordin and Gutman, Controlling mechanical systems
with backlash: a survey, Automatica 38, 2002, section 2, has such models; without the damper's grip
and the spring's limit they would pull.
"""

from typing import NamedTuple

from forest_sim.mechanics.end_stop import NO_STOP, EndStop


class Gear(NamedTuple):
    """Constants of the law; an `inertia` of 0 leaves it out: motor and joint are one."""

    inertia: float  # J [kg m^2]
    teeth: EndStop  # -b, b [rad], stiffness [N m/rad] and damping [N m s/rad]
    stop: EndStop  # of the joint: the axis' own stands on the motor's side


NO_GEAR = Gear(0.0, NO_STOP, NO_STOP)


def without_play(gear: Gear) -> Gear:
    """Return a gear whose teeth always touch."""
    if gear.inertia == 0.0:
        return gear
    return gear._replace(teeth=gear.teeth._replace(lower=0.0, upper=0.0))


def teeth_depth(twist: float, teeth: EndStop) -> float:
    """Return how far the teeth are pressed together [rad] at a twist theta - q [rad], with its sign."""
    if teeth.stiffness == 0.0:
        return 0.0
    return twist - max(teeth.lower, min(teeth.upper, twist))


def teeth_energy(twist: float, teeth: EndStop) -> float:
    """Return the energy [J] in the teeth at a twist theta - q [rad]."""
    depth = teeth_depth(twist, teeth)
    return 0.5 * teeth.stiffness * depth * depth
