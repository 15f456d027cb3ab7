"""The scripted operator as a node: an experiment's voltages on /valve_commands, on the simulator or on iron.

It steps when the machine's state arrives, of a test rig when its pressures do. Live, it takes the valves over
before it begins, and gives them back at the end. It stops at zero when a reading is beyond its bounds, when
no good state arrives in time, and at an emergency stop. When it dies, the driver's timeout closes the valves.
"""

import sys
from typing import Any

from rclpy.node import Node

from forest_description.machine import load_machine
from forest_description.types import ZERO, Vec3
from forest_ident.driving.operator_inputs import Inputs
from forest_ident.driving.operator_parameters import OperatorParameters, planned
from forest_ident.driving.scripted_operator import ScriptedOperator
from forest_ident.driving.valve_takeover import ValveTakeover
from forest_msgs_py.clock.node_clock import node_clock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.live_graph import LiveGraph
from forest_msgs_py.runtime.node import Finished, NodeFailure, run_node, subscription
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.runtime.publishers import publishers_of
from forest_msgs_py.types import WATCHDOG_PERIOD


class ExperimentOperatorNode(Node):
    """Shell around `ScriptedOperator`."""

    def __init__(self) -> None:
        super().__init__("experiment_operator")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        machine, p = load_machine(declare(self, MachineParameter).machine), declare(self, OperatorParameters)
        plan, self._timeout, self._listeners = planned(machine, p), p.timeout, p.listeners
        self._operator = ScriptedOperator(plan, self._timeout, self._node_clock.now())
        self._command = number_publisher(self._node_clock, topics.VALVE_COMMANDS)
        self._inputs = Inputs(self._node_clock, plan, self._on_sample)
        self._node_clock.every(WATCHDOG_PERIOD, self._watch)
        self._takeover: ValveTakeover | None = None
        if not self._node_clock.lockstep:
            for topic in (topics.EMERGENCY_STOP, topics.EMERGENCY_STOPPED):
                subscription(self, topic, self._on_emergency_stop)
            self._takeover = ValveTakeover(LiveGraph(self.get_namespace(), "_operator_switches"))
            self._takeover.apply()

    def _on_emergency_stop(self, message: Any) -> None:
        if message.data:
            raise NodeFailure("emergency stop pressed; reset it before the next experiment")

    def _on_sample(self, stamp: int, sent: float, problem: str, angles: Vec3) -> None:
        if self._node_clock.now() - sent > self._timeout:
            return  # left over from a stall; the watchdog ends the experiment if nothing newer comes
        if not self._operator.accepts(stamp, sent, problem):
            self._command.publish(self._node_clock.stamp(), ZERO)
        elif not self._operator.begun and not self._begin(angles):
            self._command.publish(stamp, ZERO)
        else:
            volts, reason = self._operator.step(self._inputs.read(angles), self._inputs.crane_angles())
            _fail_if(reason)
            self._command.publish(stamp, volts)
            self._report_progress()

    def _begin(self, angles: Vec3) -> bool:
        """Begin when all nodes are there; live, the swing goes to and fro about where it stands."""
        if self._takeover is None:
            self._operator.begin()
        elif self._is_alone() and self.count_subscribers(topics.VALVE_COMMANDS.name) >= self._listeners:
            self._operator.begin_around(angles[0])
        return self._operator.begun

    def _is_alone(self) -> bool:
        if self._takeover is None:
            return True
        found = publishers_of(self, topics.VALVE_COMMANDS)
        return self._takeover.is_alone(self.get_name(), found, self._operator.begun)

    def _report_progress(self) -> None:
        """Print how far the experiment is; live, end with it."""
        if line := self._operator.progress():
            print(line, flush=True)
            self._is_alone()
        if self._operator.finished and self._takeover is not None:
            raise Finished

    def _watch(self) -> None:
        """End the experiment when no good state arrives in time."""
        now = self._node_clock.now()
        needed = f"the machine's state, and {self._listeners} who hear valve_commands"
        _fail_if(self._operator.overdue(now, needed))
        if self._operator.begun:
            _fail_if(self._inputs.overdue(now, self._timeout))

    def stop(self) -> None:
        """Publish zero as the last command; then give the valves back."""
        self._command.publish(self._node_clock.stamp(), ZERO)
        if self._takeover is not None:
            self._takeover.close()


def _fail_if(reason: str) -> None:
    if reason:
        raise NodeFailure(reason)


def main() -> None:
    """Run the node until the experiment ends, or it is told to stop."""
    sys.exit(run_node(ExperimentOperatorNode))


if __name__ == "__main__":
    main()
