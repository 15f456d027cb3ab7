"""Inching: a joint at rest is brought to its reference in short motions, its valve shut in between.

A servo on a valve whose overlap is estimated too wide is a relay: its least command makes the
actuator jump, and the loop cycles. Inching is the word of IEC 60947-4-1 for a motor that is
energised again and again, shortly, for small movements. A person does so, too: measure the error with the
valve shut, open the valve for as long as most of the way takes, shut it, measure again.

| symbol | name | unit |
|---|---|---|
| e | error r - s, its mean over `LOOK` | rad |
| U | rate that an inch asks for | rad/s |
| D | its command for the ideal valve | V |

An inch asks for a share g of e. Where the valve gives k times what it is asked for, (1 - g k) e is
left: that shrinks for 0 < k < 2 / g. An overlap estimated too wide by d [V] makes k = 1 + d / D. So
D must be large beside the error of any overlap, and beside the sensors' noise, or the valve driver
would not take it for motion. An inch that does not help is followed by a stronger one: the overlap
is wider than estimated.

A joint behind a gear with play comes to rest on either flank, and an inch may only move the motor
in its play. So half the free way is left beyond what else is.

Once it has had its time to settle, a joint is moved only for an error that can be seen (`FAR`), and
ever more seldom. But one that moves although its valve is shut, under a load that is grasped or dropped,
begins anew. An actuator that leaks under its load has its valve open all the time: it is left to the servo.
"""

from typing import NamedTuple

ARRIVED = 0.35  # [s] at rest after which a joint is inched: by then the servo has brought it near; chosen
SHUT = 0.05  # [s] in which a valve is shut that nothing keeps open: ten periods; chosen
LOOK = 0.35  # [s] for which the error is averaged: the swing's longest period on its oil
SETTLED = 2.2  # [s] at rest from which only an error over `FAR` is inched; chosen, not measured
NEAR = 3e-4  # [rad] error that is left, until `SETTLED`: 2 mm of the tip at 6 m
FAR = 8e-4  # [rad] error that is left, from then on: 5 mm of the tip at 6 m
SHARE = 0.7  # [1] g: k up to 2.8 still converges; chosen
LITTLE = 0.35  # [1] least share of e that an inch shall take away, or the next is stronger; half of g
STRONGEST = 4.0  # [1] greatest strength of an inch, doubled when it did not help; chosen, not measured
LONGEST = 30.0  # [s] between inches: crossings of the overlap are then under 0.5 V/s, whatever goes wrong


class Inching(NamedTuple):
    """State of one joint."""

    rested: float = 0.0  # [s] since the reference came to rest
    looked: float = 0.0  # [s] since the valve was shut, or e was averaged
    mean: float = 0.0  # e [rad]
    last: float = 0.0  # e before that [rad]
    compares: bool = False  # it was behind the same shut valve
    waited: float = 0.0  # [s] since the last inch
    wait: float = LOOK  # [s] until the next one
    left: float = 0.0  # of the inch under way [rad]
    rate: float = 0.0  # that it asks for [rad/s]
    before: float = 0.0  # e of the last inch [rad]; 0: none since all was well
    strength: float = 1.0  # by which U is greater than set
    fed: bool = False  # the servo has had an open valve


MOVING = Inching()


def served(i: Inching, dt: float) -> Inching:
    """Return the state after dt [s] at rest with the servo in charge."""
    if i.rested < ARRIVED:
        return Inching(rested=i.rested + dt)
    return Inching(rested=i.rested + dt, looked=LOOK, wait=i.wait, strength=i.strength, fed=True)


def is_due(i: Inching, shut: bool) -> bool:
    """Tell whether a joint at rest is inched: its servo has had its time, and its valve is shut."""
    timeout = LOOK if i.fed else SHUT
    return i.rested >= ARRIVED and (shut or i.left != 0.0 or i.looked < timeout)


def inched(i: Inching, error: float, shut: bool, rate: float, free_way: float, dt: float) -> Inching:
    """Return the state dt [s] later; its `rate` is to be commanded, 0: the joint holds.

    Args:
        i: state.
        error: r - s [rad].
        shut: its valve is.
        rate: U [rad/s].
        free_way: of its gear [rad]; 0: none.
        dt: period [s].
    """
    rested, waited = i.rested + dt, i.waited + dt
    if i.left != 0.0:
        most = i.strength * rate * dt
        step = max(-most, min(most, i.left))
        left = i.left - step
        return i._replace(rested=rested, looked=0.0, compares=False, waited=0.0, left=left, rate=step / dt)
    looked, mean = (dt, error) if i.looked >= LOOK else (i.looked + dt, i.mean)
    mean += dt / looked * (error - mean)
    i = i._replace(rested=rested, looked=looked, mean=mean, waited=waited, rate=0.0)
    return _judged(i, free_way) if looked >= LOOK and shut else i


def _judged(i: Inching, free_way: float) -> Inching:
    """Return the state after `LOOK` behind a shut valve: with an inch, if one is due."""
    pushed = i.compares and abs(i.mean - i.last) > FAR + free_way
    if pushed:  # not by its valve: something was grasped, or let go
        i = i._replace(rested=ARRIVED, wait=LOOK, before=0.0)
    i = i._replace(last=i.mean, compares=True)
    settled = i.rested > SETTLED
    if i.waited < i.wait:
        return i
    if abs(i.mean) < 0.5 * free_way + (FAR if settled else NEAR):
        return i._replace(waited=0.0, wait=max(LOOK, 0.5 * i.wait), before=0.0)
    wait = min(LONGEST, 2.0 * i.wait) if settled else LOOK
    helped = abs(i.mean - i.before) > LITTLE * abs(i.before)
    strength = i.strength if helped else min(STRONGEST, 2.0 * i.strength)
    return i._replace(wait=wait, left=SHARE * i.mean, before=i.mean, strength=strength)
