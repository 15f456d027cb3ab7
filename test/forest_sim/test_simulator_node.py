"""Claims about the simulator process: it keeps the time, moves when told, and stands still otherwise."""

import math
import signal
import time
import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np
import pytest
from stall import Stall

pytest.importorskip("rclpy")

from std_srvs.srv import Trigger

from forest_description.derived.limits import start_tip
from forest_description.geometry.kinematics import tip_orientation
from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, read_float_array, stamp_to_ns
from forest_sim.sensors.sensor_suite import CHANNELS, sensor_suite

MACHINE = load_machine()
PERIOD_NS = 5_000_000
CATCH_UP = 20  # periods that a late machine still makes up for
MARGIN = 0.5  # [s] for a busy machine, beside the timeouts
VOLTS = (4.0, -4.0, 4.0)
ZERO = (0.0, 0.0, 0.0)
PLAY = 0.5 * MACHINE.valve.hysteresis + 0.01  # [V] a spool stops short of its voltage by so much
STREAMS = [
    t for t in topics.TOPICS if "simulator" in t.publishers and t.rate_hz == 200.0 and t != topics.CLOCK
]


def voltages(now, values=VOLTS):
    return float_array(topics.VALVE_VOLTAGES, now, values)


def typed(*values, offset=0):
    """A message as somebody types it: no stamp, no labels."""
    message = topics.message_class(topics.VALVE_VOLTAGES)(data=list(map(float, values)))
    message.layout.data_offset = offset
    return message


def stamp(topic, message):
    if topic.type == topics.FLOAT_ARRAY:
        reading = read_float_array(topic, message, 0)
        assert reading.problem == ""
        return reading.stamp_ns
    return stamp_to_ns(message.header.stamp)


class Rig:
    """A simulator and somebody who drives its valves; what is said can be changed at any time."""

    def __init__(self, peer, start_simulator, *ros_args):
        self.peer = peer
        self.process = start_simulator(*ros_args)
        self.auxiliary = peer.hear(topics.AUXILIARY)
        self.truth = peer.hear(topics.GROUND_TRUTH_JOINT_STATES)
        self.say, self.said = voltages, 0.0

    def drive(self):
        def speak(now):
            self.said = time.monotonic()
            return self.say(now)

        self.timer = self.peer.repeat(topics.VALVE_VOLTAGES, speak, 200.0)
        self.peer.until(self.open)
        return self

    def spools(self):
        if not self.auxiliary:
            return ZERO
        values = read_float_array(topics.AUXILIARY, self.auxiliary[-1], 0).values
        return values[:3]

    def open(self):
        return self.spools() == pytest.approx(VOLTS, abs=PLAY)

    def centred(self):
        return self.spools() == pytest.approx(ZERO, abs=PLAY)


@pytest.fixture
def rig(peer, start_simulator):
    def start(*ros_args):
        return Rig(peer, start_simulator, *ros_args)

    return start


def call(peer, action):
    """What the simulator answers to a Trigger service of its own."""
    client = peer.node.create_client(Trigger, f"/simulator/{action}")
    peer.until(client.service_is_ready)
    future = client.call_async(Trigger.Request())
    peer.until(future.done)
    return future.result().success, future.result().message


def missed(message):
    return read_float_array(topics.AUXILIARY, message, 0).values[-1]


def test_every_sensor_speaks_200_times_a_second_with_stamps_5_ms_apart(peer, start_simulator):
    heard = {topic: peer.hear(topic) for topic in STREAMS}
    stall = Stall(start_simulator().pid)
    peer.until(lambda: all(heard.values()))
    first = len(heard[topics.AUXILIARY])
    elapsed = peer.until(lambda: all(len(messages) >= first + 240 for messages in heard.values()))
    assert elapsed == pytest.approx(240 * 5e-3, rel=0.25, abs=stall.seconds())
    late = [missed(message) for message in heard[topics.AUXILIARY]]
    for topic, messages in heard.items():
        stamps = [stamp(topic, message) for message in messages]
        steps = [after - before for before, after in pairwise(stamps)]
        assert all(step > 0 and step % PERIOD_NS == 0 for step in steps)
        if late[-1] - late[0] < CATCH_UP:  # a machine that was never that late leaves nothing out
            assert set(steps) == {PERIOD_NS}, topic.name
        assert abs(stamps[-1] - peer.node.get_clock().now().nanoseconds) < (MARGIN + stall.seconds()) * 1e9


def test_all_topics_of_a_sample_carry_the_same_stamp(peer, start_simulator):
    heard = {topic: peer.hear(topic) for topic in STREAMS}
    start_simulator()

    def recent():
        return [[stamp(topic, m) for m in messages[-100:]] for topic, messages in heard.items()]

    def span(stamps):
        return max(map(min, stamps)), min(map(max, stamps))

    def comparable(stamps):  # a machine that stands still for a second loses what nobody reads
        if min(map(len, stamps)) < 100 or np.ptp([np.diff(each) for each in stamps]) > 0:
            return False
        first, last = span(stamps)
        return last - first >= 10 * PERIOD_NS

    peer.until(lambda: comparable(recent()))
    stamps = recent()
    first, last = span(stamps)
    assert len({frozenset(s for s in each if first <= s <= last) for each in stamps}) == 1


def test_who_comes_late_still_gets_the_robot_description(rig, peer):
    r = rig()
    peer.until(lambda: len(r.truth) > 20)
    descriptions = peer.hear(topics.ROBOT_DESCRIPTION)
    peer.until(lambda: descriptions)
    assert ET.fromstring(descriptions[0].data).tag == "robot"
    assert descriptions[0].data == robot_description(MACHINE)


def test_it_starts_at_rest_with_the_tip_where_asked(peer, start_simulator):
    poses, truth = peer.hear(topics.GROUND_TRUTH_TIP_POSE), peer.hear(topics.GROUND_TRUTH_JOINT_STATES)
    start_simulator("-p", "initial_tip:=[5.0, -1.0, 0.5]")
    peer.until(lambda: len(poses) > 20 and len(truth) > 20)
    point = poses[-1].pose.position
    assert (point.x, point.y, point.z) == pytest.approx((5.0, -1.0, 0.5), abs=1e-6)
    turn, angles = poses[-1].pose.orientation, truth[-1].position
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx(tip_orientation(angles), abs=1e-6)
    assert list(truth[-1].velocity) == pytest.approx([0.0] * 3, abs=1e-6)


def test_another_machine_starts_where_it_can_be(peer, start_simulator):
    poses, loader = peer.hear(topics.GROUND_TRUTH_TIP_POSE), load_machine("loader")
    start_simulator("-p", "machine:=loader")
    peer.until(lambda: len(poses) > 20)
    point = poses[-1].pose.position
    assert (point.x, point.y, point.z) == pytest.approx(start_tip(loader), abs=1e-4)


def test_voltages_move_every_joint_in_the_direction_of_their_sign(rig, peer):
    r = rig()
    peer.until(lambda: r.truth)
    start = list(r.truth[0].position)
    r.drive()
    signs = [math.copysign(1.0, v) for v in VOLTS]

    def moved():
        now = r.truth[-1].position
        return all(s * (b - a) > 0.01 for s, a, b in zip(signs, start, now, strict=True))

    peer.until(moved)


def test_without_voltages_nothing_moves_until_a_log_is_grasped_and_it_springs_back_when_that_is_dropped(
    rig, peer
):
    r, loads = rig("-p", "log_mass:=800.0", "-p", "machine:=c180_hoses"), peer.hear(topics.GROUND_TRUTH_LOAD)
    peer.until(lambda: len(r.truth) > 100)
    assert list(r.truth[-1].position) == pytest.approx(list(r.truth[0].position), abs=1e-9)
    assert r.centred()
    rest = r.truth[0].position[1]
    assert call(peer, "drop") == (False, "the head holds no log; grasp one first")
    assert call(peer, "grasp") == (True, "holds a log of 800 kg, 4 m long")
    peer.until(lambda: r.truth[-1].position[1] < rest - 4e-4 and list(loads[-1].data[2:]) == [800.0, 4.0])
    assert call(peer, "grasp") == (False, "the head holds a log of 800 kg already; drop it first")
    assert call(peer, "drop") == (True, "dropped a log of 800 kg")
    peer.until(lambda: r.truth[-1].position[1] > rest - 2.5e-4 and loads[-1].data[2] == 0.0)


def test_when_voltages_stop_the_spools_centre_within_the_timeout_and_not_before(rig, peer):
    r = rig().drive()
    r.timer.cancel()
    after = peer.reaction(r.centred, r.process)
    assert time.monotonic() - r.said > 0.9 * MACHINE.command_timeout
    lag = math.log(max(map(abs, VOLTS)) / 0.01) / (2.0 * math.pi * MACHINE.valve.spool_bandwidth)
    assert after < MACHINE.command_timeout + lag + MARGIN
    r.timer.reset()
    peer.until(r.open)


def test_bad_voltages_centre_the_valves_and_the_node_lives(rig, peer):
    r = rig().drive()
    for bad in (
        lambda now: voltages(now, (4.0, math.nan, 4.0)),
        lambda now: voltages(now, (math.inf, 0.0, 0.0)),
        lambda now: typed(4.0, 4.0),
        lambda now: typed(4.0, 4.0, 4.0, 4.0),
        lambda now: typed(),
        lambda now: typed(4.0, offset=2),
        lambda now: typed(4.0, 4.0, 4.0, offset=7),
    ):
        r.say = bad
        peer.until(r.centred)
        r.say = voltages
        peer.until(r.open)
    assert r.process.poll() is None
    assert "valves centred: valve_voltages" in r.process.text()


def test_two_who_send_voltages_centre_the_valves_until_one_is_gone_and_the_stop_is_reset(
    rig, peer, start_process
):
    r, said = rig().drive(), peer.hear(topics.DIAGNOSTICS)
    driver = start_process(["-m", "forest_control.valve_driver_node"])  # it sends zeros
    peer.until(r.centred)
    named = "emergency stop pressed; more than one node publishes valve_voltages: peer, valve_driver"
    stopped = "simulator: emergency stop", named
    peer.until(lambda: any(stopped == (s.name, s.message) for m in said for s in m.status))
    success, message = call(peer, "reset_emergency_stop")
    assert not success
    assert "more than one node publishes valve_voltages" in message
    driver.stop()
    peer.until(lambda: call(peer, "reset_emergency_stop")[0])
    peer.until(r.open)


REFUSED = {
    "initial_tip:=[50.0, 0.0, 1.0]": "parameter 'initial_tip' is [50.0, 0.0, 1.0]: tip position",
    "initial_tip:=[3.0, 0.0, 1.0]": "it needs the boom at 91.6 deg; allowed: -36.7 .. 72.0 deg",
    "seed:=-1": "parameter 'seed' is -1; allowed: 0 .. ",
    'loads:="500 kg at 2 s"': "parameter 'loads': '500 kg at 2 s' is no load; allowed: MASS kg from TIME s",
    'sensor_faults:="boom_spool: melted"': "'melted' is no fault; allowed: absent; frozen; bias NUMBER UNIT",
    "machine:=loader -p initial_tip:=[5.5, 0.0, 1.0]": "the reach from there is 0.2 .. 4.3 m",
    "machine:=absent.yaml": "absent.yaml",
}


def arguments(given):
    """ROS arguments of one or more parameters."""
    return [part for each in given.split(" -p ") for part in ("-p", each)]


def test_a_bad_parameter_ends_the_node_with_one_line(domain_id, start_simulator):
    processes = {said: start_simulator(*arguments(given)) for given, said in REFUSED.items()}
    for said, process in processes.items():
        assert process.ended() == 2, process.text()
        assert process.text().count("\n") == 1, process.text()
        assert said in process.text()


def test_namespace_plain_arrays_and_arrays_typed_by_hand_work(peer, start_simulator):
    spools = peer.hear(topics.AUXILIARY, "/crane1/hydraulics/auxiliary")
    elsewhere = peer.hear(topics.AUXILIARY)
    start_simulator("-r", "__ns:=/crane1", "-p", "plain_arrays:=true")
    speaker = peer.speak(topics.VALVE_VOLTAGES, "/crane1/valve_voltages")

    def answered():
        speaker.publish(typed(*VOLTS))
        return spools and list(spools[-1].data[:3]) == pytest.approx(VOLTS, abs=PLAY)

    peer.until(answered)
    assert spools[-1].layout.data_offset == 0
    assert len(spools[-1].data) == len(topics.AUXILIARY.labels)
    assert not elsewhere


def labels(message):
    return tuple(message.layout.dim[0].label.split(","))


def test_absent_sensors_are_missing_from_names_and_labels_and_a_topic_without_any_is_silent(
    peer, start_simulator
):
    heard = {topic: peer.hear(topic) for topic in STREAMS}
    gone = "boom_resolver: absent; stick_pressure_1_valve: absent; swing_flow: absent; stick_flow: absent"
    start_simulator("-p", f'sensor_faults:="{gone}"')
    peer.until(lambda: all(len(heard[topic]) > 20 for topic in STREAMS if topic is not topics.FLOWS))
    state, actuators = heard[topics.JOINT_STATES][-1], heard[topics.ACTUATOR_STATES][-1]
    assert list(state.name) == ["swing", "stick"]
    assert len(state.position) == len(state.velocity) == len(state.effort) == 2
    assert tuple(actuators.name) == topics.ACTUATORS
    assert set(topics.PRESSURES.labels) - set(labels(heard[topics.PRESSURES][-1])) == {"stick_1_valve"}
    assert labels(heard[topics.AUXILIARY][-1]) == topics.AUXILIARY.labels
    assert not heard[topics.FLOWS]


def test_a_kind_of_sensor_that_the_machine_lacks_has_no_label(peer, start_simulator):
    heard = peer.hear(topics.AUXILIARY)
    start_simulator("-p", "machine:=c180_thesis")
    peer.until(lambda: heard)
    assert set(topics.AUXILIARY.labels) - set(labels(heard[-1])) == {"case_drain_flow"}


def test_sensor_noise_and_seed_choose_the_units_and_a_dropped_sample_has_no_label(peer, start_simulator):
    flows, auxiliary = peer.hear(topics.FLOWS), peer.hear(topics.AUXILIARY)
    arguments = ("sensor_noise:=true", "seed:=5", 'sensor_faults:="engine_speed: drop 30 %"')
    start_simulator("-p", "machine:=c180_thesis", *(word for a in arguments for word in ("-p", a)))
    peer.until(lambda: len(auxiliary) > 100 and flows)
    suite = sensor_suite(load_machine("c180_thesis"), True, 5)
    bias = suite.channels[CHANNELS.index("tank_temperature")].bias
    reading = read_float_array(topics.AUXILIARY, auxiliary[-1], 0, ("tank_temperature",))
    assert reading.values[0] == pytest.approx(313.15 + bias, abs=1e-9)
    assert flows[-1].data[2] == pytest.approx(0.85 * 3.785411784e-3 / 60.0)  # the floor, the oil at rest
    lost = sum("engine_speed" not in labels(message) for message in auxiliary)
    assert 0.1 * len(auxiliary) < lost < 0.6 * len(auxiliary)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_asked_to_stop_it_ends_with_code_0_and_without_a_word(rig, peer, number):
    r = rig()
    peer.until(lambda: r.truth)
    assert r.process.stop(number) == 0
    assert r.process.text() == ""


def test_voltages_beyond_the_rating_and_their_absence_are_said(rig, peer):
    heard, r = peer.hear(topics.DIAGNOSTICS), rig()
    said = lambda: {status.message for message in heard for status in message.status}  # noqa: E731
    peer.until(lambda: "waiting for voltages on /valve_voltages" in said())
    clipped = "valve_voltages: swing is 40 V, clipped to its rating of 10 V"
    peer.repeat(topics.VALVE_VOLTAGES, lambda now: voltages(now, (40.0, 0.0, 0.0)), 200.0)
    peer.until(lambda: clipped in said())
    peer.until(lambda: clipped in r.process.text())
    told = {pair.key: pair.value for status in heard[-1].status for pair in status.values}
    assert told["machine"] == MACHINE.name
    assert float(told["command_timeout [s]"]) == MACHINE.command_timeout
    assert int(told["clipped since start"]) > 0
