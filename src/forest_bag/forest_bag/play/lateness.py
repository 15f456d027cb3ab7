"""How late messages were, counted in bins."""

from forest_msgs_py.types import NS_PER_S

BIN_NS = 10_000
BINS = 10_000


class Lateness:
    """A histogram, so that a day of messages takes no more memory than a minute."""

    def __init__(self) -> None:
        self.count = 0
        self.largest_ns = 0
        self._bins = [0] * (BINS + 1)

    def add(self, late_ns: int) -> None:
        """Take in one message."""
        self.count += 1
        self.largest_ns = max(self.largest_ns, late_ns)
        self._bins[min(late_ns // BIN_NS, BINS)] += 1

    def quantile(self, share: float) -> float:
        """Return the lateness [s] that a share of the messages does not exceed; its bin's upper end."""
        left = share * self.count
        for place, count in enumerate(self._bins[:BINS]):
            left -= count
            if left <= 0:
                return min((place + 1) * BIN_NS, self.largest_ns) / NS_PER_S
        return self.largest_ns / NS_PER_S
