"""The controller as a node: /joy and /joint_states in, /valve_commands and the tip's motion out.

It steps when the machine's state arrives. Without a live joystick with the deadman held (`joystick_watch`),
without a fresh state, and after an emergency stop, it commands zero.
"""

import math
import sys
from functools import partial
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node

from forest_control import compiled
from forest_control.config.controller_parameters import ControllerParameters, ProfileParameter
from forest_control.config.parameter_update import ParameterUpdate
from forest_control.config.profile_file import load_profile
from forest_control.config.settings import Settings
from forest_control.config.workspace_file import load_workspace
from forest_control.operator import joystick_interpolation, joystick_watch
from forest_control.operator.joystick_watch import (
    Joystick,
    Operator,
    WatchParameters,
    is_released,
    joystick_sample,
    problem_text,
    unreadable_sample,
)
from forest_control.operator.levers import RIGHT_Y
from forest_control.pipeline import controller
from forest_control.pipeline.valve_feedback import ValveReports
from forest_control.safety import frozen_sensor
from forest_control.safety.state_checks import implausible
from forest_control.servo.joint_angle_filter import UNREAD, Lengths, Source
from forest_control.servo.schemes import Scheme
from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.clock.node_clock import pace, speaker
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import Tunables, declare
from forest_msgs_py.runtime.parameter_table import MachineParameter, table_of
from forest_msgs_py.runtime.stamp_order import StampOrder
from forest_msgs_py.runtime.stamped_period import StampedPeriod
from forest_msgs_py.safety.diagnostics import Health
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.serialization.unpacking import JointReader, read_joy_data
from forest_msgs_py.types import WATCHDOG_PERIOD

FRAME = "base_link"
# Settings that limit the motion, as /diagnostics tells them.
TOLD = {"scheme": "", "tip_speed": " [m/s]", "joint_rates": " [rad/s]", "joint_margin": " [rad]"}
GOES_BACK = "joy: a stamp goes back; allowed: rising stamps, or none"


class ControllerNode(Node):
    """Shell around `controller.step`."""

    _refused = -math.inf, ""  # when a state of the machine was last not believed, and why

    def __init__(self) -> None:
        super().__init__("controller")
        self._pace = pace(self)
        self.run = self._pace.run
        machine = load_machine(declare(self, MachineParameter).machine)
        # An operator's profile gives what is not set.
        tunables = Tunables(self, {"profile": load_profile})
        profile = load_profile(tunables.declare(ProfileParameter).profile)
        settings = tunables.declare(Settings, profile)
        p, self._watch_settings = declare(self, ControllerParameters), declare(self, WatchParameters)
        self._machine, self._tunables, self._workspace = machine, tunables, load_workspace(p.workspace)
        self._tuning = ParameterUpdate(controller.parameters(machine, settings, self._workspace))
        self._period, self._state_timeout = StampedPeriod(p.period), p.state_timeout
        self._deadman, self._plain = p.deadman_button, p.plain_arrays
        self.add_on_set_parameters_callback(self._may_take_hands_off)
        self._state, self._step = controller.REST, compiled.controller_step()
        self._asked, self._still = ZERO, frozen_sensor.MOVING
        tunables.watch(self._tune)
        self._state_received, self._order = -math.inf, StampOrder(self._state_timeout)
        self._joystick, self._joy_content, self._joy_problem = joystick_watch.REST, None, ""
        self._hold = joystick_interpolation.CENTRED
        said = self._pace.publisher(topics.DIAGNOSTICS)
        self._health = Health(self, ("joystick", "machine", "emergency stop"), "standing still", said)
        stopped = self._pace.publisher(topics.EMERGENCY_STOPPED)
        self._stop = EmergencyStop(self, "", self._against_reset, self._stand_still, stopped)
        self._declare_outputs()
        if p.publish_description:
            self._describe(machine)
        self._joints = JointReader(topics.JOINTS)
        self._joy, self._valves = self._pace.inbox(topics.JOY), ValveReports(self._pace, machine)
        self._actuators, self._lengths = (
            self._pace.inbox(topics.ACTUATOR_STATES),
            JointReader(topics.ACTUATORS),
        )
        self._watch_inputs(self._pace.on(topics.JOINT_STATES, self._on_joint_states))
        self._pace.every(WATCHDOG_PERIOD, self._on_watchdog)

    def _describe(self, machine: Machine) -> None:
        self._description = self._pace.publisher(topics.ROBOT_DESCRIPTION)
        text = robot_description(machine)
        self._description.publish(message_class(topics.ROBOT_DESCRIPTION)(data=text))

    def _declare_outputs(self) -> None:
        self._command = speaker(self._pace, topics.VALVE_COMMANDS, plain=self._plain)
        self._pose = speaker(self._pace, topics.TIP_POSE, FRAME)
        self._twist = speaker(self._pace, topics.TIP_TWIST, FRAME)
        self._wish = speaker(self._pace, topics.TIP_TWIST_COMMAND, FRAME)
        self._status = speaker(self._pace, topics.CONTROLLER_STATUS, plain=self._plain)

    def _watch_inputs(self, joints: Any) -> None:
        """Have /diagnostics tell of what the controller hears."""
        heard, reports = partial(InputStatus, self, self._pace), (self._valves.volts, self._valves.status)
        joystick = heard(self._joy, "a joystick", self._is_nobody_there)
        self._health.watch("joystick", joystick, values=self._joystick_values)
        others = map(heard, (self._actuators, *reports))
        self._health.watch("machine", heard(joints, "the machine's state"), *others, values=self._limits)
        self._health.watch("emergency stop", self._stop)

    def _joystick_values(self) -> dict[str, Any]:
        watch, p = self._joystick, self._watch_settings
        state = {"state": watch.joystick.name.lower(), "deadman held": watch.held, "armed": watch.armed}
        timeouts = {"joy_timeout [s]": p.joy_timeout, "frozen_timeout [s]": p.frozen_timeout}
        return {**state, **timeouts, "centre [1]": p.centre, "out of order since start": watch.out_of_order}

    def _limits(self) -> dict[str, Any]:
        timeouts = {"state_timeout [s]": self._state_timeout, "hands_off": self._hands_off()}
        limits = {name + unit: self._tunables.values[name] for name, unit in TOLD.items()}
        return timeouts | limits

    def _is_nobody_there(self) -> bool:
        """Tell whether there never was a joystick, or it went after the deadman was released."""
        watch = self._joystick
        return watch.joystick == Joystick.SILENT or (watch.joystick == Joystick.LOST and not watch.held)

    def _tune(self, values: dict[str, Any]) -> None:
        """Follow parameters that were set while the machine may be moving."""
        self._tuning.request(
            controller.parameters(self._machine, table_of(Settings, values), self._workspace)
        )

    def _read_joy(self) -> None:
        """Take in every joystick sample that waits, oldest first."""
        for data, received in self._joy.arrivals():
            reading, frame = read_joy_data(data, RIGHT_Y + 1, self._deadman + 1)
            sample = unreadable_sample(received)
            if not reading.problem:
                before = self._joy_content
                sample = joystick_sample(
                    reading.stamp_ns, frame, received, reading.values, before, self._deadman
                )
                self._joy_content = reading.values
            dropped = self._joystick.out_of_order
            self._joystick = joystick_watch.updated_watch(self._joystick, sample)
            in_order = self._joystick.out_of_order == dropped
            self._joy_problem = reading.problem or ("" if in_order else GOES_BACK)

    def _on_joint_states(self, data: bytes, sent: float) -> None:
        if self._pace.now() - sent > self._state_timeout:
            return  # left over from a stall, ours or the machine's; the watchdog speaks meanwhile
        self._watch()  # after a stall of ours this may come before its timer
        reading = self._joints.read(data)
        angles, rates = reading.values.position, reading.values.velocity
        problem = reading.problem or implausible(angles, rates, self._tuning.core)
        if problem:
            self._refuse(problem)
            self._stand_still()
            return
        disorder = self._order.problem("joint state", reading.stamp_ns, sent)
        if disorder:
            self._refuse(disorder)
            return  # what is past moves nothing; the watchdog acts if nothing newer comes
        self._state_received = sent
        dt = self._period.step(reading.stamp_ns, sent)
        if dt == 0.0:
            return
        if self._tuning.apply_if_due(self._asked == ZERO, dt):
            self._state = self._state._replace(changed=True)
        lengths, valves = self._cylinders(reading.stamp_ns), self._valves.read()
        self._still = frozen_sensor.watched(self._still, angles, self._asked, self._tuning.core, dt)
        problem = self._valves.objection(self._asked) or frozen_sensor.frozen(self._still)
        self._health.note("machine", problem)
        if problem:
            self._operator(False)
            self._stand_still()
            return
        inputs = controller.Inputs(angles, rates, *self._operator(True, sent, dt), lengths, *valves)
        if self._stop.pressed or self._hands_off():
            self._state = controller.REST  # from which there is no ramp: zero at once
        self._state, told = self._step(self._state, inputs, self._tuning.core, dt)
        self._publish(reading.stamp_ns, told)

    def _cylinders(self, stamp: int) -> Lengths:
        """Return the lengths [m] of boom and stick cylinder at a stamp; NaN if they are not to be had."""
        if self._tuning.core.position_source == Source.JOINTS or not (arrival := self._actuators.newest()):
            return UNREAD
        reading = self._lengths.read(arrival.message)
        if reading.problem or reading.stamp_ns != stamp:
            return UNREAD
        _, boom, stick = reading.values.position
        return boom, stick

    def _operator(self, machine_known: bool, sent: float = -math.inf, dt: float = 0.0) -> Operator:
        """Return where the levers are, and whether they may move anything.

        Args:
            machine_known: there is a fresh state of the machine.
            sent: when it was sent [s].
            dt: after the one before [s].
        """
        self._read_joy()
        allowed = machine_known and not self._stop.pressed and not self._hands_off()
        p = self._watch_settings
        self._joystick, operator = joystick_watch.assessed_watch(self._joystick, self._pace.now(), allowed, p)
        # A joystick that goes after the deadman was released is not missed.
        gone = self._is_nobody_there()
        problem = self._joy_problem or ("" if gone else problem_text(self._joystick))
        self._health.note("joystick", problem)
        self._health.note("emergency stop", "emergency stop pressed" if self._stop.pressed else "")
        if not operator.enabled:
            self._hold = joystick_interpolation.CENTRED
            return operator
        said = self._joystick.fresh_since
        self._hold = joystick_interpolation.interpolated(self._hold, operator.levers, said, sent, dt)
        return Operator(self._hold.levers, True)

    def _against_reset(self) -> str:
        if is_released(self._joystick, self._watch_settings.centre):
            return ""
        return "the levers must be centred and the deadman released"

    def _publish(self, stamp: int, told: Any) -> None:
        output = told.output
        self._asked = output.command
        if not self._hands_off():
            self._command.say(stamp, output.command)
        self._pose.say(stamp, (*told.tip, *told.tip_orientation))
        self._twist.say(stamp, told.tip_velocity)
        if self._tuning.core.scheme != Scheme.JOINT:
            self._wish.say(stamp, output.tip_wish)
        watch, held_back = self._joystick, output.scaling
        codes = held_back.factor, held_back.limit, watch.armed, watch.joystick, self._stop.pressed
        self._status.say(stamp, codes)
        self._health.publish(stamp)

    def _on_watchdog(self) -> None:
        self._watch()
        if not self._period.started:  # nobody else would tell
            self._operator(False)
            self._health.publish(self._pace.stamp())

    def _watch(self) -> None:
        if self._pace.now() - self._state_received > self._state_timeout and self._period.started:
            when, why = self._refused  # the cause, rather than what follows from it
            refused = self._pace.now() - when <= self._state_timeout
            self._health.note("machine", why if refused else "no state of the machine")
            self._operator(False)
            self._stand_still()

    def _refuse(self, problem: str) -> None:
        """Remember and tell why a state of the machine is not believed."""
        self._refused = self._pace.now(), problem
        self._health.note("machine", problem)

    def _stand_still(self) -> None:
        self._state, self._asked, self._still = controller.REST, ZERO, frozen_sensor.MOVING
        now = self._pace.stamp()
        if not self._hands_off():
            self._command.say(now, ZERO)
        self._health.publish(now)

    def _may_take_hands_off(self, changed: list[Any]) -> SetParametersResult:
        wanted = any(parameter.name == "hands_off" and parameter.value for parameter in changed)
        refused = wanted and not self._hands_off() and self._joystick.armed
        return SetParametersResult(successful=not refused, reason="the deadman is held" if refused else "")

    def _hands_off(self) -> bool:
        return bool(self.get_parameter("hands_off").value)

    def stop(self) -> None:
        """Last words: zero."""
        self._stand_still()


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(ControllerNode))


if __name__ == "__main__":
    main()
