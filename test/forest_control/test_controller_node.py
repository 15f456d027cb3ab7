"""Claims about the controller as a process: whatever happens, it commands zero or what is wished."""

import itertools
import math
import signal
import time

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from forest_control.operator.levers import BUTTON_COUNT, LEFT_SHOULDER, Levers, axes_from_levers
from forest_description.geometry.kinematics import tip_orientation, tip_position
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state, read_float_array, stamp_to_ns

ANGLES = (0.2, 0.4, -1.5)
# Links do not bend; no load is weighed, for here nobody measures the pressures.
RIGID = NO_LOAD = ("-p", "machine:=c180_hoses")
MARGIN = 0.5  # [s] for a busy machine, beside the timeouts


def joy(levers=(0.5, 0.0, 0.0), held=True, axes=None, buttons=BUTTON_COUNT):
    values = list(axes_from_levers(Levers(*levers))) if axes is None else axes
    message = topics.message_class(topics.JOY)(axes=values, buttons=[0] * buttons)
    if buttons > LEFT_SHOULDER:
        message.buttons[LEFT_SHOULDER] = int(held)
    return message


def centred():
    return joy((0.0, 0.0, 0.0))


def is_armed(status):
    return read_float_array(topics.CONTROLLER_STATUS, status, 0, ("armed",)).values == (1.0,)


def is_heard(status):
    return read_float_array(topics.CONTROLLER_STATUS, status, 0, ("joystick",)).values == (1.0,)


def joints(now, angles=ANGLES, names=topics.JOINTS, velocity=(0.0, 0.0, 0.0)):
    """A machine that stands, with sensors as they are: the last bits are never at rest."""
    return joint_state(names, now, [angle + 1e-12 * (now // 1000 % 1000) for angle in angles], velocity)


def volts(message):
    reading = read_float_array(topics.VALVE_COMMANDS, message, 0)
    assert reading.problem == ""
    return reading.values


class Rig:
    """A controller with a joystick and a machine that stands still; what they say can be changed."""

    def __init__(self, peer, start_node, *ros_args):
        self.peer = peer
        self.process = start_node("controller_node", *ros_args)
        self.commands = peer.hear(topics.VALVE_COMMANDS)
        self.statuses = peer.hear(topics.CONTROLLER_STATUS)
        self.joy, self.joints = joy, joints
        self.joints_timer = peer.repeat(topics.JOINT_STATES, lambda now: self.joints(now), 200.0)

    def hold_the_deadman(self, rate_hz=100.0):
        self.joy = centred
        self.joy_timer = self.peer.repeat(topics.JOY, lambda now: self.joy(), rate_hz)
        return self.push()

    def push(self):
        """Have the stick pushed, whatever comes between, and wait until that moves something."""
        self.joy = self.pushed
        self.peer.until(self.moving)
        return self

    def pushed(self):
        """Centred until that has armed, then deflected; again, if a stall of the computer disarmed."""
        armed = bool(self.statuses) and is_armed(self.statuses[-1])
        return joy() if armed else centred()

    def moving(self):
        return bool(self.commands) and volts(self.commands[-1])[0] > 0.0

    def standing(self, count=5):
        return len(self.commands) >= count and all(
            volts(m) == (0.0, 0.0, 0.0) for m in self.commands[-count:]
        )

    def stands_until_centred(self, other):
        """Another speaks, and leaves: the crane stands until the levers were centred."""
        heard = len(self.commands)
        self.peer.until(lambda: len(self.commands) > heard + 100)
        assert self.standing(100)
        other.cancel()
        self.peer.until(lambda: len(self.commands) > heard + 300)
        assert self.standing(300)
        self.push()


@pytest.fixture
def rig(peer, start_node):
    def start(*ros_args):
        return Rig(peer, start_node, *ros_args)

    return start


REFUSED = {
    "tip_speed:=-3.0": "parameter 'tip_speed' is -3.0; allowed: 0.01 .. 3 m/s",
    "profile:=nobody": "profile 'nobody': neither shipped (default, exact, fine, operator)",
}


def test_a_bad_parameter_ends_the_node_with_one_line(domain_id, start_node):
    processes = {said: start_node("controller_node", "-p", given) for given, said in REFUSED.items()}
    for said, process in processes.items():
        assert process.ended() == 2
        assert process.text().count("\n") == 1
        assert said in process.text()


def test_without_a_joystick_it_commands_zero_and_tells_where_the_tip_is(rig, peer):
    poses, wishes = peer.hear(topics.TIP_POSE), peer.hear(topics.TIP_TWIST_COMMAND)
    r = rig(*RIGID)
    peer.until(lambda: r.standing(20) and poses and wishes)
    assert all(volts(message) == (0.0, 0.0, 0.0) for message in r.commands)
    tip = poses[0].pose.position
    assert (tip.x, tip.y, tip.z) == pytest.approx(tip_position(ANGLES, load_machine().manipulator.links))
    turn = poses[0].pose.orientation
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx(tip_orientation(ANGLES))
    assert wishes[-1].twist.linear.y == 0.0


def test_where_the_tip_is_comes_from_the_cylinders_of_the_same_stamp(rig, peer):
    poses, r, machine = peer.hear(topics.TIP_POSE), rig(*RIGID), load_machine()
    actuators, true = peer.speak(topics.ACTUATOR_STATES), (ANGLES[0], ANGLES[1] + 0.01, ANGLES[2] - 0.02)
    lengths = [cylinder_length(true[i + 1], machine.linkages[i]) for i in (0, 1)]

    def with_cylinders(now):
        actuators.publish(joint_state(topics.ACTUATORS, now, (ANGLES[0], *lengths)))
        return joints(now)

    def seen():
        tip = poses[-1].pose.position
        there = tip_position(true, machine.manipulator.links)
        return math.dist((tip.x, tip.y, tip.z), there) < 1e-6

    r.joints = with_cylinders
    peer.until(lambda: poses and seen())


def test_with_the_deadman_held_it_commands_and_each_command_has_its_states_stamp(rig, peer):
    wishes, stamps = peer.hear(topics.TIP_TWIST_COMMAND), set()
    r = rig(*NO_LOAD)

    def stamped(now):
        stamps.add(now)
        return joints(now)

    r.joints = stamped
    r.hold_the_deadman()
    wished = 0.5 * (0.5 - 0.05) / (1.0 - 0.05)  # by default a stick has a deadzone
    peer.until(lambda: wishes and wishes[-1].twist.linear.y > 0.9999 * wished)  # the wish is a ramp
    assert wishes[-1].twist.linear.y == pytest.approx(wished, rel=1e-6)
    driven = [message for message in r.commands if volts(message)[0] > 0.0]
    assert {read_float_array(topics.VALVE_COMMANDS, message, 0).stamp_ns for message in driven} <= stamps
    assert stamp_to_ns(wishes[-1].header.stamp) in stamps


def test_joint_mode_moves_the_joint_and_wishes_no_tip_motion(rig, peer):
    wishes = peer.hear(topics.TIP_TWIST_COMMAND)
    r = rig("-p", "scheme:=joint", "-p", "joint_rates:=[1, 1, 1]").hold_the_deadman()
    assert volts(r.commands[-1])[1:] == (0.0, 0.0)
    assert not wishes


@pytest.mark.parametrize("how", ["released", "silent"])
def test_when_the_deadman_goes_the_command_goes_to_zero_in_time(rig, peer, how):
    r = rig("-p", "joy_timeout:=0.15").hold_the_deadman()
    if how == "released":
        r.joy = lambda: joy(held=False)
    else:
        r.joy_timer.cancel()
    assert peer.reaction(r.standing, r.process) < 0.15 + MARGIN
    if how == "silent":
        assert "standing still: joystick" in r.process.text()


def test_when_the_machines_state_stops_the_command_goes_to_zero_in_time(rig, peer):
    r = rig("-p", "state_timeout:=0.05").hold_the_deadman()
    r.joints_timer.cancel()
    assert peer.reaction(r.standing, r.process) < 0.05 + MARGIN
    assert "standing still: no state of the machine" in r.process.text()
    r.joints_timer.reset()
    r.push()


def test_a_joystick_that_fell_silent_before_the_state_came_back_moves_nothing(rig, peer):
    r = rig("-p", "joy_timeout:=0.15").hold_the_deadman()
    r.joints_timer.cancel()
    peer.until(r.standing)
    said = len(r.commands)
    peer.until(lambda: len(r.commands) > said + 5)  # levers keep coming meanwhile, and wait in a queue
    r.joy_timer.cancel()
    silent = time.monotonic()
    peer.until(lambda: time.monotonic() - silent > 0.3)
    said = len(r.commands)
    r.joints_timer.reset()
    peer.until(lambda: len(r.commands) > said + 40)
    assert all(volts(message) == (0.0, 0.0, 0.0) for message in r.commands[said:])


def test_a_bad_state_gives_zero_and_the_node_lives(rig, peer):
    r = rig().hold_the_deadman()
    for bad in (
        lambda now: joints(now, (0.2, math.nan, -1.5)),
        lambda now: joints(now, velocity=(0.0, math.inf, 0.0)),
        lambda now: joints(now, velocity=()),
        lambda now: joints(now, (0.2, 0.4)),
        lambda now: joints(now, names=("swing", "boom", "elbow")),
        lambda now: joints(now, (0.2, -1.5), ("swing", "stick"), (0.0, 0.0)),  # the boom has no sensor
    ):
        r.joints = bad
        peer.until(r.standing)
        r.joints = joints
        r.push()
    assert r.process.poll() is None
    assert "joint state: no finite velocity; allowed: rad/s of every joint" in r.process.text()


def test_a_joint_without_a_sensor_gives_zero_and_is_named(rig, peer):
    r = rig()
    r.joints = lambda now: joints(now, (0.2, -1.5), ("swing", "stick"), (0.0, 0.0))
    peer.repeat(topics.JOY, lambda now: r.joy())
    peer.until(r.standing)
    peer.until(lambda: "standing still: joint state: no position of boom" in r.process.text())


def test_a_bad_joystick_gives_zero_and_the_node_lives(rig, peer):
    r = rig().hold_the_deadman()
    for bad in (
        lambda: joy(axes=[0.5, 0.0]),
        lambda: joy(axes=[]),
        lambda: joy(axes=[0.5, 0.0, 0.0, math.nan, 0.0, 0.0]),
        lambda: joy(axes=[3.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        lambda: joy(buttons=LEFT_SHOULDER),
    ):
        r.joy = bad
        peer.until(r.standing)
        r.push()
    assert r.process.poll() is None


def test_enabling_with_a_deflected_stick_moves_nothing_until_it_is_centred(rig, peer):
    heard, why = (
        peer.hear(topics.DIAGNOSTICS),
        "joystick: the levers move nothing until they have been centred",
    )
    r = rig()
    peer.repeat(topics.JOY, lambda now: r.joy())
    peer.until(lambda: any(said("controller: joystick", message) == why for message in heard))
    count = len(r.commands)
    peer.until(lambda: len(r.commands) > count + 40)
    assert all(volts(message) == (0.0, 0.0, 0.0) for message in r.commands)
    assert r.process.text().count(why) == 1
    r.push()
    peer.until(lambda: said("controller: joystick", heard[-1]) == "well")


@pytest.mark.parametrize("how", ["content", "stamp", "heartbeat"])
def test_a_frozen_joystick_moves_nothing_and_is_named(rig, peer, how):
    r = rig("-p", "frozen_timeout:=0.3").hold_the_deadman()
    frozen, count = joy(), itertools.count()
    if how == "stamp":
        frozen.header.stamp.sec = 5
    elif how == "heartbeat":
        frozen.header.frame_id = "heartbeat:77"

    def wobbling():
        if how != "content":
            frozen.axes[1] = 0.001 * (next(count) % 50)
        return frozen

    r.joy = wobbling
    assert peer.reaction(r.standing, r.process) < 0.3 + MARGIN
    said = "held still" if how == "content" else "nothing new"
    peer.until(lambda: f"standing still: joystick: {said}" in r.process.text())


def test_a_second_joystick_whose_deadman_is_held_too_stops_the_crane_and_is_named(rig, peer):
    r, said = rig(*RIGID).hold_the_deadman(), peer.hear(topics.DIAGNOSTICS)
    other = peer.repeat(topics.JOY, lambda now: joy((-0.5, 0.0, 0.0)), 100.0)
    assert peer.reaction(r.standing, r.process) < 0.35 + MARGIN
    named = "joy: more than one node publishes it; allowed: one joystick"
    peer.until(lambda: any(s.message == named for m in said for s in m.status))
    r.joy = joy
    r.stands_until_centred(other)


def test_a_second_machine_stops_the_crane_and_is_named_though_it_says_the_same(rig, peer):
    r, said = rig(*RIGID).hold_the_deadman(), peer.hear(topics.DIAGNOSTICS)
    other = peer.repeat(topics.JOINT_STATES, joints, 100.0)
    assert peer.reaction(r.standing, r.process) < 0.1 + MARGIN
    named = "joint state: more than one node publishes it; allowed: one machine"
    peer.until(lambda: any(s.message == named for m in said for s in m.status))
    r.stands_until_centred(other)


def test_a_trouble_comes_as_a_diagnostic(rig, peer):
    heard = peer.hear(topics.DIAGNOSTICS)
    r = rig().hold_the_deadman()
    peer.until(lambda: any(said("controller: joystick", m) == "well" for m in heard))
    r.joy = lambda: joy(axes=[0.5, 0.0, 0.0, math.nan, 0.0, 0.0])
    peer.until(lambda: any(said("controller: joystick", m).startswith("joy: axes are") for m in heard))
    r.joints = lambda now: joints(now, (0.2, math.nan, -1.5))
    # Again and again: it must not give way to "no state", which follows from it.
    peer.until(lambda: sum(said("controller: machine", m).startswith("joint state: posi") for m in heard) > 2)


def test_a_load_beyond_the_capacity_holds_the_tip_and_is_told(rig, peer):
    crane, heard = load_machine("c180"), peer.hear(topics.DIAGNOSTICS)
    r = rig("-p", "machine:=c180")
    loads, force = peer.hear(topics.TIP_LOAD), [3.6e5]  # [N] of the boom's cylinder: some 2 t
    labels = topics.PRESSURES.labels
    seen = [0.0] * len(labels)

    def pressures(now):
        seen[labels.index("boom_1_actuator")] = force[0] / crane.boom.head_area
        return float_array(topics.PRESSURES, now, seen)

    def limits():
        told = read_float_array(topics.CONTROLLER_STATUS, r.statuses[-1], 0, ("limit", "armed"))
        return told.values

    def outward():
        return joy((0.0, 0.0, 0.5)) if r.statuses and is_armed(r.statuses[-1]) else centred()

    r.joy = outward
    peer.repeat(topics.PRESSURES, pressures, 200.0)
    peer.repeat(topics.JOY, lambda now: r.joy())
    peer.until(lambda: r.statuses and limits() == (7.0, 1.0))
    peer.until(lambda: any("only motions that unload pass" in said("controller: machine", m) for m in heard))
    # It slides aside: the crane is slewn.
    peer.until(lambda: max(map(abs, volts(r.commands[-1])[1:])) < 0.05)
    told = read_float_array(topics.TIP_LOAD, loads[-1], 0).values
    assert told[3] == pytest.approx(told[0] / told[2])
    assert told[3] > 1.0
    force[0] = 1.5e5
    peer.until(lambda: limits()[0] != 7.0 and volts(r.commands[-1])[2] > 0.5)


def said(part, message):
    return next((status.message for status in message.status if status.name == part), "")


def values(message):
    return {pair.key: pair.value for status in message.status for pair in status.values}


def test_without_a_joystick_it_says_that_it_waits_for_one_and_once_in_the_log(rig, peer):
    heard, waiting = peer.hear(topics.DIAGNOSTICS), "waiting for a joystick on /joy"
    r = rig()
    peer.until(lambda: waiting in r.process.text() and len(heard) > 3)
    joystick = [status for message in heard for status in message.status if "joystick" in status.name]
    assert {(status.level, status.message) for status in joystick} == {(DiagnosticStatus.WARN, waiting)}
    assert r.process.text().count(waiting) == 1
    told = values(heard[-1])
    assert told["/joy age [s]"] == "never heard"
    assert told["state"] == "silent"
    assert float(told["/joint_states rate [Hz]"]) > 0.0
    limits = ("joy_timeout [s]", "frozen_timeout [s]", "state_timeout [s]", "tip_speed [m/s]")
    assert [float(told[name]) for name in limits] == [0.15, 10.0, 0.1, 0.5]


def test_before_the_machine_speaks_it_is_waited_for_and_a_joystick_that_is_there_is_known(peer, start_node):
    heard = peer.hear(topics.DIAGNOSTICS)
    start_node("controller_node")
    peer.repeat(topics.JOY, lambda now: joy(held=False))
    awaited = "waiting for the machine's state on /joint_states"
    peer.until(lambda: any(said("controller: joystick", message) == "well" for message in heard))
    assert all(said("controller: machine", message) == awaited for message in heard)


def test_a_joystick_that_publishes_best_effort_moves_the_crane(rig, peer):
    r = rig()
    lossy = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    joystick = peer.node.create_publisher(topics.message_class(topics.JOY), topics.JOY.name, lossy)
    r.joy = centred
    peer.node.create_timer(0.01, lambda: joystick.publish(r.joy()))
    r.push()


def test_a_driver_that_cannot_be_heard_is_named_in_log_and_diagnostics(rig, peer):
    heard, r = peer.hear(topics.DIAGNOSTICS), rig(*NO_LOAD)
    lossy = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    peer.node.create_publisher(topics.message_class(topics.VALVE_VOLTAGES), topics.VALVE_VOLTAGES.name, lossy)
    told = "/valve_voltages of /peer is not heard: best effort publisher and reliable subscription"
    peer.until(lambda: any(said("controller: machine", message) == told for message in heard))
    peer.until(lambda: told in r.process.text())


def test_a_silent_driver_and_a_frozen_sensor_stop_the_crane_until_the_levers_were_centred(rig, peer):
    r = rig()
    voltages = lambda now: float_array(topics.VALVE_VOLTAGES, now, (1.0, 0.0, 0.0))  # noqa: E731
    frozen = lambda now: joint_state(topics.JOINTS, now, ANGLES, (0.0, 0.0, 0.0))  # noqa: E731
    driver = peer.repeat(topics.VALVE_VOLTAGES, voltages, 200.0)
    r.hold_the_deadman()

    def stands_and_goes_on_standing(mend):
        peer.until(r.standing)
        mend()
        r.commands.clear()
        peer.until(lambda: len(r.commands) > 40)
        assert r.standing(40)

    r.joy = joy  # deflected throughout
    driver.cancel()
    stands_and_goes_on_standing(driver.reset)
    peer.until(lambda: "standing still: valve driver: no voltages" in r.process.text())
    r.push()
    r.joy, r.joints = joy, frozen
    peer.until(lambda: "swing is the same to the last bit" in r.process.text())
    r.joints = joints
    stands_and_goes_on_standing(lambda: None)
    r.joy = centred  # which is no act behind a broken sensor
    peer.until(lambda: "a fault is over; allowed: release the deadman" in r.process.text())
    r.joy = lambda: joy(held=False)
    r.commands.clear()
    peer.until(lambda: len(r.commands) > 40)
    r.push()


def test_its_time_does_not_run_faster_for_states_that_come_faster(rig, peer):
    wishes = peer.hear(topics.TIP_TWIST_COMMAND)
    r = rig("-p", "tip_acceleration:=0.5")
    r.joints_timer.cancel()
    sender, stamps = peer.speak(topics.JOINT_STATES), itertools.count(time.time_ns(), 1_000_000)

    def five():
        for stamp in itertools.islice(stamps, 5):
            sender.publish(joints(stamp))

    peer.node.create_timer(0.005, five)
    r.hold_the_deadman()
    peer.until(lambda: wishes and wishes[-1].twist.linear.y > 0.2)
    ramp = [
        (stamp_to_ns(wish.header.stamp) * 1e-9, wish.twist.linear.y)
        for wish in wishes
        if 0.02 < wish.twist.linear.y < 0.2
    ][-20:]  # of the last push
    # A stall makes it slower; of every state it would be 1.25.
    assert (ramp[-1][1] - ramp[0][1]) / (ramp[-1][0] - ramp[0][0]) < 0.6


def test_states_from_the_past_move_nothing(rig, peer):
    r = rig("-p", "state_timeout:=0.2").hold_the_deadman()
    newest = max(stamp_to_ns(joints(0).header.stamp), peer.node.get_clock().now().nanoseconds)
    r.joints = lambda now: joints(newest - 1_000_000_000)
    assert peer.reaction(r.standing, r.process) < 0.2 + MARGIN
    peer.until(lambda: "joint state: the stamp goes back" in r.process.text())


def test_an_emergency_stop_moves_nothing_until_it_is_reset_with_the_deadman_released(rig, peer):
    r = rig().hold_the_deadman()
    stop, reset = (peer.node.create_client(Trigger, f"{verb}emergency_stop") for verb in ("", "reset_"))
    peer.until(lambda: stop.service_is_ready() and reset.service_is_ready())
    assert answer(peer, stop).success
    peer.until(r.standing)
    for wrong in (joy, centred, lambda: joy(held=False)):
        r.joy = wrong
        heard = len(r.statuses)
        peer.until(lambda start=heard: len(r.statuses) > start + 10)
        assert "deadman released" in answer(peer, reset).message
    r.joy = lambda: joy((0.0, 0.0, 0.0), held=False)
    peer.until(lambda: answer(peer, reset).success)
    r.push()


def answer(peer, client):
    future = client.call_async(Trigger.Request())
    peer.until(future.done)
    return future.result()


def test_namespace_remaps_and_plain_arrays_work(peer, start_node):
    heard, elsewhere = peer.hear(topics.VALVE_COMMANDS, "/crane1/wishes"), peer.hear(topics.VALVE_COMMANDS)
    options = ("-r", "__ns:=/crane1", "-r", "valve_commands:=wishes", "-p", "plain_arrays:=true")
    start_node("controller_node", *options)
    state = peer.speak(topics.JOINT_STATES, "/crane1/joint_states")

    def answered():
        state.publish(joints(1))
        return heard

    peer.until(answered)
    assert heard[0].layout.data_offset == 0
    assert list(heard[0].data) == [0.0, 0.0, 0.0]
    assert not elsewhere


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_asked_to_stop_its_last_words_are_zero(rig, peer, number):
    r = rig().hold_the_deadman()
    r.process.send_signal(number)
    peer.until(lambda: r.process.poll() is not None)
    assert r.process.returncode == 0
    peer.until(lambda: volts(r.commands[-1]) == (0.0, 0.0, 0.0))
    assert "Traceback" not in r.process.text()


def test_a_controller_that_was_frozen_obeys_no_joystick_from_before(rig, peer):
    r = rig().hold_the_deadman()
    r.process.send_signal(signal.SIGSTOP)
    frozen = time.monotonic()
    peer.until(lambda: time.monotonic() - frozen > 0.3)  # joystick samples and states pile up
    r.joy_timer.cancel()
    lost = time.monotonic()
    peer.until(lambda: time.monotonic() - lost > 0.5)
    r.commands.clear()
    r.process.send_signal(signal.SIGCONT)
    peer.until(lambda: r.standing(10))
    # One at most: the state that it was working on when it froze had been fresh.
    assert sum(volts(message) != (0.0, 0.0, 0.0) for message in r.commands) <= 1


def test_degrees_for_radians_move_nothing(rig, peer):
    r = rig().hold_the_deadman()
    r.joints = lambda now: joints(now, tuple(math.degrees(angle) for angle in ANGLES))
    peer.until(r.standing)
    assert "allowed: -3.2" in r.process.text()
    r.joints = joints
    r.push()


def test_gains_can_be_set_while_it_moves_joint_waits_for_rest_and_nonsense_is_refused(rig, peer):
    from rclpy.parameter import Parameter
    from rclpy.parameter_client import AsyncParameterClient

    wishes = peer.hear(topics.TIP_TWIST_COMMAND)
    r = rig("-p", "scheme:=joint", "-p", "joint_rates:=[1, 1, 1]").hold_the_deadman()
    client = AsyncParameterClient(peer.node, "controller")
    peer.until(client.services_are_ready)

    def answer(name, value):
        future = client.set_parameters([Parameter(name, value=value)])
        peer.until(future.done)
        return future.result().results[0]

    assert not wishes
    before = len(r.commands)
    assert answer("scheme", "coordinated").successful
    peer.until(lambda: len(r.commands) > before + 50 and r.moving())
    stood = any(volts(message) == (0.0, 0.0, 0.0) for message in r.commands[before:])
    # Until nothing moves a lever goes on to move a joint; a busy computer's late state stops it, too.
    assert stood or not wishes
    assert answer("tip_speed", 1).successful  # a whole number, as people type it
    assert answer("feedback_gain", [3.0, 4.0, 4.0]).successful
    assert answer("profile", "operator").successful
    told = client.get_parameters(["tip_speed", "axis_frame"])
    peer.until(told.done)
    assert [value.double_value for value in told.result().values] == [0.8, 0.0]
    assert told.result().values[1].string_value == "cylindrical"
    refused = {
        ("scheme", "telepathy"): "allowed: one of joint, ik_velocity",
        ("joint_rates", (1.0, 2.0, 30.0)): "allowed: 0.01 .. 3 rad/s",
        ("lead_time", (0.1, 0.1)): "allowed: 3 numbers",
        ("profile", "nobody"): "profile 'nobody': neither shipped",
        ("workspace", "c180"): "the crane is driven; allowed: with the deadman released",
    }
    for (name, value), said in refused.items():
        found = answer(name, value)
        assert not found.successful
        assert said in found.reason
    r.joy_timer.cancel()
    peer.until(lambda: r.standing() and not is_armed(r.statuses[-1]))
    peer.until(lambda: wishes)
    assert answer("workspace", "c180").successful
    assert r.process.poll() is None


def test_a_lever_that_jumps_between_two_samples_does_not_make_the_command_jump(peer, start_node):
    # Slow: samples that a busy machine lets come in one controller period are taken as they are.
    rig = Rig(peer, start_node, "-p", "scheme:=joint").hold_the_deadman(20.0)
    peer.until(lambda: len({volts(m)[0] for m in rig.commands[-20:]}) == 1 and rig.moving())
    reached = volts(rig.commands[-1])[0]
    assert any(0.1 * reached < volts(m)[0] < 0.9 * reached for m in rig.commands)


def test_hands_off_it_commands_nothing_and_is_disarmed_but_nobody_takes_the_crane_from_who_drives_it(
    rig, peer
):
    from rclpy.parameter import Parameter
    from rclpy.parameter_client import AsyncParameterClient

    r = rig("-p", "scheme:=joint").hold_the_deadman()
    client = AsyncParameterClient(peer.node, "controller")
    peer.until(client.services_are_ready)

    def hands_off(wanted):
        future = client.set_parameters([Parameter("hands_off", value=wanted)])
        peer.until(future.done)
        return future.result().results[0]

    def refused():  # a stall of the computer disarms, and then it may be taken
        answer = hands_off(True)
        if answer.successful:
            hands_off(False)
            r.push()
        return answer.reason == "the deadman is held"

    peer.until(refused)
    r.joy = lambda: joy((0.0, 0.0, 0.0), held=False)
    peer.until(lambda: not is_armed(r.statuses[-1]) and r.standing())
    assert hands_off(True).successful
    r.joy = lambda: joy() if len(r.statuses) % 2 else centred()  # whatever it is that would arm
    seen = len(r.statuses)
    peer.until(lambda: len(r.statuses) > seen + 40)  # what was on its way has come
    said = len(r.commands)
    peer.until(lambda: len(r.statuses) > seen + 80)
    assert len(r.commands) == said
    assert not any(is_armed(status) for status in r.statuses[seen:])
    assert hands_off(False).successful
    r.push()
