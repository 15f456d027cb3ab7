"""A joystick on /joy: the device under a hand, the thesis' test input, recorded levers, or a bag's joystick.

A device is read below /dev/input, no other joystick node is needed; unplugged or hanging, it falls
silent. A source waits until somebody listens, rests for a moment, plays with the deadman held,
releases it, and ends. A bag's messages are sent again as they are, under new stamps. The parameter
`faults` names faults at set times.
"""

import sys
import time
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from forest_control.config.joystick_arguments import ros_arguments
from forest_control.config.joystick_file import load_devices
from forest_control.operator import device_joystick
from forest_control.operator.device_joystick import RESTING, DeviceJoystick, DeviceParameters, Following
from forest_control.operator.input_devices import InputDevices
from forest_control.operator.joystick_sources import JoystickParameters
from forest_control.operator.scripted_joystick import JoyMessage, ScriptedJoystick
from forest_msgs_py.clock.node_clock import node_clock, publishes_bytes
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.interfaces.topics import JOY_RATE_HZ, message_class
from forest_msgs_py.runtime.node import Finished, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import ParameterError
from forest_msgs_py.serialization.packing import pack_joy

FRAME = (
    "joy"  # frame_id of a device's samples, as of ROS's joy: no heartbeat, so that stillness can be judged
)


class JoystickNode(Node):
    """Shell around `DeviceJoystick` or `ScriptedJoystick`."""

    def __init__(self) -> None:
        super().__init__("joystick")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        self._p, self._device = declare(self, JoystickParameters), declare(self, DeviceParameters)
        self._publisher = self._node_clock.publisher(topics.JOY)
        self._publish = publishes_bytes(self._publisher)
        self._begun: float | None = None
        if self._device.device and self._node_clock.lockstep:
            raise ParameterError(
                "parameter 'device': a hand moves in real time; allowed in lockstep: a source"
            )
        if self._device.device:
            mappings = load_devices(self._device.device, self._p.deadman_button)
            self._devices = InputDevices(mappings, self._p.deadman_button)
            self._hand = DeviceJoystick((Following(),) * len(mappings))
            self._said = ""
        else:
            self._joystick = ScriptedJoystick(self._p, _decoded)
        # In lockstep it answers every step.
        period = 0.0 if self._node_clock.lockstep else 1.0 / JOY_RATE_HZ
        self._node_clock.every(period, self._read if self._device.device else self._play)

    def _read(self) -> None:
        """Send what the device says."""
        now = time.monotonic()
        readings = self._devices.read(now)
        self._hand, sent = device_joystick.step(
            self._hand, readings, now, self._device, self._p.deadman_button
        )
        self._say(self._devices.problem or sent.problem, f"joystick: {self._devices.names}")
        if sent.values is not None:
            self._send(JoyMessage(FRAME, *sent.values))

    def _say(self, problem: str, names: str) -> None:
        if (problem or names) == self._said:
            return
        self._said = problem or names
        if problem:  # rclpy: a line of code logs at one level
            self.get_logger().warning(problem)
        else:
            self.get_logger().info(names)

    def _play(self) -> None:
        """Send what the source says."""
        if self._begun is None:
            listeners = self._publisher.get_subscription_count()
            if not self._node_clock.lockstep and listeners < self._p.wait_for_subscribers:
                return
            # Before the beginning: a process' first line takes a tenth of a second on a busy computer.
            self.get_logger().info(f"playing for {self._joystick.length:g} s")
            self._begun = self._node_clock.now()
        elapsed = self._node_clock.now() - self._begun
        if self._joystick.is_over(elapsed) and not self._node_clock.lockstep:
            raise Finished  # in lockstep, the machine ends the run
        message = self._joystick.message(elapsed)
        if message is not None:
            self._send(message)

    def _send(self, message: JoyMessage) -> None:
        values = JoyValues(message.axes, message.buttons)
        self._publish(pack_joy(self._node_clock.stamp(), message.frame, values))

    def stop(self) -> None:
        """Last words: deadman released."""
        self._send(JoyMessage(FRAME, *RESTING) if self._device.device else self._joystick.released())


def _decoded(data: bytes) -> JoyMessage:
    message: Any = deserialize_message(data, message_class(topics.JOY))
    return JoyMessage(message.header.frame_id, tuple(message.axes), tuple(message.buttons))


def main() -> None:
    """Run the node until it has played, or is told to stop."""
    sys.exit(run_node(JoystickNode, [sys.argv[0], *ros_arguments(sys.argv[1:], __doc__ or "")]))


if __name__ == "__main__":
    main()
