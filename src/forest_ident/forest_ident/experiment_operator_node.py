"""The scripted operator as a node: an experiment's voltages on /valve_commands, on the simulator or on iron.

It steps when the machine's state arrives, of a test rig when its pressures do. Live, it has the driver's
compensation switched off and the controller's hands taken off before it begins, and puts both back when it
ends. It stops altogether, at zero, when something is not as it must be (`operator_watch`), when nothing good
has arrived for a while, and at an emergency stop. When the node itself dies, the driver's timeout shuts the
valves.
"""

import math
import sys
from typing import Any

from rclpy.node import Node

from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO, Vec3
from forest_ident.driving import safety_monitor
from forest_ident.driving.operator_inputs import Inputs
from forest_ident.driving.operator_parameters import OperatorParameters
from forest_ident.driving.valve_takeover import CONTROLLER, Switches
from forest_ident.experiments import excitation, experiments
from forest_msgs_py.clock.node_clock import pace, speaker
from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.live_graph import UNKNOWN, LiveGraph, NoAnswer, speakers
from forest_msgs_py.runtime.node import Finished, NodeFailure, run_node, subscription
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter, ParameterError
from forest_msgs_py.runtime.stamp_order import StampOrder
from forest_msgs_py.runtime.stamped_period import StampedPeriod
from forest_msgs_py.serialization.unpacking import JointReader
from forest_msgs_py.types import PERIOD, WATCHDOG_PERIOD

START_LIMIT = 15.0  # [s] for everybody to be there
STANDS = 0.02  # [rad] by which a joint of the crane may move while its valve is on a rig
PROGRESS = "operator at"  # begins a line on standard output for each second: of so many


class ExperimentOperatorNode(Node):
    """Shell around `excitation.step` and `operator_watch.step`."""

    def __init__(self) -> None:
        super().__init__("experiment_operator")
        self._pace = pace(self)
        self.run = self._pace.run
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, OperatorParameters)
        self._plan, self._timeout, self._listeners = _planned(machine, p), p.timeout, p.listeners
        self._programme = self._plan.programme
        self._bounds = safety_monitor.bounds(self._plan, self._programme)
        self._state, self._watched = excitation.START, safety_monitor.State()
        self._period, self._order = StampedPeriod(PERIOD), StampOrder(self._timeout)
        self._begun, self._told = False, -1
        self._created = self._received = self._pace.now()
        self._command = speaker(self._pace, topics.VALVE_COMMANDS)
        self._inputs, self._joints = Inputs(self._pace, self._plan), JointReader(topics.JOINTS)
        self._crane: Any = None
        self._stood: tuple[float, ...] = ()
        if self._plan.bench:
            self._crane = None if self._pace.lockstep else self._pace.inbox(topics.JOINT_STATES)
            self._pace.on(topics.PRESSURES, self._on_pressures)
        else:
            self._pace.on(topics.JOINT_STATES, self._on_joints)
        self._pace.every(WATCHDOG_PERIOD, self._watch)
        self._graph: LiveGraph | None = None
        if not self._pace.lockstep:
            for topic in (topics.EMERGENCY_STOP, topics.EMERGENCY_STOPPED):
                subscription(self, topic, self._on_emergency_stop)
            self._take_over()

    def _take_over(self) -> None:
        """Have what is commanded here, and nothing else, reach the valves.

        Raises:
            NodeFailure: that cannot be had; what was switched is switched back.
        """
        self._graph = LiveGraph(self.get_namespace(), "_operator_switches")
        try:
            self._switches = Switches(self._graph)
        except NoAnswer as error:
            raise NodeFailure(str(error)) from error
        try:
            self._switches.throw()
        except NoAnswer as error:
            self._switches.restore()
            raise NodeFailure(str(error)) from error

    def _is_alone(self) -> bool:
        """Whether nobody else commands the valves; a controller that was found late gets its hands off.

        Raises:
            NodeFailure: somebody does, who cannot be told to stop.
        """
        quiet = (self.get_name(), *self._switches.found)
        others = [name for name in speakers(self, topics.VALVE_COMMANDS) if name not in quiet]
        if others == [CONTROLLER] and not self._begun:
            self._switches.include(CONTROLLER)
            self._switches.throw()
        elif others and (self._begun or UNKNOWN not in others):
            raise NodeFailure(f"{others[0]} publishes valve_commands, too; stop it first")
        return not others

    def _on_emergency_stop(self, message: Any) -> None:
        if message.data:
            raise NodeFailure("emergency stop pressed; reset it before the next experiment")

    def _on_joints(self, data: bytes, sent: float) -> None:
        reading = self._joints.read(data)
        self._on_sample(reading.stamp_ns, sent, reading.problem, reading.values.position)

    def _on_pressures(self, data: bytes, sent: float) -> None:
        stamp, problem = self._inputs.pressures(data, sent)
        self._on_sample(stamp, sent, problem, ZERO)

    def _on_sample(self, stamp: int, sent: float, problem: str, angles: Vec3) -> None:
        if self._pace.now() - sent > self._timeout:
            return  # left over from a stall; the watchdog ends the experiment if nothing newer comes
        problem = problem or self._order.problem("the machine's state", stamp, sent)
        if problem:
            self._command.say(self._pace.stamp(), ZERO)
            return
        self._received, dt = sent, self._period.since(stamp)
        if not self._begun and not self._begin(angles):
            self._command.say(stamp, ZERO)
            return
        self._see_that_the_crane_stands()
        seen = self._inputs.read(angles)
        self._watched, reason = safety_monitor.step(self._watched, seen, self._bounds, dt)
        if reason:
            raise NodeFailure(reason)
        self._state, volts = excitation.step(self._state, angles, self._programme, dt)
        self._command.say(stamp, volts)
        self._tell()

    def _see_that_the_crane_stands(self) -> None:
        """On a rig the crane's joints, where they are told, must not move.

        Raises:
            NodeFailure: one does: what is driven is still on the crane, without bounds.
        """
        arrival = self._crane.newest() if self._crane is not None else None
        if arrival is None or (reading := self._joints.read(arrival.message)).problem:
            return
        angles = reading.values.position
        self._stood = self._stood or angles
        for name, angle, stood in zip(topics.JOINTS, angles, self._stood, strict=True):
            if abs(angle - stood) > STANDS:
                raise NodeFailure(f"the {name} moves: valve or hose are still on the crane, not on the rig")

    def _begin(self, angles: Vec3) -> bool:
        """Begin when everybody is there; live, the swing goes about where it stands."""
        if self._pace.lockstep:
            self._begun = True
        elif self._is_alone() and self.count_subscribers(topics.VALVE_COMMANDS.name) >= self._listeners:
            self._programme = safety_monitor.around(self._programme, self._plan, angles[0])
            self._bounds = safety_monitor.bounds(self._plan, self._programme)
            self._begun = True
        return self._begun

    def _tell(self) -> None:
        """Say on standard output how far the experiment is; live, end with it."""
        second, whole = int(self._state.time), self._programme.duration
        if second > self._told:
            self._told = second
            print(f"{PROGRESS} {second} of {whole:g} s", flush=True)
            if not self._pace.lockstep:
                self._is_alone()
        if self._state.time > whole - 1e-9 and not self._pace.lockstep:
            raise Finished

    def _watch(self) -> None:
        """End the experiment when nothing good arrives any more."""
        now = self._pace.now()
        if not self._begun:
            if now - self._created > START_LIMIT:
                needed = f"the machine's state, and {self._listeners} who hear valve_commands"
                raise NodeFailure(f"not everything was there within {START_LIMIT:g} s: {needed}")
            return
        if now - self._received > self._timeout:
            raise NodeFailure(f"nothing good of the machine's state for {self._timeout:g} s")
        if missing := self._inputs.missing(now, self._timeout):
            raise NodeFailure(f"nothing good on {missing.name} for {self._timeout:g} s")

    def stop(self) -> None:
        """Last words: zero; then the others are as they were."""
        self._command.say(self._pace.stamp(), ZERO)
        if self._graph is None:
            return
        failed = self._switches.restore()
        self._graph.close()
        if failed:
            raise NodeFailure(failed)


def _planned(machine: Machine, p: OperatorParameters) -> experiments.Plan:
    allowed = [known for known in experiments.names(machine) if known != "calibration"]
    if p.experiment not in allowed:
        raise ParameterError(f"parameter 'experiment' is {p.experiment!r}; allowed: {', '.join(allowed)}")
    return experiments.plan(p.experiment, machine, p.seed, p.longest or math.inf)


def main() -> None:
    """Run the node until the experiment ends, or it is told to stop."""
    sys.exit(run_node(ExperimentOperatorNode))


if __name__ == "__main__":
    main()
