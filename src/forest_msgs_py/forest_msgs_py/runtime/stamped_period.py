"""Time between samples, from their stamps: real machines are jittery, and a loop wants the true dt.

But a loop's time must not run faster than the clock, whatever the stamps say: a sampler of 1 kHz, samples
without stamp and several talkers on one topic would otherwise make ramps, integrals and references run away.
So what comes sooner than half the nominal period is no step, and all steps together take no longer than has
passed since the first, but for `LONGEST`.
"""

LONGEST = 0.05  # [s]; a machine slower than 20 Hz is not followed
NO_STAMP = 0  # [ns]


class StampedPeriod:
    """Measures dt from successive stamps, kept between half the nominal period and `LONGEST`.

    Args:
        nominal: the period [s] that the publisher aims at; also the first dt.
    """

    def __init__(self, nominal: float) -> None:
        self._nominal, self._least = nominal, 0.5 * nominal
        self._last: int | None = None
        self._sent, self._credit = 0.0, LONGEST

    @property
    def started(self) -> bool:
        """Whether a stamp has been seen."""
        return self._last is not None

    def since(self, stamp_ns: int) -> float:
        """Return the time from the last stamp to this one [s], clipped."""
        last, self._last = self._last, stamp_ns
        elapsed = self._nominal if last is None else (stamp_ns - last) * 1e-9
        return max(self._least, min(LONGEST, elapsed))

    def step(self, stamp_ns: int, sent: float) -> float:
        """Return the time to step by [s], or 0 for a sample that comes too soon for a step.

        Args:
            stamp_ns: the sample's; of one without (`NO_STAMP`) counts when it was sent.
            sent: when that was, by the local clock [s].
        """
        stamp = stamp_ns if stamp_ns != NO_STAMP else round(sent * 1e9)
        if self._last is not None:
            self._credit = min(LONGEST, self._credit + max(0.0, sent - self._sent))
        self._sent = max(self._sent, sent)
        elapsed = self._nominal if self._last is None else (stamp - self._last) * 1e-9
        if elapsed < 0.0:  # the sender's time began anew
            elapsed = self._nominal
        dt = min(LONGEST, elapsed, self._credit)
        if dt < self._least:
            return 0.0
        self._last, self._credit = stamp, self._credit - dt
        return dt


class TimeInForce(StampedPeriod):
    """The same for what was said last: how long it has been in force, 0 where half a period has not passed.

    That time is not lost: it counts for what is said now, when the next one comes.
    """

    def since(self, stamp_ns: int) -> float:
        """Return the time from the last stamp that counted to this one [s]."""
        last = self._last
        if last is None or (stamp_ns - last) * 1e-9 >= self._least:
            return super().since(stamp_ns)
        self._last = min(last, stamp_ns)  # a stamp goes back where a clock was set
        return 0.0
