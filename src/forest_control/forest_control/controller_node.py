"""The controller as a node: /joy and /joint_states in, /valve_commands and the tip's motion out.

It steps when the machine's state arrives. Whether the crane may move, `motion_permission` decides.
"""

import sys
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node

from forest_control import compiled
from forest_control.config.controller_configuration import ControllerConfiguration
from forest_control.pipeline.controller_topics import ControllerInputs, ControllerOutputs, load_caution
from forest_control.pipeline.guarded_controller import GuardedController
from forest_control.safety.motion_permission import Override, PermissionParameters, Verdict
from forest_description.types import ZERO
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.types import WATCHDOG_PERIOD


class ControllerNode(Node):
    """Shell around `GuardedController`."""

    def __init__(self) -> None:
        super().__init__("controller")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        self._configuration = configuration = ControllerConfiguration(self)
        p = configuration.node
        self.add_on_set_parameters_callback(self._may_take_hands_off)
        guard = PermissionParameters(configuration.joystick, p.state_timeout, p.period)
        self._controller = GuardedController(configuration.parameters, guard, compiled.controller_step())
        self._guard = self._controller.guard
        configuration.watch(self._controller.tune, self._controller.moves)
        said = self._node_clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(self, tuple(self._guard.causes), "standing still", said)
        stopped = self._node_clock.publisher(topics.EMERGENCY_STOPPED)
        self._stop = EmergencyStop(self, "", self._guard.against_reset, self._stand_still, stopped)
        self._outputs = ControllerOutputs(self._node_clock, p.plain_arrays)
        if p.publish_description:
            self._outputs.say_description(robot_description(configuration.machine))
        self._inputs = ControllerInputs(self._node_clock, configuration.machine, p.deadman_button)
        joints = self._node_clock.on(topics.JOINT_STATES, self._on_joint_states)
        self._inputs.watch(self, self._diagnostics, joints, self._guard, configuration.limits)
        self._diagnostics.watch("emergency stop", self._stop)
        self._node_clock.every(WATCHDOG_PERIOD, self._on_watchdog)

    def _on_joint_states(self, data: bytes, sent: float) -> None:
        (machine, problem), override = self._inputs.machine_state(data, sent), self._override()
        self._inputs.read_operator(self._controller)
        cylinders = self._inputs.cylinders(machine.stamp, self._controller.parameters)
        valves, now = self._inputs.valves.read(), self._node_clock.now()
        self._stops_without_state(now, override)  # after a stall of ours this may come before the watchdog
        decision, telemetry = self._controller.advance(machine, valves, now, cylinders, override, problem)
        self._diagnostics.note_all(self._guard.causes)
        if telemetry is not None:
            self._outputs.say(machine.stamp, telemetry, self._controller, override)
            self._diagnostics.warn("joystick", self._guard.joystick_caution())
            self._diagnostics.warn("machine", load_caution(telemetry.output.loading))
            self._diagnostics.publish(machine.stamp)
        elif decision.verdict == Verdict.STOP:
            self._say_zero()

    def _on_watchdog(self) -> None:
        self._inputs.read_joystick(self._guard)
        now, override = self._node_clock.now(), self._override()
        if self._stops_without_state(now, override):
            return
        if self._guard.has_begun():
            self._diagnostics.note_all(self._guard.causes)
        else:  # nobody else would tell
            self._guard.disarm(now, override)
            self._diagnostics.note_all(self._guard.causes)
            self._diagnostics.publish(self._node_clock.stamp())

    def _stops_without_state(self, now: float, override: Override) -> bool:
        """Stop, say so and why, if the machine's state has not come for too long; tell whether that is so."""
        lost = self._controller.stops_without_state(now, override)
        if lost:
            self._diagnostics.note_all(self._guard.causes)
            self._say_zero()
        return lost

    def _stand_still(self) -> None:
        self._controller.stop()
        self._say_zero()

    def _say_zero(self) -> None:
        now = self._node_clock.stamp()
        self._outputs.say_command(now, ZERO, self._override())
        self._diagnostics.publish(now)

    def _may_take_hands_off(self, changed: list[Any]) -> SetParametersResult:
        wanted = any(parameter.name == "hands_off" and parameter.value for parameter in changed)
        refused = wanted and not self._override().hands_off and self._guard.permission.joystick.armed
        return SetParametersResult(successful=not refused, reason="the deadman is held" if refused else "")

    def _override(self) -> Override:
        return Override(self._stop.pressed, self._configuration.hands_off())

    def stop(self) -> None:
        """Last words: zero."""
        self._stand_still()


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(ControllerNode))


if __name__ == "__main__":
    main()
