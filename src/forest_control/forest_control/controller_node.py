"""The controller as a node: /joy and /joint_states in, /valve_commands and the tip's motion out.

It steps when the machine's state arrives. Without a fresh, finite joystick with the deadman held, or without
a fresh state, it commands zero.
"""

import math
import sys
from functools import partial
from typing import Any

from rclpy.node import Node

from forest_control import controller
from forest_control.levers import BUTTON_COUNT, LEFT_SHOULDER, REST, RIGHT_Y, Levers, Triple, levers_from_axes
from forest_control.profile import load_profile, shipped
from forest_control.schemes import Scheme
from forest_control.tunables import TUNABLES, as_typed, settings_from
from forest_description.kinematics import tip_position, tip_velocity
from forest_description.machine import load_machine
from forest_description.urdf import robot_description
from forest_msgs_py import topics
from forest_msgs_py.messages import float_array, pose_stamped, read_joint_state, read_joy, twist_stamped
from forest_msgs_py.node import run_node
from forest_msgs_py.pace import pace
from forest_msgs_py.parameters import Tunables, declare
from forest_msgs_py.stamped_period import StampedPeriod
from forest_msgs_py.topics import message_class

FRAME = "base_link"
ZERO: Triple = (0.0, 0.0, 0.0)
WATCHDOG_PERIOD = 0.02  # [s]


class ControllerNode(Node):
    """Shell around `controller.step`."""

    def __init__(self) -> None:
        super().__init__("controller")
        self._pace = pace(self)
        self.run = self._pace.run
        get = partial(declare, self)
        machine = load_machine(get("machine", "c180", "shipped machine, or path of a machine file"))
        self._machine, defaults = machine, controller.Settings()
        tunables = Tunables(self, {"profile": load_profile})
        text = f"operator's profile: {', '.join(shipped())}, or path of a file; what is also given wins"
        profile = load_profile(tunables.declare("profile", "default", text))
        for one in TUNABLES:
            tunables.declare(one.name, profile.get(one.name, as_typed(one.name, defaults)), *one[1:])
        self._core = controller.parameters(machine, settings_from(tunables.values))
        self._period = StampedPeriod(get("period", 0.005, "nominal period of the state", "s", 1e-4, 0.1))
        self._joy_timeout = get("joy_timeout", 0.15, "age at which the joystick is lost", "s", 0.01, 2.0)
        self._state_timeout = get("state_timeout", 0.1, "age at which the state is lost", "s", 0.01, 0.2)
        self._deadman = get("deadman_button", LEFT_SHOULDER, "button to hold", low=0, high=BUTTON_COUNT - 1)
        self._plain = get("plain_arrays", False, "publish Float64MultiArray without stamp")
        self._state = controller.REST
        tunables.watch(self._tune)
        self._state_received = self._joy_received = -math.inf
        self._levers, self._held = REST, False
        self._command = self._pace.publisher(topics.VALVE_COMMANDS)
        self._pose = self._pace.publisher(topics.TIP_POSE)
        self._twist = self._pace.publisher(topics.TIP_TWIST)
        self._wish = self._pace.publisher(topics.TIP_TWIST_COMMAND)
        if get("publish_description", False, "publish robot_description; where no simulator does"):
            self._description = self._pace.publisher(topics.ROBOT_DESCRIPTION)
            text = robot_description(machine)
            self._description.publish(message_class(topics.ROBOT_DESCRIPTION)(data=text))
        self._joy = self._pace.inbox(topics.JOY)
        self._pace.on(topics.JOINT_STATES, self._on_joint_states)
        self._pace.every(WATCHDOG_PERIOD, self._watch)

    def _tune(self, values: dict[str, Any]) -> None:
        """Follow parameters that were set while the machine may be moving."""
        self._core = controller.parameters(self._machine, settings_from(values))
        self._state = self._state._replace(changed=True)

    def _read_joy(self) -> None:
        """Take the newest joystick sample, if there is one."""
        arrival = self._joy.newest()
        if arrival is None:
            return
        reading = read_joy(arrival.message, RIGHT_Y + 1, self._deadman + 1)
        self._joy_received = arrival.time
        if reading.problem:
            self.get_logger().warning(f"standing still: {reading.problem}", throttle_duration_sec=1.0)
            self._levers, self._held = REST, False
            return
        self._levers = levers_from_axes(reading.values.axes)
        self._held = reading.values.buttons[self._deadman] == 1

    def _on_joint_states(self, message: Any, sent: float) -> None:
        if self._pace.now() - sent > self._state_timeout:
            return  # left over from a stall, ours or the machine's; the watchdog speaks meanwhile
        reading = read_joint_state(topics.JOINTS, message)
        angles, rates = reading.values.position, reading.values.velocity
        problem = reading.problem or controller.implausible(angles, rates, self._core)
        if problem:
            self.get_logger().warning(f"standing still: {problem}", throttle_duration_sec=1.0)
            self._stand_still()
            return
        self._state_received = sent
        dt = self._period.since(reading.stamp_ns)
        inputs = controller.Inputs(angles, rates, *self._operator())
        self._state, output = controller.step(self._state, inputs, self._core, dt)
        self._publish(reading.stamp_ns, angles, rates, output)

    def _operator(self) -> tuple[Levers, bool]:
        """Return the levers, and whether they may move anything."""
        self._read_joy()
        age = self._pace.now() - self._joy_received
        if self._held and age > self._joy_timeout:
            self.get_logger().warning(f"standing still: joystick {age:.2f} s late", throttle_duration_sec=1.0)
            return REST, False
        return self._levers, self._held

    def _publish(self, stamp: int, angles: Triple, rates: Triple, output: controller.Output) -> None:
        links = self._core.links
        self._command.publish(float_array(topics.VALVE_COMMANDS, stamp, output.command, self._plain))
        self._pose.publish(pose_stamped(stamp, FRAME, tip_position(angles, links)))
        self._twist.publish(twist_stamped(stamp, FRAME, tip_velocity(angles, rates, links)))
        if self._core.scheme != Scheme.JOINT:
            self._wish.publish(twist_stamped(stamp, FRAME, output.tip_wish))

    def _watch(self) -> None:
        if self._pace.now() - self._state_received > self._state_timeout and self._period.started:
            self.get_logger().warning("standing still: no state of the machine", throttle_duration_sec=1.0)
            self._stand_still()

    def _stand_still(self) -> None:
        self._state = controller.REST
        now = self._pace.stamp()
        self._command.publish(float_array(topics.VALVE_COMMANDS, now, ZERO, self._plain))

    def stop(self) -> None:
        """Last words: zero."""
        self._stand_still()


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(ControllerNode))


if __name__ == "__main__":
    main()
