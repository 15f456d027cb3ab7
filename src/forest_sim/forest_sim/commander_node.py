"""Says /valve_commands from a file, for experiments with the valves: in place of the controller.

Live at 200 Hz, from when somebody listens, and it ends with the file; in lockstep once a step. A valve
driver obeys nobody who has not said zero: live it says so first, in lockstep the file has to.
"""

import sys
from pathlib import Path

import numpy as np
from rclpy.node import Node

from forest_description.types import ZERO
from forest_msgs_py.clock.node_clock import node_clock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import Finished, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import ParameterError
from forest_sim.live.simulator_parameters import CommanderParameters
from forest_sim.simulation.voltage_profiles import InputError, read_voltages


class CommanderNode(Node):
    """Shell around `voltage_profiles`."""

    def __init__(self) -> None:
        super().__init__("commander")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        path = declare(self, CommanderParameters).input
        if not path:
            raise ParameterError("parameter 'input' is ''; allowed: a CSV file of voltages")
        try:
            self._input = read_voltages(Path(path))
        except InputError as error:
            raise ParameterError(f"parameter 'input': {error}") from error
        self._command = number_publisher(self._node_clock, topics.VALVE_COMMANDS)
        self._begun: float | None = None
        self._node_clock.every(1.0 / topics.SENSOR_RATE_HZ, self._on_timer)

    def _on_timer(self) -> None:
        if self._begun is None:
            if not self._node_clock.lockstep:
                if not self._is_heard():
                    return
                self._command.publish(self._node_clock.stamp(), ZERO)
            self._begun = self._node_clock.now()
        elapsed = self._node_clock.now() - self._begun
        if elapsed > self._input.duration and not self._node_clock.lockstep:
            raise Finished
        self._command.publish(self._node_clock.stamp(), self._input.at(np.array([elapsed]))[0].tolist())

    def _is_heard(self) -> bool:
        name = self.resolve_topic_name(topics.VALVE_COMMANDS.name)
        return any(made.topic_name == name and made.get_subscription_count() for made in self.publishers)

    def stop(self) -> None:
        """Last words: zero."""
        self._command.publish(self._node_clock.stamp(), ZERO)


def main() -> None:
    """Run the node until the file ends, or it is told to stop."""
    sys.exit(run_node(CommanderNode))


if __name__ == "__main__":
    main()
