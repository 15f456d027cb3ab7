"""The valve driver as a node: /valve_commands of ideal valves in, /valve_voltages of the real ones out.

It steps when a command arrives. When none arrives, or a bad one, or after an emergency stop, the voltage is
zero, whatever the controller does.
"""

import math
import sys
from functools import partial
from typing import Any

from rclpy.node import Node

from forest_control import compiled
from forest_control.valve import valve_driver
from forest_control.valve.tracking_limit import SAID_EVERY
from forest_control.valve.valve_driver_parameters import DriverParameters
from forest_control.valve.valve_driver_topics import Measurements, status
from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO, Vec3
from forest_msgs_py.clock.node_clock import node_clock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import Tunables, declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.runtime.stamp_order import StampOrder
from forest_msgs_py.runtime.stamped_period import TimeInForce
from forest_msgs_py.safety.diagnostics import Diagnostics, beyond, rating_values
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.serialization.unpacking import ArrayReader

WATCHDOG_PERIOD = 0.02  # [s]


class ValveDriverNode(Node):
    """Shell around `valve_driver.step`."""

    def __init__(self) -> None:
        super().__init__("valve_driver")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        machine = load_machine(declare(self, MachineParameter).machine)
        self._tunables = Tunables(self)
        self._core = valve_driver.parameters(machine, self._tunables.declare(valve_driver.Settings))
        self._tunables.watch(partial(self._set, machine))
        p = declare(self, DriverParameters)
        self._period, self._command_timeout = TimeInForce(p.period), p.command_timeout
        self._shadow = p.shadow
        self._state, self._step = valve_driver.REST, compiled.driver_step()
        self._command_received, self._count = -math.inf, 0
        self._order, self._asked = StampOrder(self._command_timeout), ZERO
        said = self._node_clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(
            self, ("commands", "pressures", "emergency stop"), "valves centred", said
        )
        stopped = self._node_clock.publisher(topics.EMERGENCY_STOPPED)
        self._stop = EmergencyStop(self, "~/", self._against_reset, self._stand_still, stopped)
        self._voltages = (
            None
            if p.shadow
            else number_publisher(self._node_clock, topics.VALVE_VOLTAGES, plain=p.plain_arrays)
        )
        self._status = number_publisher(self._node_clock, topics.VALVE_DRIVER_STATUS, plain=p.plain_arrays)
        self._commands = ArrayReader(topics.VALVE_COMMANDS)
        commands = self._node_clock.on(topics.VALVE_COMMANDS, self._on_command)
        self._measured = Measurements(self._node_clock, p.pressure_timeout, self._core.idle_pressure)
        self._ratings, self._clipped = [machine.valve_of(axis).rated_voltage for axis in range(3)], 0
        self._watch_inputs(commands)
        self._node_clock.every(WATCHDOG_PERIOD, self._watch)

    def _watch_inputs(self, commands: Any) -> None:
        """Have /diagnostics tell of what the driver hears."""
        heard = partial(InputStatus, self, self._node_clock)
        self._diagnostics.watch("commands", heard(commands, "commands"), values=self._command_values)
        pressures, *others = self._measured.boxes
        missed = heard(pressures, "pressures (the nominal load is taken)", self._is_blind)
        self._diagnostics.watch("pressures", missed, *map(heard, others), values=self._pressure_values)
        self._diagnostics.watch("emergency stop", self._stop)

    def _command_values(self) -> dict[str, Any]:
        limits = {"command_timeout [s]": self._command_timeout, **rating_values(self._ratings)}
        return limits | {"clipped since start": self._clipped, "shadow": self._shadow}

    def _pressure_values(self) -> dict[str, Any]:
        settings = {name: self._tunables.values[name] for name in ("compensate", "adapt")}
        return {"pressure_timeout [s]": self._measured.timeout, **settings}

    def _is_blind(self) -> bool:
        """Tell whether a command has to do without pressures."""
        return self._command_age() <= self._command_timeout and self._measured.are_missing()

    def _set(self, machine: Machine, values: dict[str, Any]) -> None:
        self._core = valve_driver.parameters(machine, valve_driver.Settings(**values))

    def _on_command(self, data: bytes, sent: float) -> None:
        if self._node_clock.now() - sent > self._command_timeout:
            return  # left over from a stall; the watchdog speaks meanwhile
        now = self._node_clock.stamp()
        reading = self._commands.read(data, now)
        problem = reading.problem
        if not problem and reading.values != ZERO:  # zero is obeyed in any order
            disorder = self._order.problem("valve_commands", reading.stamp_ns, sent)
            if disorder:
                self._diagnostics.note("commands", disorder)
                return  # what is past moves nothing; the watchdog acts if nothing newer comes
        self._diagnostics.note("commands", problem)
        if problem:
            self._stand_still()
            return
        self._command_received, self._asked = sent, reading.values
        clipped = beyond(topics.VALVE_COMMANDS, reading.values, self._ratings)
        self._diagnostics.warn("commands", clipped)
        self._clipped += bool(clipped)
        if self._stop.pressed:
            self._stand_still()
            return
        problem = self._measured.read(self._core.adapt)
        dt = self._period.since(self._measured.machine_time(reading.stamp_ns))
        self._diagnostics.note("pressures", problem and f"{problem}; the nominal load is taken")
        pressures, motion = self._measured.pressures(), self._measured.motion()
        self._state, voltages = self._step(self._state, reading.values, pressures, motion, self._core, dt)
        self._publish(reading.stamp_ns, voltages)
        if self._count % SAID_EVERY == 0:
            self._status.publish(reading.stamp_ns, status(self._state, self._core))
        self._count += 1
        self._tell(reading.stamp_ns)

    def _against_reset(self) -> str:
        asked = self._asked != ZERO and self._command_age() <= self._command_timeout
        return "a command is not zero; release the deadman" if asked else ""

    def _command_age(self) -> float:
        return self._node_clock.now() - self._command_received

    def _stand_still(self) -> None:
        self._state = valve_driver.at_rest(self._state)
        now = self._node_clock.stamp()
        self._publish(now, ZERO)
        self._tell(now)

    def _tell(self, stamp: int) -> None:
        self._diagnostics.note("emergency stop", "emergency stop pressed" if self._stop.pressed else "")
        self._diagnostics.publish(stamp)

    def _publish(self, stamp: int, voltages: Vec3) -> None:
        if self._voltages is not None:
            self._voltages.publish(stamp, voltages)

    def _watch(self) -> None:
        """Centre the valves while no command comes; before the first one too: a machine sees who is there."""
        if self._command_age() > self._command_timeout:
            if self._period.started:
                self._diagnostics.note("commands", "no command")
            self._stand_still()

    def stop(self) -> None:
        """Last words: zero."""
        self._publish(self._node_clock.stamp(), ZERO)


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(ValveDriverNode))


if __name__ == "__main__":
    main()
