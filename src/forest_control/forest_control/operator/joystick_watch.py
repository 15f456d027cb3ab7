"""The watch over a joystick: silent, frozen or alive; and when its levers may move something.

A sample counts as new when its stamp is later than the last one's (a stamp of zero is none) and,
where its source counts a heartbeat, when the count has changed. No new sample for `joy_timeout`: the
joystick is lost.

A joystick without heartbeat that repeats one sample to the last bit is held still, or it hangs. Its
own past tells them apart. A converter with noise is restless: in play it never repeats a sample for
`STILLNESS`. In play means that a lever is off its rest and off its end, where a driver's deadzone and
the clamp to 1 hide the noise.

- After R seconds of restless play a joystick is frozen when still for `EVIDENCE` / R, `QUICK` at
  the least.
- One that ever held still for longer, and then moved, may do so again: it is frozen after
  `frozen_timeout`. So is one that is not known yet.
- Any axis or button that changes shows life. Still near the centre, the levers count as centred.

Levers move something only while armed. Arming needs a live joystick, the deadman held, and all
levers centred; whatever stops the crane disarms. So a deadman that is pressed with a deflected
lever, and a joystick that comes back deflected, move nothing until the levers have been centred.

| symbol | name | unit |
|---|---|---|
| now, received, fresh_since, moved | local monotonic times (in lockstep: simulated ones) | s |
| stamp | of the sample, in its source's time | ns |
| heartbeat | the source's count; `NO_HEARTBEAT` where it has none | 1 |
| centre | deflection up to which a lever counts as centred | 1 |

A stamp that goes back is out of order: the sample is dropped, but a released deadman in it counts.
Only a joystick that is lost may begin anew.
"""

import math
from enum import IntEnum
from typing import Annotated, NamedTuple

from forest_control.operator.levers import REST as CENTRED
from forest_control.operator.levers import Levers, levers_from_axes
from forest_msgs_py.runtime.parameter_table import Parameter

NO_HEARTBEAT = -1  # [1] count of a source without heartbeat: no count is negative
NO_STAMP = 0  # [ns] stamp of a message without one: ROS's default
HEARTBEAT = "heartbeat:"  # what a Joy's frame_id begins with; a decimal count follows
STILLNESS = 0.25  # [s] stillness in play that noise never shows: five samples of a joystick at 20 Hz
QUICK = 0.5  # [s] shortest stillness that counts as frozen: two holds
EVIDENCE = 20.0  # [s^2] play times stillness: frozen after 2 s for 10 s of restless play; chosen
MAY_HOLD_STILL = -math.inf  # [s] restless play of a joystick that held still: never enough


class Joystick(IntEnum):
    """What is known of the joystick; everything but ALIVE stops the crane."""

    SILENT = 0  # nothing has come yet
    ALIVE = 1
    LOST = 2  # nothing new for `joy_timeout`
    FROZEN = 3  # deflected, and still for too long
    BAD = 4  # the last sample cannot be read


class WatchParameters(NamedTuple):
    """Of `controller_node`: when a joystick is believed, and when its levers count as centred."""

    joy_timeout: Annotated[float, Parameter("age at which the joystick is lost", "s", 0.01, 2.0)] = 0.15
    # Of a joystick that is not known to be restless.
    frozen_timeout: Annotated[
        float,
        Parameter(
            "time of a deflection without any change after which the joystick is frozen; 0: never",
            "s",
            0.0,
            60.0,
        ),
    ] = 10.0
    centre: Annotated[float, Parameter("deflection that counts as centred", "", 0.001, 0.5)] = 0.05


class Sample(NamedTuple):
    """One sample of a joystick."""

    received: float  # [s] when it was sent, by the local clock
    stamp: int = NO_STAMP  # [ns]
    heartbeat: int = NO_HEARTBEAT
    same: bool = False  # all axes and buttons as in the sample before, to the last bit
    good: bool = False  # it could be read
    levers: Levers = CENTRED
    held: bool = False  # the deadman


class Watch(NamedTuple):
    """What is remembered between samples."""

    joystick: Joystick = Joystick.SILENT
    stamp: int = NO_STAMP  # [ns] of the newest sample
    heartbeat: int = NO_HEARTBEAT
    fresh_since: float = -math.inf  # [s] when the newest new sample was sent
    moved: float = -math.inf  # [s] when axes or buttons last changed, or the heartbeat showed life
    restless: float = 0.0  # [s] in play without a hold, or `MAY_HOLD_STILL`
    repeats: bool = False  # it has sent the same twice: its driver has a clock of its own
    levers: Levers = CENTRED
    held: bool = False
    armed: bool = False
    out_of_order: int = 0  # samples dropped so far


REST = Watch()


class Operator(NamedTuple):
    """The levers that the controller may act on."""

    levers: Levers
    enabled: bool


def updated_watch(watch: Watch, sample: Sample) -> Watch:
    """Take in one sample, oldest first."""
    if not sample.good:
        return watch._replace(
            joystick=Joystick.BAD, fresh_since=sample.received, levers=CENTRED, held=False, armed=False
        )
    stamped, beats = sample.stamp != NO_STAMP, sample.heartbeat != NO_HEARTBEAT
    still_held = watch.held and sample.held  # a release counts in any order
    if (stamped and sample.stamp == watch.stamp) or (beats and sample.heartbeat == watch.heartbeat):
        return watch._replace(held=still_held, armed=watch.armed and still_held)
    if stamped and sample.stamp < watch.stamp and watch.joystick == Joystick.ALIVE:
        armed, dropped = watch.armed and still_held, watch.out_of_order + 1
        return watch._replace(held=still_held, armed=armed, out_of_order=dropped)
    moves = beats or not sample.same
    return watch._replace(
        joystick=Joystick.ALIVE,
        stamp=sample.stamp,
        heartbeat=sample.heartbeat,
        fresh_since=sample.received,
        moved=sample.received if moves else watch.moved,
        restless=_learnt(watch, sample.received) if moves and not beats else watch.restless,
        repeats=watch.repeats or sample.same,
        levers=sample.levers,
        held=sample.held,
        armed=watch.armed and sample.held,  # a release between two steps counts
    )


def assessed_watch(watch: Watch, now: float, allowed: bool, p: WatchParameters) -> tuple[Watch, Operator]:
    """Return the watch at a time [s], and what the controller may act on.

    Args:
        watch: after all samples that have come.
        now: local time [s].
        allowed: nothing else forbids motion; False disarms.
        p: the user's settings.
    """
    watch = watch._replace(joystick=_judged(watch, now, p))
    if watch.joystick != Joystick.ALIVE or not watch.held or not allowed:
        return watch._replace(armed=False), Operator(CENTRED, False)
    resting = is_still(watch, now, p)  # and centred, or it would be frozen
    levers = CENTRED if resting else watch.levers
    if not watch.armed and not is_centred(levers, p.centre):
        return watch, Operator(CENTRED, False)
    return watch._replace(armed=True), Operator(levers, True)


def is_centred(levers: Levers, centre: float) -> bool:
    """Tell whether no lever is deflected by more than `centre`."""
    return max(abs(levers.swing), abs(levers.boom), abs(levers.stick)) <= centre


def is_deflected_unarmed(watch: Watch, centre: float) -> bool:
    """Tell whether a live joystick moves nothing, its deadman held, because the levers were not centred."""
    return (
        watch.joystick == Joystick.ALIVE
        and watch.held
        and not watch.armed
        and not is_centred(watch.levers, centre)
    )


def is_released(watch: Watch, centre: float) -> bool:
    """Tell whether the last sample has the deadman released and the levers centred, as a reset needs.

    A joystick that has never published counts: before it can move anything, it must be centred,
    too.
    """
    believed = watch.joystick not in (Joystick.BAD, Joystick.FROZEN)
    return believed and not watch.held and is_centred(watch.levers, centre)


def _judged(watch: Watch, now: float, p: WatchParameters) -> Joystick:
    if watch.joystick == Joystick.SILENT:
        return Joystick.SILENT
    if now - watch.fresh_since > p.joy_timeout:
        return Joystick.LOST
    if watch.joystick == Joystick.BAD or watch.joystick == Joystick.LOST:
        return watch.joystick
    if is_still(watch, now, p) and not is_centred(watch.levers, p.centre):
        return Joystick.FROZEN
    return Joystick.ALIVE


def is_still(watch: Watch, now: float, p: WatchParameters) -> bool:
    """Tell whether nothing has changed for too long to be a hand on this joystick."""
    timeout = p.frozen_timeout
    if in_play(watch.levers) and watch.restless > 0.0:
        timeout = min(timeout, max(QUICK, EVIDENCE / watch.restless))
    return p.frozen_timeout > 0.0 and now - watch.moved >= timeout


def _learnt(watch: Watch, now: float) -> float:
    """Return the restless play [s], after axes or buttons have changed."""
    if not in_play(watch.levers):
        return watch.restless
    if watch.joystick == Joystick.FROZEN:  # what hung may hang again: it has not shown that it may hold still
        return 0.0
    if watch.fresh_since - watch.moved > STILLNESS:
        return MAY_HOLD_STILL
    return watch.restless + min(now - watch.moved, STILLNESS)  # no more: silence between samples is no play


def in_play(levers: Levers) -> bool:
    """Tell whether a lever is where its converter's noise shows: neither at zero nor at an end."""
    return _in_play(levers.swing) or _in_play(levers.boom) or _in_play(levers.stick)


def _in_play(lever: float) -> bool:
    return 0.0 < abs(lever) < 1.0


def problem_text(watch: Watch) -> str:
    """Return what is wrong with the joystick, in one sentence; "": nothing."""
    silent_driver = watch.joystick == Joystick.LOST and not watch.repeats
    return PROBLEMS[watch.joystick] + (NEVER_REPEATS if silent_driver else "")


NEVER_REPEATS = "; its driver never repeats a sample: let it (of joy: autorepeat_rate, 20 Hz or more)"
PROBLEMS = {
    Joystick.SILENT: "",  # before the first sample, and with the deadman released, none is missed
    Joystick.ALIVE: "",
    Joystick.LOST: "joystick: nothing new for longer than joy_timeout",
    Joystick.FROZEN: "joystick: held still to the last bit for too long; a heartbeat in frame_id may",
    Joystick.BAD: "joystick: its last sample cannot be read",
}


def joystick_sample(
    stamp: int,
    frame: str,
    received: float,
    content: tuple[tuple[float, ...], tuple[int, ...]],
    before: tuple[tuple[float, ...], tuple[int, ...]] | None,
    deadman: int,
) -> Sample:
    """Return a good message's sample.

    Args:
        stamp: [ns].
        frame: frame_id of the message.
        received: when it was sent, by the local clock [s].
        content: axes and buttons.
        before: those of the sample before it.
        deadman: the button to hold.
    """
    axes, buttons = content
    levers, held = levers_from_axes(axes), buttons[deadman] == 1
    return Sample(
        received=received,
        stamp=stamp,
        heartbeat=heartbeat_of(frame),
        same=content == before,
        good=True,
        levers=levers,
        held=held,
    )


def unreadable_sample(received: float) -> Sample:
    """Return what stands for a message that cannot be read."""
    return Sample(received)


def heartbeat_of(frame: str) -> int:
    """Return the count that a Joy's frame_id carries ("heartbeat:17"), or `NO_HEARTBEAT`."""
    digits = frame.removeprefix(HEARTBEAT)
    if not frame.startswith(HEARTBEAT) or not (digits.isascii() and digits.isdigit()) or len(digits) > 18:
        return NO_HEARTBEAT
    return int(digits)
