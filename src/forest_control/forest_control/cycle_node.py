"""Taught work as a node: the tip's pose, the sticks and the controller's state in, taught commands out.

It steps when the controller says where the tip is. Whether a command moves the crane, the controller decides:
a person holds the deadman on /joy. Services: `~/record`, `~/pose`, `~/close`, `~/open`, `~/stop`, `~/play`,
`~/pause`, `~/resume` (std_srvs/Trigger), about the cycle that the parameter `cycle` names. A program's
`joint_trajectory` is played likewise; so is a goal of `~/follow_joint_trajectory`, where control_msgs is.
"""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node

from forest_control.config.controller_settings import Parameters, Settings, parameters
from forest_control.config.cycle_parameters import CycleParameters, TaughtNames
from forest_control.config.workspace_file import load_workspace
from forest_control.operator.taught_command import NO_COMMAND, to_values
from forest_control.taught.cycle_topics import CycleInputs, Report
from forest_control.taught.taught_work import TaughtWork
from forest_control.taught.trajectory_goals import TrajectoryGoals
from forest_description.machine import load_machine
from forest_msgs_py.clock.node_clock import LiveClock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import run_node, subscription
from forest_msgs_py.runtime.node_parameters import Tunables, declare
from forest_msgs_py.runtime.parameter_table import MachineParameter, table_of
from forest_msgs_py.runtime.services import offer_action, offer_triggers
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.serialization.unpacking import read_position

STATUS_PERIOD = 0.1  # [s] between two messages on cycle/status
RESTING_PERIOD = 0.02  # [s] between two looks at tip and button while nothing is played or taught; chosen
PART = "taught work"  # on /diagnostics


class CycleNode(Node):
    """Shell around `TaughtWork`."""

    def __init__(self) -> None:
        super().__init__("cycle")
        self._machine = load_machine(declare(self, MachineParameter).machine)
        p, names = declare(self, CycleParameters), Tunables(self)
        self._names = names.declare(TaughtNames)
        self._work = TaughtWork(Path(p.directory), self._walled(self._names))
        self._name(names.values)
        names.watch(self._name)
        offer_triggers(self, {name: partial(self._act, act) for name, act in self._work.actions.items()})
        self._node_clock = clock = LiveClock(self)
        self._command = number_publisher(clock, topics.TAUGHT_COMMAND)
        self._status = number_publisher(clock, topics.CYCLE_STATUS)
        self._events = clock.publisher(topics.EVENTS)
        self._diagnostics = Diagnostics(self, (PART,), "the tip is held", clock.publisher(topics.DIAGNOSTICS))
        self._report = Report(self._work)
        self._diagnostics.watch(PART, self._report)
        self._inputs = CycleInputs(clock, p.centre, p.button)
        self._last = clock.now()
        clock.on(topics.TIP_POSE, self._on_tip)
        self._goals = TrajectoryGoals(self._work, self.get_logger(), self._event)
        subscription(self, topics.JOINT_TRAJECTORY, self._goals.hear)
        offer_action(self, "control_msgs", "FollowJointTrajectory", "follow_joint_trajectory", self._goals)
        clock.every(STATUS_PERIOD, self._tell)

    def _name(self, values: dict[str, Any]) -> None:
        """Take what the parameters say that the services are about."""
        names = table_of(TaughtNames, values)
        if names.workspace != self._names.workspace:
            self._work.p = self._walled(names)
        self._work.cycle, self._work.label, self._names = names.cycle, names.label, names

    def _walled(self, names: TaughtNames) -> Parameters:
        return parameters(self._machine, Settings(), load_workspace(names.workspace))

    def _act(self, act: Callable[[], tuple[bool, str]]) -> tuple[bool, str]:
        """Do what a service asks for, about the cycle that the parameters name."""
        done, said = act()
        self.get_logger().info(said)
        return done, said

    def _on_tip(self, data: bytes, _sent: float) -> None:
        now, tip = self._node_clock.now(), read_position(data)
        dt = now - self._last
        if tip is None or (self._work.rests and dt < RESTING_PERIOD):
            return
        stamp, self._last = self._node_clock.stamp(), now
        output = self._work.advance(self._inputs.seen(tip, stamp), dt)
        if output.command is not None:
            self._command.publish(stamp, to_values(self._work.run, output.command))
        self._goals.watch(tip)
        if output.event:
            self._event(output.event)

    def _event(self, said: str) -> None:
        self._events.publish(message_class(topics.EVENTS)(data=said))

    def _tell(self) -> None:
        stamp = self._node_clock.stamp()
        self._status.publish(stamp, self._work.status())
        self._goals.tell(stamp)
        if self._report.has_changed():
            self._diagnostics.news()
        self._diagnostics.publish(stamp)

    def stop(self) -> None:
        """Last words: no run goes on."""
        self._command.publish(self._node_clock.stamp(), to_values(self._work.run, NO_COMMAND))


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(CycleNode))


if __name__ == "__main__":
    main()
