"""When a machine that keeps the graph's time has to move, and what it leaves out when it is late."""

CATCH_UP = 20  # periods; what is later than that is left out rather than rushed through


class Deadlines:
    """Deadlines at equal distances on the monotonic clock.

    Args:
        now: the clock [ns].
        period: between two deadlines [ns].
    """

    def __init__(self, now: int, period: int) -> None:
        self._period = period
        self._next = now + period
        self.missed = 0
        """Deadlines at which the machine moved late, or not at all."""

    def wait(self, now: int) -> float:
        """Return the time [s] until the next deadline."""
        return max(0, self._next - now) * 1e-9

    def due(self, now: int) -> tuple[int, int]:
        """Return how many periods to move on by, and how many to leave out before that."""
        due = max(0, (now - self._next) // self._period + 1)
        self._next += due * self._period
        self.missed += max(0, due - 1)
        left_out = max(0, due - CATCH_UP)
        return due - left_out, left_out
