"""Which voltages the simulated valves get: the newest good command, or zero."""

import math

from forest_description.types import ZERO, Vec3
from forest_msgs_py.runtime import stamp_order


class VoltageInput:
    """The voltages commanded to the valves.

    They are zero when the newest command is bad, or older than the command timeout. A command that
    overtook a newer one is bad, unless it is zero.

    Args:
        timeout: age [s] at which a command counts as zero.
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self._voltages, self._received = ZERO, -math.inf
        self._order = stamp_order.FIRST

    def take(self, values: Vec3, stamp_ns: int, arrival: float, problem: str = "") -> str:
        """Take the newest command; return what is wrong with it, or "".

        Args:
            values: voltages [V]; ignored if there is a problem.
            stamp_ns: of the message [ns].
            arrival: local time of its arrival [s].
            problem: what was wrong with the message itself.
        """
        if not problem and values != ZERO:  # zero is obeyed in any order
            problem = stamp_order.disorder(self._order, "valve_voltages", stamp_ns)
            self._order = stamp_order.updated_order(self._order, stamp_ns, arrival, self.timeout)
        self._voltages = ZERO if problem else values
        self._received = arrival
        return problem

    def is_missed(self, now: float) -> bool:
        """Tell whether no command is as young as the timeout demands, at a time [s]."""
        return now - self._received > self.timeout

    def at(self, now: float) -> Vec3:
        """Return the voltages [V] at a time [s]."""
        return ZERO if self.is_missed(now) else self._voltages
