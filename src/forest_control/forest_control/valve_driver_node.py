"""The valve driver as a node: /valve_commands of ideal valves in, /valve_voltages of the real ones out.

It steps when a command arrives. When none arrives, or a bad one, or after an emergency stop, the voltage
is zero, whatever the controller does.
"""

import sys
from typing import Any

from rclpy.node import Node

from forest_control import compiled
from forest_control.valve import valve_driver
from forest_control.valve.command_gate import Command, CommandGate, Verdict
from forest_control.valve.valve_driver_configuration import DriverConfiguration
from forest_control.valve.valve_driver_topics import Commands, Measurements, Outputs, of_pressures
from forest_description.types import ZERO
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime import stamped_period
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.safety.single_talker import SingleTalker
from forest_msgs_py.types import WATCHDOG_PERIOD

PARTS = ("commands", "pressures", "emergency stop")  # on /diagnostics


class ValveDriverNode(Node):
    """Shell around `CommandGate` and `valve_driver.step`."""

    def __init__(self) -> None:
        super().__init__("valve_driver")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        self._configuration = known = DriverConfiguration(self)
        p, machine = known.node, known.machine
        self._gate, self._nominal = CommandGate(p.command_timeout, self._node_clock.now), p.period
        self._period = stamped_period.BEGIN
        self._state, self._step, self._shadow = valve_driver.REST, compiled.driver_step(), p.shadow
        said, stopped = map(self._node_clock.publisher, (topics.DIAGNOSTICS, topics.EMERGENCY_STOPPED))
        self._diagnostics = Diagnostics(self, PARTS, "valves centred", said, "pressures")
        self._stop = EmergencyStop(self, "~/", self._gate.against_reset, self._stand_still, stopped)
        self._out = Outputs(self._node_clock, p.shadow, p.plain_arrays)
        self._commands = Commands(self._node_clock, machine)
        commands = self._node_clock.on(topics.VALVE_COMMANDS, self._on_command)
        self._alone = SingleTalker(self, topics.VALVE_COMMANDS, commands, self._stop)
        self._measured = Measurements(self._node_clock, p.pressure_timeout, known.core.idle_pressure)
        self._watch_inputs(commands)
        self._node_clock.every(WATCHDOG_PERIOD, self._on_watchdog)

    def _watch_inputs(self, commands: Any) -> None:
        """Have /diagnostics tell of the driver's inputs."""
        heard = InputStatus(self, self._node_clock, commands, "commands")
        self._diagnostics.watch("commands", heard, values=self._command_values)
        self._measured.watch(
            self, self._diagnostics, lambda: not self._gate.is_lost(), self._configuration.pressure_settings
        )
        self._diagnostics.watch("emergency stop", self._stop)

    def _command_values(self) -> dict[str, Any]:
        clipping = self._commands.clipping.values()
        return {"command_timeout [s]": self._gate.timeout, **clipping, "shadow": self._shadow}

    def _on_command(self, data: bytes, sent: float) -> None:
        command = self._commands.read(data, sent)
        verdict = self._gate.decide(command, self._stop.pressed)
        if verdict == Verdict.SKIP:
            return
        self._diagnostics.note("commands", self._gate.problem)
        if not self._gate.problem:
            self._diagnostics.warn("commands", self._commands.clipping.caution(command.values))
        if verdict == Verdict.CENTRE:
            self._stand_still()
        elif verdict == Verdict.STEP:
            self._advance(command)

    def _advance(self, command: Command) -> None:
        core = self._configuration.core
        problem = self._measured.read(core.adapt)
        moved = self._measured.machine_time(command.stamp)
        self._period, dt = stamped_period.time_in_force(self._period, moved, self._nominal)
        pressures, motion = self._measured.pressures(), self._measured.motion()
        self._state, voltages = self._step(self._state, command.values, pressures, motion, core, dt)
        self._diagnostics.note("pressures", of_pressures(problem, pressures, self._state))
        self._out.say(command.stamp, voltages)
        self._out.report(command.stamp, self._state, core)
        self._tell(command.stamp)

    def _stand_still(self) -> None:
        self._state, stamp = valve_driver.at_rest(self._state), self._node_clock.stamp()
        self._out.say(stamp, ZERO)
        self._measured.read(learning=False)  # or pressures that come would be missed meanwhile
        self._tell(stamp)

    def _tell(self, stamp: int) -> None:
        self._diagnostics.note("emergency stop", self._alone.trouble())
        self._diagnostics.publish(stamp)

    def _on_watchdog(self) -> None:
        """Centre the valves while no command comes; before the first one too: a machine sees who is there."""
        if self._gate.is_lost():
            if self._period.started:
                self._diagnostics.note("commands", "no command")
            self._stand_still()

    def stop(self) -> None:
        """Last words: zero."""
        self._out.say(self._node_clock.stamp(), ZERO)


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(ValveDriverNode))


if __name__ == "__main__":
    main()
