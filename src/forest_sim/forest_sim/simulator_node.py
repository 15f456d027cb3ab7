"""The machine as a node: takes /valve_voltages, keeps the graph's time, publishes what its sensors report.

Physics at 1 kHz inside, topics at 200 Hz, in a thread that sleeps from deadline to deadline: an
executor would spend more on waking up than the machine costs. Deadlines stand on the monotonic
clock; a late wake-up is caught up with correctly stamped samples, and counted. Voltages older than
the machine's command timeout count as zero.

Sensors are exact unless `sensor_noise` is set; `sensor_faults` hold either way. A sensor that is
absent, or drops its sample, is missing from its message; a message of which nothing is left is not
sent. `stuck_spools` and `tip_force` may be set while the node runs. Live, `~/grasp` and `~/drop` take
a log into the head and let it go.
"""

import sys
import threading
import time
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node

from forest_description.derived.limits import start_tip
from forest_description.machine import load_machine
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.runtime.services import offer_triggers
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_sim.live.deadlines import Deadlines
from forest_sim.live.grapple import Grapple
from forest_sim.live.simulator_parameters import SimulatorParameters, simulated_machine
from forest_sim.live.simulator_topics import SimulatorInputs, SimulatorOutputs, parts
from forest_sim.simulation.disturbance import parse_disturbance
from forest_sim.simulation.sensor_log import further_topics, topic_values


class SimulatorNode(Node):
    """Shell around `SimulatedMachine`."""

    def __init__(self) -> None:
        super().__init__("simulator")
        self._node_clock = node_clock(self, leads=True)
        self.run = self._node_clock.run or self._keep_time
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, SimulatorParameters, initial_tip=start_tip(machine))
        self._machine = simulated_machine(machine, p, PERIOD)
        if not self._machine.is_compiled:
            self.get_logger().info(
                "the plant is interpreted; `python -m forest_sim.compiled` makes it fast, once"
            )
        self._changing = threading.Lock()  # parameters come in the executor's thread
        self.add_on_set_parameters_callback(self._on_parameters)
        further = further_topics(machine, bool(p.loads) or not self._node_clock.lockstep)
        self._tells_load = topics.GROUND_TRUTH_LOAD in further
        self._outputs = SimulatorOutputs(self._node_clock, p.plain_arrays, further)
        publisher = self._node_clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(self, parts(self._node_clock), "valves centred", publisher)
        self._outputs.say_description(machine)
        self._inputs = SimulatorInputs(self._node_clock, machine, self._diagnostics)
        self._inputs.watch(self)
        self._diagnostics.watch("machine", values=self._machine_values)
        self._stamp = self._node_clock.stamp()
        self._deadlines = Deadlines(time.monotonic_ns(), PERIOD_NS)
        if self._node_clock.lockstep:
            self._node_clock.every(0.0, self._make_step)
        else:  # a service knows no step
            offer_triggers(self, Grapple(self._machine, self._changing, self.get_parameter).actions)

    def _on_parameters(self, changed: list[Any]) -> SetParametersResult:
        values = {name: self.get_parameter(name).value for name in ("stuck_spools", "tip_force")}
        values.update((parameter.name, parameter.value) for parameter in changed if parameter.name in values)
        try:
            disturbance = parse_disturbance(**values)
            with self._changing:
                self._machine.disturb(disturbance)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=f"parameter {error}")
        return SetParametersResult(successful=True)

    def _machine_values(self) -> dict[str, Any]:
        counts = self._machine.events._asdict() | {"missed_deadlines": self._deadlines.missed}
        named = {f"{what.replace('_', ' ')} since start": count for what, count in counts.items()}
        load = {"load [kg]": self._machine.load.mass} if self._tells_load else {}
        return {"machine": self._machine.machine.name} | load | named

    def _keep_time(self, stopping: threading.Event) -> None:
        """Keep the time, live, until the node stops."""
        while not stopping.is_set():
            time.sleep(self._deadlines.wait(time.monotonic_ns()))
            periods, left_out = self._deadlines.due(time.monotonic_ns())
            self._stamp += left_out * PERIOD_NS
            for _ in range(periods):
                self._stamp += PERIOD_NS
                self._advance()

    def _make_step(self) -> None:
        """Move on by a period in lockstep: there are no deadlines to be missed."""
        self._stamp = self._node_clock.stamp()
        self._advance()

    def _advance(self) -> None:
        voltages = self._inputs.voltages()
        with self._changing:
            report = self._machine.step(voltages)
        values = topic_values(report, self._machine.events, self._deadlines.missed)
        self._outputs.say(self._stamp, values, self._machine)
        self._diagnostics.publish(self._stamp)  # last: nobody waits for it


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(SimulatorNode))


if __name__ == "__main__":
    main()
