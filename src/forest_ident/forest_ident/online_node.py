"""On-line identification as a node: running estimates of overlap, gain and damping beside the off-line fit.

It never publishes to the machine. It steps when the joints' state arrives, with the pressures and
voltages that arrived last, and publishes its estimates every second.
"""

import math
import sys

from rclpy.node import Node

from forest_description.machine import load_machine
from forest_description.types import Vec3
from forest_ident.online import online_estimator
from forest_ident.online.online_parameters import OnlineParameters
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.clock.sampled_topics import SampledTopics, Wanted
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JointValues, float_array
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter

PORTS = tuple(f"{joint}_{port}_actuator" for port in (1, 2) for joint in topics.JOINTS)
UNKNOWN = (math.nan, math.nan, math.nan)  # rates of a joint state without them


class OnlineIdentificationNode(Node):
    """Shell around `online_estimator.step`."""

    def __init__(self) -> None:
        super().__init__("online_identification")
        clock = node_clock(self)
        self.run = clock.run
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, OnlineParameters)
        self._core = online_estimator.parameters(machine, p.memory)
        self._state = online_estimator.initial(self._core)
        self._estimates = clock.publisher(topics.IDENTIFICATION)
        self._topics = SampledTopics(
            clock,
            {
                topics.PRESSURES: Wanted(PORTS, p.timeout),
                topics.SUPPLY: Wanted(("pressure",), p.timeout),
                topics.VALVE_VOLTAGES: Wanted(topics.VALVE_VOLTAGES.labels, p.timeout),
            },
            step=self._step,
            period=p.period,
            report=self._publish,
            report_period=p.report_period,
        )

    def _step(self, joints: JointValues, dt: float) -> None:
        pressures = self._topics.newest(topics.PRESSURES)
        sample = online_estimator.Sample(
            angles=_triple(joints.position),
            rates=_triple(joints.velocity or UNKNOWN),
            pressures_1=_triple(pressures[:3]),
            pressures_2=_triple(pressures[3:]),
            supply=self._topics.newest(topics.SUPPLY)[0],
            voltages=_triple(self._topics.newest(topics.VALVE_VOLTAGES)),
        )
        self._state = online_estimator.step(self._state, sample, self._core, dt)

    def _publish(self, stamp: int) -> None:
        values = zip(online_estimator.LABELS, online_estimator.report(self._state), strict=True)
        there = {label: value for label, value in values if math.isfinite(value)}
        message = float_array(topics.IDENTIFICATION, stamp, list(there.values()), labels=tuple(there))
        self._estimates.publish(message)


def _triple(values: tuple[float, ...]) -> Vec3:
    swing, boom, stick = values
    return swing, boom, stick


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(OnlineIdentificationNode))


if __name__ == "__main__":
    main()
