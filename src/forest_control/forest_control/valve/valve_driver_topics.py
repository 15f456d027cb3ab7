"""The valve driver's measurements from topics, and its status."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from forest_control.valve import valve_adaptation as adaptation
from forest_control.valve.command_gate import Command
from forest_control.valve.load_estimate import STILL, UNSEEN, Motion, Pressures
from forest_control.valve.tracking_limit import STATUS_EVERY
from forest_control.valve.valve_driver import State, objection
from forest_control.valve.valve_driver_parameters import Parameters
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_msgs_py.clock.node_clock import number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.safety.clipping import Clipping
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader

LATEST_NS = 100_000_000  # [ns] pressures that are newer than the command by more have another clock


def _labels(place: str, port: int) -> tuple[str, ...]:
    return tuple(f"{joint}_{port}_{place}" for joint in topics.JOINTS)


PORTS, VALVES = [[_labels(place, port) for port in (1, 2)] for place in ("actuator", "valve")]


def of_pressures(problem: str, pressures: Pressures, state: State) -> str:
    """Return what is wrong with the pressures, in words, or "".

    Args:
        problem: why they cannot be read.
        pressures: that were read.
        state: the driver's, after its step with them.
    """
    if shut := objection(state):
        return shut
    if not problem and pressures is not UNSEEN and not state.load.primed:
        problem = "a pressure is out of its range, or both ends of a swing's hose differ; allowed: true ones"
    return problem and f"{problem}; the nominal load is taken"


class Commands:
    """The commands of ideal valves.

    Args:
        clock: of the node.
        machine: whose valves they are.
    """

    def __init__(self, clock: Any, machine: Machine) -> None:
        self._node_clock, self._reader = clock, ArrayReader(topics.VALVE_COMMANDS)
        ratings = [machine.valve_of(axis).rated_voltage for axis in range(3)]
        self.clipping = Clipping(topics.VALVE_COMMANDS, ratings)

    def read(self, data: bytes, sent: float) -> Command:
        """Return what a message commands."""
        reading = self._reader.read(data, self._node_clock.stamp())
        return Command(reading.values, reading.stamp_ns, sent, reading.problem)


class Outputs:
    """The driver's topics.

    Args:
        clock: of the node, whose publishers are used.
        shadow: there are no voltages.
        plain: arrays carry no stamp.
    """

    def __init__(self, clock: Any, shadow: bool, plain: bool) -> None:
        self._voltages = None if shadow else number_publisher(clock, topics.VALVE_VOLTAGES, plain=plain)
        self._status = number_publisher(clock, topics.VALVE_DRIVER_STATUS, plain=plain)
        self._steps = 0

    def say(self, stamp: int, voltages: Vec3) -> None:
        """Publish the voltages [V] under a stamp [ns]."""
        if self._voltages is not None:
            self._voltages.publish(stamp, voltages)

    def report(self, stamp: int, state: State, p: Parameters) -> None:
        """Publish the status of every `STATUS_EVERY` th step."""
        if self._steps % STATUS_EVERY == 0:
            self._status.publish(stamp, status(state, p))
        self._steps += 1


class Measurements:
    """The newest samples; what is older than `timeout` [s], or bad, counts as none.

    Args:
        clock: of the node, whose subscriptions and clock are used.
        timeout: [s].
        idle_pressure: of the supply [Pa], taken where it is not measured.
    """

    def __init__(self, clock: Any, timeout: float, idle_pressure: float) -> None:
        self._node_clock, self.timeout, self._idle = clock, timeout, idle_pressure
        self.boxes = [
            clock.polled_subscription(t) for t in (topics.PRESSURES, topics.SUPPLY, topics.ACTUATOR_STATES)
        ]
        self._port_readers, self._valve_readers = (
            [ArrayReader(topics.PRESSURES, labels) for labels in group] for group in (PORTS, VALVES)
        )
        self._supply_reader = ArrayReader(topics.SUPPLY, ("pressure",))
        self._position_readers = [JointReader((name,)) for name in topics.ACTUATORS]
        self._ports: list[Vec3] = []
        self._valves: list[Vec3] = []
        self._supply, self._positions = 0.0, [math.nan] * len(topics.ACTUATORS)
        self._stamp = 0  # [ns] of the newest pressures
        self._received = dict.fromkeys(("ports", "valves", "supply", *topics.ACTUATORS), -math.inf)

    def watch(
        self,
        node: Any,
        diagnostics: Diagnostics,
        are_wanted: Callable[[], bool],
        settings: Callable[[], dict[str, Any]],
    ) -> None:
        """Have /diagnostics tell of the pressures.

        Args:
            node: whose inputs they are.
            diagnostics: of the node.
            are_wanted: whether pressures are missed when they do not come.
            settings: gives what the driver makes of them, by names.
        """

        def values() -> dict[str, Any]:
            return {"pressure_timeout [s]": self.timeout} | settings()

        heard, (pressures, *others) = partial(InputStatus, node, self._node_clock), self.boxes
        missed = heard(
            pressures,
            "pressures (the nominal load is taken)",
            lambda: are_wanted() and self.are_missing(),
        )
        diagnostics.watch("pressures", missed, *map(heard, others), values=values)

    def read(self, learning: bool) -> str:
        """Read the newest samples, all if learning; return what is wrong with the pressures, or ""."""
        problem = ""
        pressures, supply, actuators = (box.newest() for box in self.boxes)
        if pressures:
            ports, problem, self._stamp = _arrays(pressures.message, self._port_readers)
            if not problem:
                self._ports, self._received["ports"] = ports, pressures.time
            if learning:
                valves, missing, _ = _arrays(pressures.message, self._valve_readers)
                if not missing:
                    self._valves, self._received["valves"] = valves, pressures.time
        if supply:
            reading = self._supply_reader.read(supply.message, 0)
            if not reading.problem and reading.values[0] >= 0.0:
                self._supply, self._received["supply"] = reading.values[0], supply.time
        if actuators and learning:
            for i, name in enumerate(topics.ACTUATORS):
                state = self._position_readers[i].read(actuators.message)
                if not state.problem:
                    self._positions[i], self._received[name] = state.values.position[0], actuators.time
        return problem

    def machine_time(self, stamp_ns: int) -> int:
        """Return how far the machine is [ns] when the command for a state with this stamp is carried out.

        A late command meets a machine that is further than the state it answers: the newest
        pressures tell.
        """
        return self._stamp if 0 < self._stamp - stamp_ns < LATEST_NS else stamp_ns

    def pressures(self) -> Pressures:
        """Return the pressures, or `UNSEEN`: then the driver takes the nominal pressure drop."""
        if self.are_missing():
            return UNSEEN
        return Pressures(
            self._ports[0], self._ports[1], self._supply if self._fresh("supply") else self._idle
        )

    def are_missing(self) -> bool:
        """Tell whether there are no fresh pressures."""
        return not self._fresh("ports")

    def motion(self) -> Motion:
        """Return the measurements for the adaptation; NaN for an actuator whose position is not measured."""
        if not (self._fresh("valves") and self._fresh("supply")):
            return STILL
        swing, boom, stick = (
            x if self._fresh(name) else math.nan
            for name, x in zip(topics.ACTUATORS, self._positions, strict=True)
        )
        return Motion((swing, boom, stick), self._valves[0], self._valves[1])

    def _fresh(self, what: str) -> bool:
        return bool(self._node_clock.now() - self._received[what] <= self.timeout)


def _arrays(data: bytes, readers: list[ArrayReader]) -> tuple[list[Vec3], str, int]:
    """Return the values, what is wrong with them or "", and their stamp [ns]."""
    one, two = [reader.read(data, 0) for reader in readers]
    return [one.values, two.values], one.problem or two.problem, one.stamp_ns


def status(state: State, p: Parameters) -> list[float]:
    """Return the values of `topics.VALVE_DRIVER_STATUS`."""
    values = [float(saturated) for saturated in state.saturated]
    for axis, learner in zip(p.axes, state.estimates, strict=True):
        for edge, way in ((axis.valve.forward, learner.forward), (axis.valve.backward, learner.backward)):
            values += [edge.deadband_voltage + way.deadband, adaptation.deadband_spread(way)]
            values += [adaptation.gain(way), adaptation.gain_spread(way)]
    return values
