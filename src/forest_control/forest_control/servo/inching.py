"""How a joint at rest is brought to its place: looked at with its valve shut, and inched.

A servo that acts all the time on a valve whose overlap is thought too wide is a relay: the least that it can
ask for is a jump, which shows too late, and so it cycles. This does what a person does who inches a crane to
its place: look, open the valve for as long as most of the way takes, shut it, look again.

| symbol | name | unit |
|---|---|---|
| e | error r - s, its mean since the valve was shut | rad |
| U | rate that an inch asks for | rad/s |
| D | its command for the ideal valve | V |

An inch asks for a share g of e. Where the valve gives k times what it is asked for, (1 - g k) e is left: that
shrinks for 0 < k < 2 / g. An overlap thought too wide by d [V] makes k = 1 + d / D: D must be large beside
what any overlap is misjudged by, and beside the sensors' noise, so that the valve driver takes it for motion.
An inch that does not help is followed by a stronger one: the overlap is wider than thought.

Once it has had its time to settle, a joint is left where it is but for an error that can be seen (`FAR`); and
inches that follow upon each other then come ever more seldom. An actuator that the driver feeds, for it leaks
under its load, has its valve open all the time: it is left to the servo.
"""

from typing import NamedTuple

ARRIVED = 0.35  # [s] at rest, by when the servo has brought a joint near
SHUT = 0.05  # [s] by when a valve is shut that nothing keeps open
LOOK = 0.35  # [s] the swing's longest turn on its oil
SETTLED = 2.2  # [s] at rest, from when on only what is far is inched
NEAR, FAR = 3e-4, 8e-4  # [rad] 2 and 5 mm of the tip
SHARE = 0.7  # g
LITTLE, STRONGEST = 0.35, 4.0  # of e, the least that an inch shall mend; twice as strong if it does not
LONGEST = 30.0  # [s] to look: crossings of the overlap, to and fro, are then under 0.5 V/s, come what may


class Inching(NamedTuple):
    """State of one joint."""

    rested: float  # [s] since the reference came to rest
    looked: float  # [s] since the valve was shut
    mean: float  # e [rad]
    look: float  # [s] until e is judged
    left: float  # of the inch under way [rad]
    rate: float  # that it asks for now [rad/s]
    before: float  # e of the last inch [rad]; 0: none since all was well
    strength: float  # by which U is greater than set
    fed: bool  # the servo has had an open valve


MOVING = Inching(
    rested=0.0, looked=0.0, mean=0.0, look=LOOK, left=0.0, rate=0.0, before=0.0, strength=1.0, fed=False
)


def served(i: Inching, dt: float) -> Inching:
    """Return the state after dt [s] at rest with the servo in charge."""
    if i.rested < ARRIVED:
        return MOVING._replace(rested=i.rested + dt)
    return MOVING._replace(rested=i.rested + dt, looked=LOOK, look=i.look, strength=i.strength, fed=True)


def is_due(i: Inching, shut: bool) -> bool:
    """Tell whether a joint at rest is inched: its servo has had its time, and its valve is shut."""
    patience = LOOK if i.fed else SHUT
    return i.rested >= ARRIVED and (shut or i.left != 0.0 or i.looked < patience)


def inched(i: Inching, error: float, shut: bool, rate: float, dt: float) -> Inching:
    """Return the state dt [s] later; its `rate` is to be commanded, 0: the joint holds.

    Args:
        i: state.
        error: r - s [rad].
        shut: its valve is.
        rate: U [rad/s].
        dt: period [s].
    """
    rested = i.rested + dt
    if i.left != 0.0:
        most = i.strength * rate * dt
        step = max(-most, min(most, i.left))
        return i._replace(rested=rested, looked=0.0, mean=0.0, left=i.left - step, rate=step / dt)
    looked = i.looked + dt
    mean = i.mean + dt / looked * (error - i.mean)
    if looked < i.look or not shut:
        return i._replace(rested=rested, looked=looked, mean=mean, left=0.0, rate=0.0)
    settled = rested > SETTLED
    if abs(mean) < (FAR if settled else NEAR):
        return MOVING._replace(rested=rested, look=max(LOOK, 0.5 * i.look), strength=i.strength, fed=i.fed)
    look = min(LONGEST, 2.0 * i.look) if settled else LOOK
    helped = abs(mean - i.before) > LITTLE * abs(i.before)
    strength = i.strength if helped else min(STRONGEST, 2.0 * i.strength)
    return MOVING._replace(
        rested=rested, look=look, left=SHARE * mean, before=mean, strength=strength, fed=i.fed
    )
