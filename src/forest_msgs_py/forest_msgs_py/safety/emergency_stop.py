"""The emergency stop of a node: latched by a topic or a service, reset only on purpose.

`emergency_stop`: true, from anybody, stops; false, and a node's reset service, reset every node that finds
nothing against it. `emergency_stopped`: each node says there whether it is stopped, latched, from its start
on; true stops the others, also one that starts later, and false resets them. So a stop outlives the restart
of any one node, and a node that refuses a reset stops the others again.

The first false of a node resets nobody: it only says that the node has started, and who was stopped before
stays so. What follows it is said on a change. A middleware that does not count messages (`FIRST`) leaves
resets to `emergency_stop`.

A false resets only if it is said on purpose: not before the last stop, and not by somebody who says false
again and again, as panels tell their state. What comes within `AGAIN` of another false, no true between,
resets nothing.

Whoever types a message by hand offers it volatile, a panel may latch it, a simple one sends it best-effort.
Live, a subscription hears all of them only if it is volatile and best-effort itself; but it must lose nothing
of a reliable publisher's, and only a transient-local one hears what was said before. Hence three. A message
that comes twice counts once; of the past only a stop counts.
"""

import time
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topic_qos import READER_DEPTH, qos
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import publisher, subscription
from forest_msgs_py.safety.input_status import UnmatchedPublishers

AGAIN = 1.0  # [s]
REMEMBERED = 32  # commands heard live, which the other subscriptions repeat
FIRST = 1  # publication_sequence_number of a publisher's first message


class EmergencyStop:
    """Latch of one node.

    Args:
        node: that stands still while `pressed`.
        prefix: of the services' names: "" or "~/".
        objection: what stands against a reset now, "" for nothing.
        act: called at once when the stop is pressed.
        said: publisher of /emergency_stopped, if the node has one of its own clock.
    """

    def __init__(
        self,
        node: Node,
        prefix: str,
        objection: Callable[[], str],
        act: Callable[[], None],
        said: Any = None,
    ) -> None:
        self.pressed, self._pressed_at = False, 0  # [ns] since the epoch, as senders stamp
        self._presses = 0
        self._node, self._objections, self._act = node, [objection], act
        self._false_at = -AGAIN  # [s, monotonic] when a false was heard, if no true has come since
        self._heard: deque[int] = deque(maxlen=REMEMBERED)
        self._command = publisher(node, topics.EMERGENCY_STOP)
        self._state = publisher(node, topics.EMERGENCY_STOPPED) if said is None else said
        self._message = message_class(topics.EMERGENCY_STOP)
        name = topics.EMERGENCY_STOP.name
        subscription(node, topics.EMERGENCY_STOP, self._on_command)
        # Silent: with everybody who is heard otherwise they would complain of an incompatible QoS.
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        latched = qos(topics.EMERGENCY_STOPPED, reading=True)
        lossy = QoSProfile(depth=READER_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
        node.create_subscription(self._message, name, self._on_latched, latched, event_callbacks=silent)
        node.create_subscription(self._message, name, self._on_command, lossy, event_callbacks=silent)
        self._states = subscription(node, topics.EMERGENCY_STOPPED, self._on_state)
        self._others = UnmatchedPublishers(node, self._states)
        node.create_service(Trigger, f"{prefix}emergency_stop", self._on_press)
        node.create_service(Trigger, f"{prefix}reset_emergency_stop", self._on_reset)
        self._tell()

    def waiting(self) -> str:
        """Return "": nobody has to be there."""
        return ""

    def unheard(self) -> str:
        """Return which publishers of /emergency_stopped cannot be heard, and why; "" for none."""
        return self._others.told()

    def values(self) -> dict[str, Any]:
        """Return what /diagnostics tells."""
        return {"pressed": self.pressed, "presses since start": self._presses}

    def refuse_while(self, objection: Callable[[], str]) -> None:
        """Ask somebody else first what stands against a reset; "" for nothing."""
        self._objections.insert(0, objection)

    def press(self, said_ns: int | None = None) -> None:
        """Stop, until reset.

        Args:
            said_ns: when a node said that it is stopped [ns since the epoch]: a stopped node that hears it,
                its own word among others, must not take a reset that was asked for since as older.
        """
        now = time.time_ns()
        again = self.pressed and said_ns is not None
        self._pressed_at = max(self._pressed_at, min(now, said_ns or now)) if again else now
        if not self.pressed:
            self.pressed, self._presses = True, self._presses + 1
            self._act()
            self._node.get_logger().error("emergency stop")
            self._tell()

    def reset(self) -> str:
        """Reset unless something stands against it; return what that is, or ""."""
        if not self.pressed:
            return ""
        objection = next(filter(None, (ask() for ask in self._objections)), "")
        if objection:
            self._node.get_logger().warning(f"emergency stop stays: {objection}")
        else:
            self.pressed = False
            self._node.get_logger().info("emergency stop reset")
        self._tell()
        return objection

    def _tell(self) -> None:
        self._state.publish(self._message(data=self.pressed))

    def _on_command(self, message: Any, info: dict[str, int]) -> None:
        if info["source_timestamp"] in self._heard:
            return
        self._heard.append(info["source_timestamp"])
        if message.data:
            self._false_at = -AGAIN
            self.press()
            return
        before, self._false_at = self._false_at, time.monotonic()
        if info["source_timestamp"] > self._pressed_at and self._false_at - before >= AGAIN:
            self.reset()

    def _on_latched(self, message: Any, info: dict[str, int]) -> None:
        if message.data and info["source_timestamp"] not in self._heard:
            self.press()

    def _on_state(self, message: Any, info: dict[str, int]) -> None:
        """Act on the newest word of those that wait: two nodes that both did what is past would not agree."""
        said, handle = [(message, info)], self._states.handle
        with handle:
            while (taken := handle.take_message(self._message, False)) is not None:
                said.append(taken)
        for newest, about in reversed(said):
            if newest.data:
                self.press(about["source_timestamp"])
            elif (about.get("publication_sequence_number") or FIRST) == FIRST:
                continue
            elif about["source_timestamp"] > self._pressed_at:
                self.reset()
            return

    def _on_press(self, _request: Any, response: Any) -> Any:
        self.press()
        response.success, response.message = True, "stopped"
        return response

    def _on_reset(self, _request: Any, response: Any) -> Any:
        objection = self.reset()
        if not objection:
            self._command.publish(self._message(data=False))
        response.success = not objection
        response.message = f"refused: {objection}" if objection else "reset"
        return response
