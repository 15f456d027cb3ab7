"""Taught work as a node: the tip's pose, the sticks and the controller's state in, taught commands out.

It steps when the controller says where the tip is. Whether a command moves the crane, the controller decides:
a person holds the deadman on /joy. Services: `~/record`, `~/pose`, `~/close`, `~/open`, `~/stop`, `~/play`,
`~/pause`, `~/resume` (std_srvs/Trigger), about the cycle that the parameter `cycle` names.
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node

from forest_control.config.cycle_parameters import CycleParameters, TaughtNames
from forest_control.config.settings import Settings, parameters
from forest_control.config.workspace_file import load_workspace
from forest_control.operator.levers import RIGHT_Y
from forest_control.operator.taught_command import NO_COMMAND, to_values
from forest_control.taught.taught_work import Seen, TaughtWork
from forest_description.machine import load_machine
from forest_msgs_py.clock.node_clock import LiveClock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import publisher, run_node, subscription
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.runtime.services import offer_triggers
from forest_msgs_py.serialization.unpacking import ArrayReader, read_joy_data
from forest_msgs_py.types import NS_PER_S

STATUS_TIMEOUT = 0.1  # [s] at which the controller counts as not armed: as its state_timeout
STATUS_PERIOD = 0.1  # [s] between two messages on cycle/status


class CycleNode(Node):
    """Shell around `TaughtWork`."""

    def __init__(self) -> None:
        super().__init__("cycle")
        machine, self._p = (
            load_machine(declare(self, MachineParameter).machine),
            declare(self, CycleParameters),
        )
        declare(self, TaughtNames)
        walled = parameters(machine, Settings(), load_workspace(self._p.workspace))
        self._work = TaughtWork(Path(self._p.directory), walled)
        offer_triggers(self, {name: partial(self._act, act) for name, act in self._work.actions.items()})
        clock = LiveClock(self)
        self._stamp = clock.stamp
        self._command = number_publisher(clock, topics.TAUGHT_COMMAND)
        self._status = number_publisher(clock, topics.CYCLE_STATUS)
        self._events = publisher(self, topics.EVENTS)
        self._joy, self._sticks, self._down = clock.polled_subscription(topics.JOY), (0.0,), True
        self._controller = clock.polled_subscription(topics.CONTROLLER_STATUS)
        self._armed, self._told = ArrayReader(topics.CONTROLLER_STATUS, ("armed",)), (False, 0.0)
        self._last = time.monotonic()
        subscription(self, topics.TIP_POSE, self._on_tip)
        clock.every(STATUS_PERIOD, lambda: self._status.publish(clock.stamp(), self._work.status()))

    def _act(self, act: Callable[[], tuple[bool, str]]) -> tuple[bool, str]:
        """Do what a service asks for, about the cycle that the parameters name."""
        work = self._work
        work.cycle, work.label = (str(self.get_parameter(name).value) for name in TaughtNames._fields)
        done, said = act()
        self.get_logger().info(said)
        return done, said

    def _on_tip(self, message: Any) -> None:
        now, place = time.monotonic(), message.pose.position
        dt, self._last = now - self._last, now
        pressed = self._read_joystick()
        stamp = self._stamp()
        tip = place.x, place.y, place.z
        seen = Seen(tip, stamp / NS_PER_S, self._is_armed(now), self._is_centred(), pressed)
        output = self._work.advance(seen, dt)
        if output.command is not None:
            self._command.publish(stamp, to_values(self._work.run, output.command))
        if output.event:
            self._events.publish(message_class(topics.EVENTS)(data=output.event))

    def _read_joystick(self) -> bool:
        """Take in where the sticks are; tell whether the button was pressed."""
        pressed = False
        for data, _ in self._joy.arrivals():
            reading, _ = read_joy_data(data, RIGHT_Y + 1, self._p.button + 1)
            if not reading.problem:
                self._sticks, down = (
                    reading.values.axes[: RIGHT_Y + 1],
                    reading.values.buttons[self._p.button] == 1,
                )
                pressed, self._down = pressed or (down and not self._down), down
        return pressed

    def _is_centred(self) -> bool:
        return max(map(abs, self._sticks)) <= self._p.centre

    def _is_armed(self, now: float) -> bool:
        """Tell whether the controller lets the levers move the crane, by its newest word."""
        if arrival := self._controller.newest():
            reading = self._armed.read(arrival.message, 0)
            self._told = not reading.problem and reading.values == (1.0,), arrival.time
        armed, sent = self._told
        return armed and now - sent <= STATUS_TIMEOUT

    def stop(self) -> None:
        """Last words: no run goes on."""
        self._command.publish(self._stamp(), to_values(self._work.run, NO_COMMAND))


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(CycleNode))


if __name__ == "__main__":
    main()
