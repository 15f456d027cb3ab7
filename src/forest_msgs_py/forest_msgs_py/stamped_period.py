"""Time between samples, from their stamps: real machines are jittery, and a loop wants the true dt."""

from __future__ import annotations

LONGEST = 0.05  # [s]; a machine slower than 20 Hz is not followed


class StampedPeriod:
    """Measures dt from successive stamps, kept between half the nominal period and `LONGEST`.

    Args:
        nominal: the period [s] that the publisher aims at; also the first dt.
    """

    def __init__(self, nominal: float) -> None:
        self._nominal = nominal
        self._last: int | None = None

    @property
    def started(self) -> bool:
        """Whether a stamp has been seen."""
        return self._last is not None

    def since(self, stamp_ns: int) -> float:
        """Return the time from the last stamp to this one [s], clipped."""
        last, self._last = self._last, stamp_ns
        elapsed = self._nominal if last is None else (stamp_ns - last) * 1e-9
        return max(0.5 * self._nominal, min(LONGEST, elapsed))


class TimeInForce(StampedPeriod):
    """The same for what was said last: how long it has been in force, 0 where half a period has not passed.

    That time is not lost: it counts for what is said now, when the next one comes.
    """

    def since(self, stamp_ns: int) -> float:
        """Return the time from the last stamp that counted to this one [s]."""
        last = self._last
        if last is None or (stamp_ns - last) * 1e-9 >= 0.5 * self._nominal:
            return super().since(stamp_ns)
        self._last = min(last, stamp_ns)  # a stamp goes back where a clock was set
        return 0.0
