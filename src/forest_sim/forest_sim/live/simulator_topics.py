"""The simulator's input from a topic, and its outputs to topics: conversions only, which decide nothing."""

from typing import Any

from forest_description.machine import Machine
from forest_description.types import ZERO, Vec3
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.clock.node_clock import number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.safety.clipping import Clipping
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.safety.single_talker import SingleTalker
from forest_msgs_py.serialization.unpacking import ArrayReader
from forest_sim.live.voltage_command import VoltageInput
from forest_sim.simulation.sensor_log import SIMULATED_TOPICS, FurtherTopics, TopicValues
from forest_sim.simulation.simulated_machine import SimulatedMachine

PART, STOP = "voltages", "emergency stop"  # on /diagnostics
FRAME = "base_link"
FRAMED = (topics.POSE, topics.TWIST)  # types


def parts(clock: Any) -> tuple[str, ...]:
    """Return what of the simulator can fail: in lockstep nobody stops it, all comes from one graph."""
    return (PART, "machine") if clock.lockstep else (PART, STOP, "machine")


class SimulatorInputs:
    """The voltages of the valves.

    Args:
        clock: of the node, whose subscriptions and clock are used.
        machine: whose valves they are.
        diagnostics: tell what is wrong with them.
    """

    def __init__(self, clock: Any, machine: Machine, diagnostics: Diagnostics) -> None:
        self._node_clock, self._diagnostics = clock, diagnostics
        self._input = VoltageInput(machine.command_timeout)
        ratings = [machine.valve_of(axis).rated_voltage for axis in range(3)]
        self._clipping = Clipping(topics.VALVE_VOLTAGES, ratings)
        self._reader = ArrayReader(topics.VALVE_VOLTAGES)
        self._inbox = clock.polled_subscription(topics.VALVE_VOLTAGES)
        self._stop: EmergencyStop | None = None

    def watch(self, node: Any) -> None:
        """Have /diagnostics tell of the voltages; live, stop where two nodes send them."""
        heard = InputStatus(node, self._node_clock, self._inbox, PART, self._are_missed)
        self._diagnostics.watch(PART, heard, values=self._values)
        if STOP in parts(self._node_clock):
            self._stop = EmergencyStop(node, "~/", lambda: "", lambda: None)
            self._alone = SingleTalker(node, topics.VALVE_VOLTAGES, self._inbox, self._stop)
            self._diagnostics.watch(STOP, self._stop)

    def voltages(self) -> Vec3:
        """Return the voltages to apply [V]: of the newest command, zero after a stop; notes what is wrong."""
        arrival = self._inbox.newest()
        if arrival is not None:
            reading = self._reader.read(arrival.message, 0)
            problem = self._input.take(reading.values, reading.stamp_ns, arrival.time, reading.problem)
            self._diagnostics.note(PART, problem)
            self._diagnostics.warn(PART, self._clipping.caution(ZERO if problem else reading.values))
        if self._are_missed():
            self._diagnostics.warn(PART, "")
        if self._stop is not None:
            self._diagnostics.note(STOP, self._alone.trouble())
            if self._stop.pressed:
                return ZERO
        return self._input.at(self._node_clock.now())

    def _are_missed(self) -> bool:
        return self._input.is_missed(self._node_clock.now())

    def _values(self) -> dict[str, Any]:
        return {"command_timeout [s]": self._input.timeout} | self._clipping.values()


class SimulatorOutputs:
    """What the machine's sensors report, and what it looks like.

    Args:
        clock: of the node, whose publishers are used.
        plain: arrays carry no stamp.
        further: topics that not every machine has, and what they tell.
    """

    def __init__(self, clock: Any, plain: bool, further: FurtherTopics) -> None:
        self._further = further
        self._publishers = {
            topic: number_publisher(clock, topic, FRAME if topic.type in FRAMED else "", plain)
            for topic in (*SIMULATED_TOPICS, *further)
        }
        self._description = clock.publisher(topics.ROBOT_DESCRIPTION)

    def say_description(self, machine: Machine) -> None:
        """Say what the crane looks like (URDF), for those who come later, too."""
        text = robot_description(machine)
        self._description.publish(message_class(topics.ROBOT_DESCRIPTION)(data=text))

    def say(self, stamp: int, values: TopicValues, machine: SimulatedMachine) -> None:
        """Publish the numbers of every topic, and those of the further ones, under a stamp [ns]."""
        values |= {topic: told(machine) for topic, told in self._further.items()}
        for topic, numbers in values.items():
            self._publishers[topic].publish(stamp, numbers)
