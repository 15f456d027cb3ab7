"""Time between samples, from their stamps: real machines are jittery, and a loop wants the true dt."""

from __future__ import annotations

LONGEST = 0.05  # [s]; a machine slower than 20 Hz is not followed


class StampedPeriod:
    """Measures dt from successive stamps, kept between a least one and `LONGEST`.

    Args:
        nominal: the period [s] that the publisher aims at; also the first dt.
        least: dt [s]; default: half the nominal period.
    """

    def __init__(self, nominal: float, least: float | None = None) -> None:
        self._nominal, self._least = nominal, 0.5 * nominal if least is None else least
        self._last: int | None = None

    @property
    def started(self) -> bool:
        """Whether a stamp has been seen."""
        return self._last is not None

    def since(self, stamp_ns: int) -> float:
        """Return the time from the last stamp to this one [s], clipped."""
        last, self._last = self._last, stamp_ns
        elapsed = self._nominal if last is None else (stamp_ns - last) * 1e-9
        return max(self._least, min(LONGEST, elapsed))
