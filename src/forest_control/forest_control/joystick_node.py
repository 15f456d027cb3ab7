"""A joystick without an operator: the thesis' test input, recorded levers, or a bag's joystick on /joy.

It waits until somebody listens, rests for a moment, plays with the deadman held, releases it, and
ends. A bag's messages are sent again as they are, under new stamps. The parameter `faults` names
faults at set times.
"""

import sys
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from forest_control.operator.joystick_sources import JoystickParameters
from forest_control.operator.scripted_joystick import JoyMessage, ScriptedJoystick
from forest_msgs_py.clock.node_clock import node_clock, publishes_bytes
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.interfaces.topics import JOY_RATE_HZ, message_class
from forest_msgs_py.runtime.node import Finished, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.serialization.packing import pack_joy


class JoystickNode(Node):
    """Shell around `ScriptedJoystick`."""

    def __init__(self) -> None:
        super().__init__("joystick")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        p = declare(self, JoystickParameters)
        self._joystick, self._listeners = ScriptedJoystick(p, _decoded), p.wait_for_subscribers
        self._publisher = self._node_clock.publisher(topics.JOY)
        self._publish = publishes_bytes(self._publisher)
        self._begun: float | None = None
        # In lockstep it answers every step.
        self._node_clock.every(0.0 if self._node_clock.lockstep else 1.0 / JOY_RATE_HZ, self._on_timer)

    def _on_timer(self) -> None:
        if self._begun is None:
            if not self._node_clock.lockstep and self._publisher.get_subscription_count() < self._listeners:
                return
            # Before the beginning: a process' first line takes a tenth of a second on a busy computer.
            self.get_logger().info(f"playing for {self._joystick.length:g} s")
            self._begun = self._node_clock.now()
        elapsed = self._node_clock.now() - self._begun
        if (
            self._joystick.is_over(elapsed) and not self._node_clock.lockstep
        ):  # there, the machine ends the run
            raise Finished
        message = self._joystick.message(elapsed)
        if message is not None:
            self._send(message)

    def _send(self, message: JoyMessage) -> None:
        self._publish(
            pack_joy(self._node_clock.stamp(), message.frame, JoyValues(message.axes, message.buttons))
        )

    def stop(self) -> None:
        """Last words: deadman released."""
        self._send(self._joystick.released())


def _decoded(data: bytes) -> JoyMessage:
    message: Any = deserialize_message(data, message_class(topics.JOY))
    return JoyMessage(message.header.frame_id, tuple(message.axes), tuple(message.buttons))


def main() -> None:
    """Run the node until it has played, or is told to stop."""
    sys.exit(run_node(JoystickNode))


if __name__ == "__main__":
    main()
