"""Claims about the valve driver as a process: valves follow fresh, finite commands, else they are centred."""

import itertools
import math
import signal
import time

import numpy as np
import pytest
from stall import Stall

pytest.importorskip("rclpy")

from std_srvs.srv import Trigger

from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_control.valve.load_estimate import Pressures
from forest_control.valve.valve_driver_parameters import Settings
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state, read_float_array, sensor_array

COMMAND = (2.0, -3.0, 0.5)
ZERO = (0.0, 0.0, 0.0)
# A driver that follows the load fast, and forgets it only if we are held up for long: it would begin again.
LOADED = ("-p", "load_bandwidth:=50.0", "-p", "command_timeout:=0.2", "-p", "pressure_timeout:=0.5")
STALLED = 0.25  # [s] less than the driver bears
MARGIN = 0.5  # [s] for a busy machine, beside the timeouts


def command(now, values=COMMAND):
    return float_array(topics.VALVE_COMMANDS, now, values)


def typed(*values, offset=0):
    """A message as somebody types it: no stamp, no labels."""
    message = topics.message_class(topics.VALVE_COMMANDS)(data=list(map(float, values)))
    message.layout.data_offset = offset
    return message


def volts(message):
    reading = read_float_array(topics.VALVE_VOLTAGES, message, 0)
    assert reading.problem == ""
    return reading.values


def stamp(message):
    return read_float_array(topics.VALVE_VOLTAGES, message, 0).stamp_ns


def compensated(measured=load_estimate.UNSEEN, values=COMMAND, **settings):
    p = valve_driver_parameters.parameters(
        load_machine("c180_hoses"), Settings(**{"beyond_valve": False, **settings})
    )
    return valve_driver.step(valve_driver.REST, values, measured, load_estimate.STILL, p, 0.005)[1]


class Rig:
    """A valve driver and somebody who commands it; what is said can be changed at any time.

    It knows the valve alone: its answer to a held command is then one voltage from the first on.
    """

    def __init__(self, peer, start_node, *ros_args):
        self.peer = peer
        self.process = start_node("valve_driver_node", "-p", "beyond_valve:=false", *ros_args)
        self.voltages = peer.hear(topics.VALVE_VOLTAGES)
        self.command, self.said, self.answered = command, [], False  # ns, when it was

    def drive(self):
        self.timer = self.peer.repeat(topics.VALVE_COMMANDS, self.say, 200.0)
        self.peer.until(self.moving)
        return self

    def say(self, now):
        """Say zero first, and after a stall of ours, as a controller does: the driver waits for that."""
        stalled = bool(self.said) and (now - self.said[-1]) * 1e-9 > STALLED
        self.answered = self.answered or any(stamp(message) in self.said for message in self.voltages)
        self.said.append(now)
        return self.command(now) if self.answered and not stalled else command(now, ZERO)

    def at(self, values):
        return self.voltages and volts(self.voltages[-1]) == pytest.approx(values, rel=1e-6)

    def moving(self):
        return self.voltages and volts(self.voltages[-1]) != ZERO

    def standing(self, count=5):
        return len(self.voltages) >= count and all(volts(m) == ZERO for m in self.voltages[-count:])


@pytest.fixture
def rig(peer, start_node):
    def start(*ros_args):
        return Rig(peer, start_node, *ros_args)

    return start


REFUSED = {
    "hold_zone:=1.5": "parameter 'hold_zone' is 1.5; allowed: 0 .. 1 V",
    "machine:=c181": "c181",
}


def test_a_bad_parameter_ends_the_node_with_one_line(domain_id, start_node):
    processes = {said: start_node("valve_driver_node", "-p", given) for given, said in REFUSED.items()}
    for said, process in processes.items():
        assert process.ended() == 2
        assert process.text().count("\n") == 1
        assert said in process.text()


def test_before_the_first_command_the_valves_are_centred(rig, peer):
    r = rig()
    peer.until(lambda: r.standing(10))
    assert all(volts(message) == ZERO for message in r.voltages)
    assert "no command" not in r.process.text()


def test_commands_become_compensated_voltages_with_the_same_stamp(rig, peer):
    r, stamps = rig(), set()

    def stamped(now):
        stamps.add(now)
        return command(now)

    r.command = stamped
    r.drive()
    assert volts(r.voltages[-1]) == pytest.approx(compensated(), rel=1e-12)
    assert stamp(r.voltages[-1]) in stamps


def test_measured_pressures_change_the_voltage_and_their_loss_brings_the_nominal_drop_back(rig, peer):
    r = rig(*LOADED).drive()
    chambers = {"boom_1_actuator": 9e6, "boom_2_actuator": 2e6}
    values = [chambers.get(label, 0.0) for label in topics.PRESSURES.labels]
    ports = peer.repeat(topics.PRESSURES, lambda now: float_array(topics.PRESSURES, now, values))
    supply = peer.repeat(topics.SUPPLY, lambda now: float_array(topics.SUPPLY, now, (18e6, 1e-3, 0.2)))
    expected = compensated(Pressures((0.0, 9e6, 0.0), (0.0, 2e6, 0.0), 18e6))
    assert expected[1] != pytest.approx(compensated()[1], rel=1e-2)
    peer.until(lambda: r.at(expected))
    ports.cancel()
    supply.cancel()
    peer.until(lambda: r.at(compensated()))


def test_one_transducer_gone_brings_the_nominal_drop_back_and_the_supplys_the_nominal_supply(rig, peer):
    r = rig(*LOADED).drive()
    chambers = {"boom_1_actuator": 9e6, "boom_2_actuator": 2e6}
    values = [chambers.get(label, 0.0) for label in topics.PRESSURES.labels]
    gone = set()

    def pressures(now):
        told = [
            math.nan if label in gone else v for label, v in zip(topics.PRESSURES.labels, values, strict=True)
        ]
        return sensor_array(topics.PRESSURES, now, told)

    peer.repeat(topics.PRESSURES, pressures)
    peer.repeat(topics.SUPPLY, lambda now: sensor_array(topics.SUPPLY, now, (math.nan, 1e-3, 0.2)))
    nominal = load_machine("c180_hoses").pump.supply_pressure
    loaded = compensated(Pressures((0.0, 9e6, 0.0), (0.0, 2e6, 0.0), nominal))
    assert loaded[1] != pytest.approx(compensated()[1], rel=1e-2)
    peer.until(lambda: r.at(loaded))
    gone.add("stick_2_actuator")
    peer.until(lambda: r.at(compensated()))


def test_without_compensation_commands_pass(rig, peer):
    r = rig("-p", "compensate:=false").drive()
    assert volts(r.voltages[-1]) == COMMAND


def test_when_commands_stop_the_voltages_go_to_zero_in_time(rig, peer):
    r = rig("-p", "command_timeout:=0.05").drive()
    r.timer.cancel()
    assert peer.reaction(r.standing, r.process) < 0.05 + MARGIN
    assert "valves centred: no command" in r.process.text()
    r.timer.reset()
    peer.until(r.moving)


def test_a_bad_command_centres_the_valves_and_the_node_lives(rig, peer):
    r = rig().drive()
    for bad in (
        lambda now: command(now, (2.0, math.nan, 0.5)),
        lambda now: command(now, (math.inf, 0.0, 0.0)),
        lambda now: typed(1.0, 2.0),
        lambda now: typed(),
        lambda now: typed(1.0, offset=2),
        lambda now: typed(1.0, 2.0, 3.0, offset=7),
    ):
        r.command = bad
        peer.until(r.standing)
        r.command = command
        peer.until(r.moving)
    assert r.process.poll() is None


def test_an_array_typed_by_hand_is_accepted(rig, peer):
    r = rig()
    r.command = lambda now: typed(*COMMAND)
    before = peer.node.get_clock().now().nanoseconds
    r.drive()
    assert volts(r.voltages[-1]) == pytest.approx(compensated(), rel=1e-12)
    assert stamp(r.voltages[-1]) >= before


def test_a_shadow_publishes_no_voltage(rig, peer):
    r = rig("-p", "shadow:=true")
    speaker = peer.speak(topics.VALVE_COMMANDS)

    def complained():
        for message in (typed(math.nan), command(0), typed(1.0, 2.0)):
            speaker.publish(message)
        return "valves centred" in r.process.text()  # so it works on what comes

    peer.until(complained)
    assert peer.node.count_publishers(topics.VALVE_VOLTAGES.name) == 0
    assert r.process.stop() == 0
    assert not r.voltages


def test_namespace_remaps_and_plain_arrays_work(peer, start_node):
    heard, elsewhere = peer.hear(topics.VALVE_VOLTAGES, "/crane1/amplifier"), peer.hear(topics.VALVE_VOLTAGES)
    options = ("-r", "__ns:=/crane1", "-r", "valve_commands:=x", "-r", "valve_voltages:=amplifier")
    start_node("valve_driver_node", *options, "-p", "plain_arrays:=true", "-p", "beyond_valve:=false")
    speaker, stamps = peer.speak(topics.VALVE_COMMANDS, "/crane1/x"), itertools.count(1)

    def answered():
        speaker.publish(command(0, ZERO))
        speaker.publish(command(next(stamps)))
        return heard and heard[-1].data[0] != 0.0

    peer.until(answered)
    assert heard[-1].layout.data_offset == 0
    assert list(heard[-1].data) == pytest.approx(compensated(), rel=1e-12)
    assert not elsewhere


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_asked_to_stop_its_last_words_are_zero(rig, peer, number):
    r = rig().drive()
    r.process.send_signal(number)
    peer.until(lambda: r.process.poll() is not None)
    assert r.process.returncode == 0
    peer.until(lambda: volts(r.voltages[-1]) == ZERO)
    assert "Traceback" not in r.process.text()


def test_its_watchdog_does_not_depend_on_anybodys_clock(rig, peer):
    """With use_sim_time and no /clock, ROS time stands still."""
    r = rig("-p", "use_sim_time:=true").drive()
    r.timer.cancel()
    assert peer.reaction(r.standing, r.process) < 0.1 + MARGIN


def test_a_driver_that_was_frozen_obeys_nothing_from_before(rig, peer):
    r = rig().drive()
    r.process.send_signal(signal.SIGSTOP)
    frozen = time.monotonic()
    peer.until(lambda: time.monotonic() - frozen > 0.3)  # commands pile up
    r.timer.cancel()
    ended = time.monotonic()
    peer.until(lambda: time.monotonic() - ended > 0.5)
    r.voltages.clear()
    r.process.send_signal(signal.SIGCONT)
    peer.until(lambda: r.standing(10))
    # One at most: the command that it was working on when it froze had been fresh.
    assert sum(volts(message) != ZERO for message in r.voltages) <= 1


def test_an_emergency_stop_centres_the_valves_whatever_the_controller_does(rig, peer):
    r, said = rig().drive(), peer.hear(topics.DIAGNOSTICS)
    none = [0.0] * len(topics.PRESSURES.labels)
    peer.repeat(topics.PRESSURES, lambda now: float_array(topics.PRESSURES, now, none))
    stop, reset = (
        peer.node.create_client(Trigger, f"valve_driver/{verb}emergency_stop") for verb in ("", "reset_")
    )
    peer.until(lambda: stop.service_is_ready() and reset.service_is_ready())
    assert answer(peer, stop).success
    stall = Stall(r.process.pid)
    while (refusal := answer(peer, reset)).success:
        # Right only if this machine stood still so long that the commands had grown old.
        assert max(np.diff(r.said[-100:])) + stall.seconds() > 0.1
        assert answer(peer, stop).success
    assert "release the deadman" in refusal.message
    peer.until(r.standing)
    heard = len(r.voltages)
    peer.until(lambda: len(r.voltages) > heard + 20)
    assert all(volts(message) == ZERO for message in r.voltages[heard:])
    stopped = "valve_driver: emergency stop", "emergency stop pressed"
    peer.until(lambda: any(stopped == (s.name, s.message) for m in said for s in m.status))
    said.clear()
    peer.until(lambda: len(said) > 1)
    told = {s.message for m in said for s in m.status if s.name == "valve_driver: pressures"}
    assert not any("waiting for pressures" in one for one in told), told
    r.command = lambda now: command(now, ZERO)
    peer.until(lambda: answer(peer, reset).success)
    r.command = command
    peer.until(r.moving)


def test_a_second_commander_stops_the_valves_until_it_is_gone_and_the_stop_is_reset(
    rig, peer, start_process, tmp_path
):
    r, said = rig().drive(), peer.hear(topics.DIAGNOSTICS)
    reset = peer.node.create_client(Trigger, "valve_driver/reset_emergency_stop")
    peer.until(reset.service_is_ready)
    (tmp_path / "volts.csv").write_text("time,swing,boom,stick\n0,-4,4,4\n60,0,0,0\n")
    other = start_process(
        ["-m", "forest_sim.commander_node", "--ros-args", "-p", f"input:={tmp_path}/volts.csv"]
    )
    named = "emergency stop pressed; more than one node publishes valve_commands: commander, peer"
    peer.until(lambda: any(s.message == named for m in said for s in m.status))
    peer.until(lambda: volts(r.voltages[-1]) == ZERO)
    moved = [volts(message)[0] < 0.0 for message in r.voltages if volts(message) != ZERO]
    assert not any(moved) or all(moved[moved.index(True) :])  # nothing of ours came after its first one
    refusal = answer(peer, reset)
    assert not refusal.success
    assert "more than one node publishes valve_commands" in refusal.message
    other.stop()
    peer.until(lambda: "commander" not in peer.node.get_node_names())
    r.command = lambda now: command(now, ZERO)
    peer.until(lambda: answer(peer, reset).success)
    assert all(volts(message) == ZERO for message in r.voltages[-10:])
    r.command = command
    peer.until(r.moving)


def answer(peer, client):
    future = client.call_async(Trigger.Request())
    peer.until(future.done)
    return future.result()


def test_commands_from_the_past_move_nothing_but_a_zero_is_obeyed(rig, peer):
    r = rig("-p", "command_timeout:=0.2").drive()
    past = peer.node.get_clock().now().nanoseconds - 1_000_000_000
    r.command = lambda now: command(past, ZERO)
    assert peer.reaction(r.standing, r.process) < MARGIN
    r.command = command
    peer.until(r.moving)
    r.command = lambda now: command(past)
    assert peer.reaction(r.standing, r.process) < 0.2 + MARGIN
    peer.until(lambda: "valve_commands: the stamp goes back" in r.process.text())


def test_it_tells_what_it_knows_of_its_valves(rig, peer):
    heard = peer.hear(topics.VALVE_DRIVER_STATUS)
    r = rig("-p", "adapt:=true")
    r.command = lambda now: command(now, (0.0, 10.0, 0.0))
    r.drive()

    def told():
        reading = read_float_array(topics.VALVE_DRIVER_STATUS, heard[-1], 0)
        assert reading.problem == ""
        return dict(zip(topics.VALVE_DRIVER_STATUS.labels, reading.values, strict=True))

    peer.until(lambda: heard and told()["boom_saturated"] == 1.0)
    known = told()
    assert known["swing_saturated"] == 0.0
    assert known["stick_backward_deadband"] == load_machine("c180_hoses").valve.deadband_voltage
    assert known["boom_forward_gain"] == 1.0
    assert known["boom_forward_deadband_spread"] > 0.0


def test_motion_that_its_file_does_not_explain_changes_what_it_knows(rig, peer):
    heard = peer.hear(topics.VALVE_DRIVER_STATUS)
    r = rig("-p", "adapt:=true", "-p", "command_timeout:=0.2", "-p", "pressure_timeout:=1.0")
    r.command = lambda now: command(now, (0.0, 3.0, 0.0))
    start = time.monotonic()

    def moving(now):
        positions = (0.0, 2.0 + 0.1 * (time.monotonic() - start), 2.0)
        return joint_state(topics.ACTUATORS, now, positions, ZERO, ZERO)

    ports = [6e6] * len(topics.PRESSURES.labels)
    said = [
        peer.repeat(topics.PRESSURES, lambda now: float_array(topics.PRESSURES, now, ports)),
        peer.repeat(topics.SUPPLY, lambda now: float_array(topics.SUPPLY, now, (20e6, 1e-3, 0.2))),
        peer.repeat(topics.ACTUATOR_STATES, moving),
    ]
    r.drive()
    place = topics.VALVE_DRIVER_STATUS.labels.index("boom_forward_gain")
    peer.until(lambda: heard and heard[-1].data[2 + place] > 1.1)
    for timer in said:
        timer.cancel()


def test_its_settings_can_be_changed_while_it_works_and_nonsense_is_refused(rig, peer):
    from rclpy.parameter import Parameter
    from rclpy.parameter_client import AsyncParameterClient

    r = rig().drive()
    client = AsyncParameterClient(peer.node, "valve_driver")
    peer.until(client.services_are_ready)

    def answer(name, value):
        future = client.set_parameters([Parameter(name, value=value)])
        peer.until(future.done)
        return future.result().results[0]

    assert answer("compensate", False).successful
    peer.until(lambda: r.at(COMMAND))
    refused = answer("hold_zone", 1.5)
    assert not refused.successful
    assert "Max: 1.0" in refused.reason
    assert answer("compensate", True).successful
    peer.until(lambda: r.at(compensated()))


def test_a_command_beyond_the_rating_is_obeyed_as_far_as_it_goes_and_said(rig, peer):
    heard, r = peer.hear(topics.DIAGNOSTICS), rig("-p", "compensate:=false")
    r.command = lambda now: command(now, (15.0, 0.0, 0.0))
    r.drive()
    clipped = "valve_commands: swing is 15 V, clipped to its rating of 10 V"
    peer.until(lambda: clipped in {status.message for message in heard for status in message.status})
    assert max(volts(message)[0] for message in r.voltages) == 10.0
    assert f"[valve_driver]: {clipped}" in r.process.text()
    told = {pair.key: pair.value for status in heard[-1].status for pair in status.values}
    assert int(told["clipped since start"]) > 0
    assert told["swing rating [V]"] == "10"
