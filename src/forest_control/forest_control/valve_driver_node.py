"""The valve driver as a node: /valve_commands of ideal valves in, /valve_voltages of the real ones out.

It steps when a command arrives. When none arrives, or a bad one, or after an emergency stop, the voltage
is zero, whatever the controller does.
"""

import sys
from functools import partial
from typing import Any

from rclpy.node import Node

from forest_control import compiled
from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.command_gate import PRESSED, Command, CommandGate, Verdict
from forest_control.valve.valve_driver_parameters import DriverParameters
from forest_control.valve.valve_driver_topics import Measurements, Outputs
from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO
from forest_msgs_py.clock.node_clock import node_clock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime import stamped_period
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import Tunables, declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.safety.diagnostics import Diagnostics, beyond, rating_values
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.serialization.unpacking import ArrayReader
from forest_msgs_py.types import WATCHDOG_PERIOD


class ValveDriverNode(Node):
    """Shell around `CommandGate` and `valve_driver.step`."""

    def __init__(self) -> None:
        super().__init__("valve_driver")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        machine, self._tunables = load_machine(declare(self, MachineParameter).machine), Tunables(self)
        self._use(machine, self._tunables.declare(valve_driver_parameters.Settings)._asdict())
        self._tunables.watch(partial(self._use, machine))
        p = declare(self, DriverParameters)
        self._gate, self._nominal = CommandGate(p.command_timeout, self._node_clock.now), p.period
        self._period = stamped_period.BEGIN
        self._state, self._step, self._shadow = valve_driver.REST, compiled.driver_step(), p.shadow
        told = self._node_clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(
            self, ("commands", "pressures", "emergency stop"), "valves centred", told
        )
        stopped = self._node_clock.publisher(topics.EMERGENCY_STOPPED)
        self._stop = EmergencyStop(self, "~/", self._gate.against_reset, self._stand_still, stopped)
        published = partial(number_publisher, self._node_clock, plain=p.plain_arrays)
        voltages = None if p.shadow else published(topics.VALVE_VOLTAGES)
        self._out = Outputs(voltages, published(topics.VALVE_DRIVER_STATUS))
        self._commands = ArrayReader(topics.VALVE_COMMANDS)
        commands = self._node_clock.on(topics.VALVE_COMMANDS, self._on_command)
        self._measured = Measurements(self._node_clock, p.pressure_timeout, self._core.idle_pressure)
        self._watch_inputs(commands, machine)
        self._node_clock.every(WATCHDOG_PERIOD, self._on_watchdog)

    def _use(self, machine: Machine, values: dict[str, Any]) -> None:
        self._core = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings(**values))

    def _watch_inputs(self, commands: Any, machine: Machine) -> None:
        """Have /diagnostics tell of the driver's inputs."""
        self._ratings, self._clipped = [machine.valve_of(axis).rated_voltage for axis in range(3)], 0
        heard, (pressures, *others) = partial(InputStatus, self, self._node_clock), self._measured.boxes
        missed = heard(pressures, "pressures (the nominal load is taken)", self._lacks_pressures)
        limits = {"command_timeout [s]": self._gate.timeout, **rating_values(self._ratings)}
        self._diagnostics.watch(
            "commands", heard(commands, "commands"), values=lambda: limits | self._counts()
        )
        self._diagnostics.watch("pressures", missed, *map(heard, others), values=self._pressure_values)
        self._diagnostics.watch("emergency stop", self._stop)

    def _counts(self) -> dict[str, Any]:
        return {"clipped since start": self._clipped, "shadow": self._shadow}

    def _pressure_values(self) -> dict[str, Any]:
        settings = {name: self._tunables.values[name] for name in ("compensate", "adapt")}
        return {"pressure_timeout [s]": self._measured.timeout, **settings}

    def _lacks_pressures(self) -> bool:
        return not self._gate.is_lost() and self._measured.are_missing()

    def _on_command(self, data: bytes, sent: float) -> None:
        reading = self._commands.read(data, self._node_clock.stamp())
        command = Command(reading.values, reading.stamp_ns, sent, reading.problem)
        verdict = self._gate.decide(command, self._stop.pressed)
        if verdict == Verdict.SKIP:
            return
        self._diagnostics.note("commands", self._gate.problem)
        if not self._gate.problem:
            clipped = beyond(topics.VALVE_COMMANDS, command.values, self._ratings)
            self._diagnostics.warn("commands", clipped)
            self._clipped += bool(clipped)
        if verdict == Verdict.CENTRE:
            self._stand_still()
        elif verdict == Verdict.STEP:
            self._advance(command)

    def _advance(self, command: Command) -> None:
        problem = self._measured.read(self._core.adapt)
        self._diagnostics.note("pressures", problem and f"{problem}; the nominal load is taken")
        moved = self._measured.machine_time(command.stamp)
        self._period, dt = stamped_period.time_in_force(self._period, moved, self._nominal)
        pressures, motion = self._measured.pressures(), self._measured.motion()
        self._state, voltages = self._step(self._state, command.values, pressures, motion, self._core, dt)
        self._out.say(command.stamp, voltages)
        self._out.report(command.stamp, self._state, self._core)
        self._tell(command.stamp)

    def _stand_still(self) -> None:
        self._state, stamp = valve_driver.at_rest(self._state), self._node_clock.stamp()
        self._out.say(stamp, ZERO)
        self._tell(stamp)

    def _tell(self, stamp: int) -> None:
        self._diagnostics.note("emergency stop", PRESSED if self._stop.pressed else "")
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
