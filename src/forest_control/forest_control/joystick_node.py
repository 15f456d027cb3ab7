"""A joystick without hands: the thesis' test input or a person's recorded levers on /joy, deadman held.

It waits until somebody listens, rests for a moment, plays, lets the deadman go, and ends.
"""

import sys
from functools import partial
from pathlib import Path

from rclpy.node import Node

from forest_control.levers import BUTTON_COUNT, LEFT_SHOULDER, REST, Levers, axes_from_levers
from forest_control.sources import LEAD_IN, LEAD_OUT, THESIS_DURATION, LeverRecord, read_levers, thesis_levers
from forest_msgs_py import topics
from forest_msgs_py.messages import ns_to_stamp
from forest_msgs_py.node import Finished, run_node
from forest_msgs_py.pace import pace
from forest_msgs_py.parameters import declare
from forest_msgs_py.topics import JOY_RATE_HZ, message_class


class JoystickNode(Node):
    """Shell around `sources`."""

    def __init__(self) -> None:
        super().__init__("joystick")
        self._pace = pace(self)
        self.run = self._pace.run
        get = partial(declare, self)
        source = get("source", "thesis", "thesis, or the path of a CSV of levers")
        duration = get("duration", 0.0, "how long to play; 0: as long as the source is", "s", 0.0, 86400.0)
        self._tip_speed = get("tip_speed", 0.5, "tip speed at full deflection", "m/s", 0.48, 3.0)
        self._listeners = get("wait_for_subscribers", 1, "listeners to wait for", low=0, high=100)
        self._deadman = get("deadman_button", LEFT_SHOULDER, "button to hold", low=0, high=BUTTON_COUNT - 1)
        self._record: LeverRecord | None = None if source == "thesis" else read_levers(Path(source))
        length = THESIS_DURATION if self._record is None else self._record.times[-1]
        self._duration = duration or length
        self._publisher = self._pace.publisher(topics.JOY)
        self._message = message_class(topics.JOY)
        self._begun: float | None = None
        # In lockstep it answers every step.
        self._pace.every(0.0 if self._pace.lockstep else 1.0 / JOY_RATE_HZ, self._on_timer)

    def _on_timer(self) -> None:
        if self._begun is None:
            if not self._pace.lockstep and self._publisher.get_subscription_count() < self._listeners:
                return
            self._begun = self._pace.now()
            self.get_logger().info(f"playing for {self._duration:g} s")
        played = self._pace.now() - self._begun - LEAD_IN
        if played >= self._duration + LEAD_OUT and not self._pace.lockstep:
            raise Finished
        self._publish(self._levers(played), played < self._duration)

    def _levers(self, played: float) -> Levers:
        if not 0.0 <= played < self._duration:
            return REST
        if self._record is None:
            return thesis_levers(played, self._tip_speed)
        return self._record.at(played)

    def _publish(self, levers: Levers, held: bool) -> None:
        message = self._message(axes=axes_from_levers(levers), buttons=[0] * BUTTON_COUNT)
        message.header.stamp = ns_to_stamp(self._pace.stamp())
        message.header.frame_id = "joystick"
        message.buttons[self._deadman] = int(held)
        self._publisher.publish(message)

    def stop(self) -> None:
        """Last words: deadman released."""
        self._publish(REST, False)


def main() -> None:
    """Run the node until it has played, or is told to stop."""
    sys.exit(run_node(JoystickNode))


if __name__ == "__main__":
    main()
