"""A program's tip velocity: TwistStamped on `delta_twist_cmds` in, taught commands out.

The topic and its meaning are MoveIt Servo's: velocities come as a stream, and one that is older than 0.1 s
stops the tip. A person holds the deadman on /joy, as for taught work.
"""

import sys
from typing import Any

from rclpy.node import Node

from forest_control.config.cycle_parameters import TwistParameters
from forest_control.operator.taught_command import NO_COMMAND, to_values
from forest_control.taught import twist_follower
from forest_control.taught.cycle_topics import CycleInputs
from forest_control.taught.twist_follower import NO_WISH, Follower, TwistError, wish_of
from forest_msgs_py.clock.node_clock import LiveClock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import run_node, subscription
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.serialization.unpacking import read_position

TOLD_PERIOD = 0.1  # [s] between two looks whether /diagnostics has news
PART = "program's velocity"  # on /diagnostics


class TwistNode(Node):
    """Shell around `twist_follower`."""

    def __init__(self) -> None:
        super().__init__("twist")
        p = declare(self, TwistParameters)
        self._node_clock = clock = LiveClock(self)
        self._command = number_publisher(clock, topics.TAUGHT_COMMAND)
        said = clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(self, (PART,), "the tip is held", said)
        self._inputs = CycleInputs(clock, p.centre)
        self._follower, self._wish = Follower(), NO_WISH
        subscription(self, topics.TWIST_WISH, self._on_wish)
        clock.on(topics.TIP_POSE, self._on_tip)
        clock.every(TOLD_PERIOD, self._tell)

    def _on_wish(self, message: Any) -> None:
        linear, angular = message.twist.linear, message.twist.angular
        parts = (linear.x, linear.y, linear.z), (angular.x, angular.y, angular.z)
        try:
            self._wish = wish_of(message.header.frame_id, *parts, self._node_clock.now())
            problem = ""
        except TwistError as error:
            self._wish, problem = NO_WISH, str(error)
        self._diagnostics.note(PART, problem)

    def _on_tip(self, data: bytes, _sent: float) -> None:
        tip, stamp = read_position(data), self._node_clock.stamp()
        if tip is None:
            return
        seen, now = self._inputs.seen(tip, stamp), self._node_clock.now()
        self._follower, command = twist_follower.step(self._follower, self._wish, seen, now)
        if command is not None:
            self._command.publish(stamp, to_values(self._follower.run, command))

    def _tell(self) -> None:
        self._diagnostics.publish(self._node_clock.stamp())

    def stop(self) -> None:
        """Last words: no run goes on."""
        self._command.publish(self._node_clock.stamp(), to_values(self._follower.run, NO_COMMAND))


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(TwistNode))


if __name__ == "__main__":
    main()
