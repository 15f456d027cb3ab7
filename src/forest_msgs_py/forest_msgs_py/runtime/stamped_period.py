"""Time between samples, from their stamps: real machines are jittery, and a loop wants the true dt.

But a loop's time must not run faster than the clock, whatever the stamps say: a sampler of 1 kHz, samples
without stamp and several talkers on one topic would otherwise make ramps, integrals and references run away.
So what comes sooner than half the nominal period is no step, and all steps together take no longer than has
passed since the first, but for `LONGEST`.

The nominal period is what the publisher aims at, and the first dt. Each function returns what is remembered
after a sample, and its dt [s].
"""

from typing import NamedTuple

from forest_msgs_py.runtime.stamp_order import NO_STAMP

LONGEST = 0.05  # [s]; a machine slower than 20 Hz is not followed


class StampedPeriod(NamedTuple):
    """What is remembered of the samples before."""

    started: bool = False  # a sample has come
    last: int = NO_STAMP  # [ns] stamp from which the next dt counts
    sent: float = 0.0  # [s] when the newest was sent, by the local clock
    credit: float = LONGEST  # [s] by which the loop's time may still run


BEGIN = StampedPeriod()


def clipped_period(before: StampedPeriod, stamp_ns: int, nominal: float) -> tuple[StampedPeriod, float]:
    """Return the time from the last stamp to this one, between half the nominal period and `LONGEST` [s]."""
    elapsed = _elapsed(before, stamp_ns, nominal)
    return before._replace(started=True, last=stamp_ns), max(0.5 * nominal, min(LONGEST, elapsed))


def step_period(
    before: StampedPeriod, stamp_ns: int, sent: float, nominal: float
) -> tuple[StampedPeriod, float]:
    """Return the time to step by [s], or 0 for a sample that comes too soon for a step.

    Args:
        before: the sample.
        stamp_ns: the sample's; of one without (`NO_STAMP`) counts when it was sent.
        sent: when that was, by the local clock [s].
        nominal: period [s].
    """
    stamp = stamp_ns if stamp_ns != NO_STAMP else int(sent * 1e9 + 0.5)
    credit = before.credit
    if before.started:
        credit = min(LONGEST, credit + max(0.0, sent - before.sent))
    elapsed = _elapsed(before, stamp, nominal)
    if elapsed < 0.0:  # the sender's time began anew
        elapsed = nominal
    dt = min(LONGEST, elapsed, credit)
    newest = max(before.sent, sent)
    if dt < 0.5 * nominal:
        return before._replace(sent=newest, credit=credit), 0.0
    return StampedPeriod(started=True, last=stamp, sent=newest, credit=credit - dt), dt


def time_in_force(before: StampedPeriod, stamp_ns: int, nominal: float) -> tuple[StampedPeriod, float]:
    """Return for how long what was said last has been in force [s], 0 where half a period has not passed.

    That time is not lost: it counts for what is said now, when the next one comes.
    """
    if _elapsed(before, stamp_ns, nominal) >= 0.5 * nominal:
        return clipped_period(before, stamp_ns, nominal)
    return before._replace(last=min(before.last, stamp_ns)), 0.0  # a stamp goes back where a clock was set


def _elapsed(before: StampedPeriod, stamp_ns: int, nominal: float) -> float:
    return (stamp_ns - before.last) * 1e-9 if before.started else nominal
