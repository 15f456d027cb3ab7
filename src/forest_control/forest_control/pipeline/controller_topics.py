"""The controller's inputs from topics and its output to topics: conversions only, which decide nothing."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from forest_control.config.controller_settings import Parameters
from forest_control.limits.load_moment import WARNED, Loading
from forest_control.limits.load_weighing import UNREAD as NO_PRESSURES
from forest_control.operator.joystick_watch import joystick_sample, unreadable_sample
from forest_control.operator.levers import RIGHT_Y
from forest_control.operator.taught_command import NO_COMMAND, from_values
from forest_control.pipeline.control_state import Telemetry
from forest_control.pipeline.guarded_controller import GuardedController
from forest_control.pipeline.valve_feedback import ValveReports
from forest_control.safety.motion_guard import MotionGuard
from forest_control.safety.motion_permission import MachineState, Override
from forest_control.servo.joint_angle_filter import UNREAD as NO_LENGTHS
from forest_control.servo.joint_angle_filter import Lengths, Source
from forest_control.servo.schemes import Scheme
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_msgs_py.clock.node_clock import number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.safety.talkers import Publishers
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader, read_joy_data

FRAME = "base_link"
BOOM_PRESSURES = "boom_1_actuator", "boom_2_actuator"
PRESSURE_TIMEOUT = 0.1  # [s] at which pressures count as none
SEVERAL = "joy: more than one node publishes it; allowed: one joystick"
SEVERAL_MACHINES = "more than one node publishes it; allowed: one machine"
OF_MACHINE = [topic.name for topic in (topics.ACTUATOR_STATES, topics.PRESSURES, topics.SUPPLY)]
NO_RATES = "joint state: no finite velocity; allowed: rad/s of every joint"


class ControllerInputs:
    """What the controller hears beside the joints.

    Args:
        node_clock: of the node, whose subscriptions are used.
        machine: whose valves and joints they are.
        deadman: button to hold.
    """

    def __init__(self, node_clock: Any, machine: Machine, deadman: int) -> None:
        self._node_clock = node_clock
        self.joy, self.valves = node_clock.polled_subscription(topics.JOY), ValveReports(node_clock, machine)
        self._joysticks = Publishers()
        self.joy.heard = self._joysticks.hear
        self.actuators = node_clock.polled_subscription(topics.ACTUATOR_STATES)
        self.pressures = node_clock.polled_subscription(topics.PRESSURES)
        self._boom = ArrayReader(topics.PRESSURES, BOOM_PRESSURES)
        self.supply = node_clock.polled_subscription(topics.SUPPLY)
        self._supply = ArrayReader(topics.SUPPLY, ("pressure",))
        self._machines = {name: Publishers() for name in ("joint state", *OF_MACHINE)}
        for name, box in zip(OF_MACHINE, (self.actuators, self.pressures, self.supply), strict=True):
            box.heard = self._machines[name].hear
        # In lockstep nobody plays: a step cannot wait for an answer to itself.
        self.taught = None if node_clock.lockstep else node_clock.polled_subscription(topics.TAUGHT_COMMAND)
        self._taught = ArrayReader(topics.TAUGHT_COMMAND)
        self._joints, self._lengths = JointReader(topics.JOINTS), JointReader(topics.ACTUATORS)
        self._deadman, self._before = deadman, None  # axes and buttons of the sample before

    def watch(
        self,
        node: Any,
        diagnostics: Diagnostics,
        joints: Any,
        guard: MotionGuard,
        limits: Callable[[], dict[str, Any]],
    ) -> None:
        """Have /diagnostics tell of what the controller hears.

        Args:
            node: whose inputs they are.
            diagnostics: of the node.
            joints: what its clock's `on` gave for the joints.
            guard: knows the joystick.
            limits: gives what limits the motion, by names with units.
        """
        joints.heard = self._machines["joint state"].hear
        heard = partial(InputStatus, node, self._node_clock)
        joystick = heard(self.joy, "a joystick", lambda: guard.misses_joystick(self.joy.age()))
        diagnostics.watch("joystick", joystick, values=guard.joystick_values)
        others = map(heard, (self.actuators, self.pressures, self.valves.volts, self.valves.status))
        diagnostics.watch("machine", heard(joints, "the machine's state"), *others, values=limits)

    def read_joystick(self, guard: MotionGuard) -> None:
        """Have the guard hear every joystick sample that waits, oldest first."""
        for data, received in self.joy.arrivals():
            reading, frame = read_joy_data(data, RIGHT_Y + 1, self._deadman + 1)
            if self._joysticks.are_several():
                guard.hear(unreadable_sample(received), SEVERAL)
                continue
            if reading.problem:
                guard.hear(unreadable_sample(received), reading.problem)
                continue
            content, before = reading.values, self._before
            self._before = content
            guard.hear(joystick_sample(reading.stamp_ns, frame, received, content, before, self._deadman))

    def read_operator(self, controller: GuardedController) -> None:
        """Have the controller hear joystick samples and taught commands that wait."""
        self.read_joystick(controller.guard)
        self.read_taught(controller)

    def read_taught(self, controller: GuardedController) -> None:
        """Have the controller hear every taught command that waits, oldest first."""
        for data, sent in self.taught.arrivals() if self.taught else ():
            reading = self._taught.read(data, 0)
            if reading.problem:
                controller.hear_taught(0.0, NO_COMMAND, sent, reading.problem)
            else:
                controller.hear_taught(*from_values(reading.values), sent)

    def machine_state(self, data: bytes, received: float) -> tuple[MachineState, str]:
        """Return what a message of the joints says, and why it cannot be read, or ""."""
        reading = self._joints.read(data)
        angles, rates = reading.values.position, reading.values.velocity
        several = next((name for name, those in self._machines.items() if those.are_several()), "")
        problem = (
            f"{several}: {SEVERAL_MACHINES}" if several else reading.problem or ("" if rates else NO_RATES)
        )
        state = MachineState(
            angles=angles,
            rates=rates,
            stamp=reading.stamp_ns,
            received=received,
            readable=not problem,
            boom_pressures=self._fresh(self.pressures, self._boom, NO_PRESSURES),
            supply=self._fresh(self.supply, self._supply, (math.nan,))[0],
        )
        return state, problem

    def _fresh(self, topic: Any, reader: ArrayReader, none: tuple[float, ...]) -> Any:
        """Return pressures [Pa], NaN where there are no fresh ones."""
        arrival = topic.newest()
        if not arrival or self._node_clock.now() - arrival.time > PRESSURE_TIMEOUT:
            return none
        reading = reader.read(arrival.message, 0)
        return none if reading.problem else reading.values

    def cylinders(self, stamp: int, p: Parameters) -> Lengths:
        """Return the lengths [m] of boom and stick at a stamp [ns]; NaN where there are none to be used."""
        if p.position_source == Source.JOINTS or not (arrival := self.actuators.newest()):
            return NO_LENGTHS
        reading = self._lengths.read(arrival.message)
        if reading.problem or reading.stamp_ns != stamp:
            return NO_LENGTHS
        _, boom, stick = reading.values.position
        return boom, stick


class ControllerOutputs:
    """What the controller says.

    Args:
        node_clock: of the node, whose publishers are used.
        plain: arrays carry no stamp.
    """

    def __init__(self, node_clock: Any, plain: bool) -> None:
        self._command = number_publisher(node_clock, topics.VALVE_COMMANDS, plain=plain)
        self._pose = number_publisher(node_clock, topics.TIP_POSE, FRAME)
        self._twist = number_publisher(node_clock, topics.TIP_TWIST, FRAME)
        self._reference = number_publisher(node_clock, topics.TIP_TWIST_COMMAND, FRAME)
        self._status = number_publisher(node_clock, topics.CONTROLLER_STATUS, plain=plain)
        self._load = number_publisher(node_clock, topics.TIP_LOAD, plain=plain)
        self._node_clock = node_clock

    def say_description(self, text: str) -> None:
        """Say what the crane looks like (URDF), for those who come later, too."""
        self._description = self._node_clock.publisher(topics.ROBOT_DESCRIPTION)
        self._description.publish(message_class(topics.ROBOT_DESCRIPTION)(data=text))

    def say_command(self, stamp: int, command: Vec3, override: Override) -> None:
        """Say the ideal valves' voltages [V], unless somebody else has the valves."""
        if not override.hands_off:
            self._command.publish(stamp, command)

    def say(
        self, stamp: int, telemetry: Telemetry, controller: GuardedController, override: Override
    ) -> None:
        """Say a step's command, where the tip is, how it moves and shall, and what holds it back."""
        output, watch = telemetry.output, controller.guard.permission.joystick
        self.say_command(stamp, output.command, override)
        self._pose.publish(stamp, (*telemetry.tip, *telemetry.tip_orientation))
        self._twist.publish(stamp, telemetry.tip_velocity)
        if controller.parameters.scheme != Scheme.JOINT:
            self._reference.publish(stamp, output.tip_velocity_reference)
        scaling = output.scaling
        codes = scaling.factor, scaling.limit, watch.armed, watch.joystick, override.emergency_stop
        self._status.publish(stamp, codes)
        self._load.publish(stamp, told_load(output.loading))


def told_load(load: Loading) -> tuple[float, float, float, float]:
    """Return the values of `topics.TIP_LOAD`; NaN for what is not known, or has no bound."""
    if load.allowed == math.inf:
        return load.mass, load.reach, math.nan, math.nan
    return load.mass, load.reach, load.allowed, math.nan if math.isnan(load.mass) else load.utilisation


def load_caution(load: Loading) -> str:
    """Return what a person should know of what the crane carries, "" for nothing."""
    if load.allowed == math.inf or load.utilisation < WARNED:
        return ""
    if math.isnan(load.mass):
        return "load: not weighed, no pressures of the boom's cylinder; only motions that unload pass"
    told = (
        f"load: {load.mass:.0f} kg at {load.reach:.1f} m, {100.0 * load.utilisation:.0f} % of what is allowed"
    )
    return told if load.utilisation < 1.0 else f"{told}; only motions that unload pass"
