"""What a node hears on a topic, as /diagnostics tells it: how often, how old, and whom it cannot hear."""

import math
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSCompatibility, ReliabilityPolicy, qos_check_compatible

from forest_msgs_py.runtime.polled_subscription import CLOCK_TOLERANCE

WINDOW = 0.5  # [s] over which a rate is measured, at least
LATE = 0.2  # [s] that no message needs on a link by which a crane is driven


class InputStatus:
    """Statistics of one subscription, computed when they are asked for.

    Args:
        node: that subscribes.
        clock: of the node.
        subscription: the polled subscription, or what the clock's `on` gave.
        what: is waited for, as "a joystick"; "" for nothing.
        is_missed: whether it is; default: as long as no message has ever come.
    """

    def __init__(
        self,
        node: Node,
        clock: Any,
        subscription: Any,
        what: str = "",
        is_missed: Callable[[], bool] | None = None,
    ) -> None:
        self._clock, self._subscription, self._what = clock, subscription, what
        self._is_missed = is_missed or (lambda: bool(what) and subscription.count == 0)
        self._name: str = subscription.subscription.topic_name
        asks = (
            not clock.lockstep
            and subscription.subscription.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        )
        self._unmatched = UnmatchedPublishers(node, subscription.subscription) if asks else None
        # Of a latched topic a late reader gets what is old by right.
        latched = subscription.subscription.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        self._node, self._tells_clocks = node, not (clock.lockstep or latched)
        self._since, self._before, self._rate = clock.now(), 0, math.nan

    def waiting(self) -> str:
        """Return what is waited for, and where; "" for nothing."""
        return f"waiting for {self._what} on {self._name}" if self._is_missed() else ""

    def unheard(self) -> str:
        """Return which publishers the subscription cannot hear, or not in time, and why; "" for none."""
        unmatched = self._unmatched.told() if self._unmatched is not None else ""
        return "; ".join(filter(None, (unmatched, self._untimely()))) if self._tells_clocks else unmatched

    def _untimely(self) -> str:
        """Return whose messages are from the future or long past, by the hosts' clocks; "" for nobody's."""
        way = self._subscription.shortest_way()
        if -CLOCK_TOLERANCE <= way <= LATE or math.isinf(way):
            return ""
        ends = self._node.get_publishers_info_by_topic(self._name)
        who = ", ".join(dict.fromkeys(f"{end.node_namespace.rstrip('/')}/{end.node_name}" for end in ends))
        if way < 0.0:
            return f"{self._name}: the clock of {who} is {-way:.1f} s ahead of this host's"
        return f"{self._name}: the clock of {who} is {way:.1f} s behind this host's, or the link is late"

    def values(self) -> dict[str, Any]:
        """Return age, rate and count of the messages."""
        now, count, age = self._clock.now(), self._subscription.count, self._subscription.age()
        if (elapsed := now - self._since) >= WINDOW:
            self._rate = (count - self._before) / elapsed
            self._since, self._before = now, count
        return {
            f"{self._name} age [s]": "never heard" if math.isinf(age) else age,
            f"{self._name} rate [Hz]": "unknown" if math.isnan(self._rate) else self._rate,
            f"{self._name} messages": count,
        }


class UnmatchedPublishers:
    """Publishers that offer less than a subscription asks for: the middleware brings nothing of theirs.

    ROS tells the publisher's side of that, which may be somebody else's, on a computer that nobody looks at.
    """

    def __init__(self, node: Node, subscription: Any) -> None:
        self._node, self._subscription = node, subscription

    def told(self) -> str:
        """Return who is not heard, and why; "" for nobody."""
        name, asked = self._subscription.topic_name, self._subscription.qos_profile
        found: dict[str, str] = {}
        for one in self._node.get_publishers_info_by_topic(name):
            fits, why = qos_check_compatible(one.qos_profile, asked)
            if fits == QoSCompatibility.ERROR:
                found[f"{one.node_namespace.rstrip('/')}/{one.node_name}"] = why
        if not found:
            return ""
        reasons = filter(None, next(iter(found.values())).lower().replace("error: ", "").split(";"))
        return f"{name} of {', '.join(found)} is not heard: {', '.join(reasons)}"
