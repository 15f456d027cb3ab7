"""A run of two nodes in lockstep: who is called when, what each reads of which step, and how it ends."""

import re
import threading
import time
from collections import defaultdict
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from rclpy.parameter import Parameter

from forest_msgs_py.clock import lockstep
from forest_msgs_py.clock.lockstep import END, LockstepClock
from forest_msgs_py.clock.step_batch import read_batch
from forest_msgs_py.clock.step_order import StepOrder
from forest_msgs_py.clock.step_topics import StepSubscription, lockstep_qos, steps_without_output
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, stamp_to_ns
from forest_msgs_py.runtime.node import NodeFailure
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.serialization.packing import pack_clock
from forest_msgs_py.serialization.unpacking import ArrayReader

STEPS, QUIET = 7, 3
MUTE, TOLD = 4, (2, 3, 6)  # steps in which the controller gives no answer, and in which it tells its status
DT = 0.005
DT_NS = 5_000_000


def array(topic, stamp, number):
    return to_cdr(float_array(topic, stamp, (float(number),) * len(topic.labels)))


def number(topic, arrival):
    return None if arrival is None else ArrayReader(topic).read(arrival[0], 0).values[0]


class Ear:
    """Hears what the nodes of a run tell each other."""

    def __init__(self, node):
        self.rolls, self.silence, self.idle, self.batches = (
            PolledSubscription(node, topics.message_class(topic), topic.name, lockstep_qos(), raw=raw)
            for topic, raw in (
                (topics.ANNOUNCEMENT, False),
                (topics.NO_OUTPUT, False),
                (topics.IDLE, False),
                (topics.STEP_BATCH, True),
            )
        )
        self.silent, self.quiet = [], []  # topics and steps
        self.batched = defaultdict(list)  # steps after which a batch begins and up to which it goes

    def has_heard_the_end(self):
        self.silent += [(h.frame_id, stamp_to_ns(h.stamp) // DT_NS) for h, _ in self.silence.take()]
        self.quiet += [
            (name, ns // DT_NS) for h, _ in self.idle.take() for name, ns in steps_without_output(h)
        ]
        return any(text == END for text, _ in self.silent)

    def said(self):
        """The steps in which something was said on each topic, by the nodes' batches."""
        order = StepOrder(("machine", "control"))
        for message, _ in self.rolls.take():
            order.add_announcement(message.data)
        for data, _ in self.batches.take():
            node, since, until, said = read_batch(data)
            order.add_batch(node, since, until, said)
            self.batched[node].append((since, until))
        assert order.lost == ""
        steps = defaultdict(list)
        for name, step, _ in order.complete():
            steps[name].append(step)
        return steps


def leader(node, calls):
    """A machine whose pressures are the number of its step, and which notes the voltages that it reads."""
    machine = LockstepClock(node, 5.0, leads=True, steps=STEPS, quiet=QUIET)
    pressures, voltages = (
        machine.publisher(topics.PRESSURES),
        machine.polled_subscription(topics.VALVE_VOLTAGES),
    )

    def act():
        calls["machine"].append((machine.stamp(), number(topics.VALVE_VOLTAGES, voltages.newest())))
        pressures.publish(array(topics.PRESSURES, machine.stamp(), round(machine.now() / DT)))
        pressures.publish(array(topics.PRESSURES, machine.stamp(), -1.0))  # the first counts

    pressures.publish(array(topics.PRESSURES, 0, 9.0))  # before its first step a node says nothing
    machine.every(0.0, act)
    return machine


def follower(node, calls):
    """A controller that answers but for step MUTE, tells its status in some steps, and has two timers."""
    control = LockstepClock(node, 5.0, quiet=QUIET)
    answer, status = control.publisher(topics.VALVE_VOLTAGES), control.publisher(topics.CONTROLLER_STATUS)

    def react(data, sent):
        k = number(topics.PRESSURES, (data,))
        calls["control"].append((control.now(), sent, k))
        if k != MUTE:
            answer.publish(array(topics.VALVE_VOLTAGES, control.stamp(), k))
        if k in TOLD:
            status.publish(array(topics.CONTROLLER_STATUS, control.stamp(), k))

    control.on(topics.PRESSURES, react)
    control.every(3 * DT, lambda: calls["each third"].append(control.stamp()))
    control.every(DT, lambda: calls["each"].append(control.stamp()))
    return control


def test_two_nodes_make_their_steps_in_turn_and_all_that_they_say_is_told(make_node, wait_until):
    ear, calls, logged = Ear(make_node("ear")), defaultdict(list), []
    clocks = [leader(make_node("machine"), calls), follower(make_node("control"), calls)]
    clocks[0]._node.get_logger = lambda: SimpleNamespace(info=logged.append)
    stopping, begun = threading.Event(), time.monotonic()
    threads = [threading.Thread(target=clock.run, args=(stopping,)) for clock in clocks]
    for thread in threads:
        thread.start()
    try:
        wait_until(ear.has_heard_the_end)
        clocks[0]._publishers[-1].publish(b"after its last step a node says nothing")
        threads[0].join(0.05)
        assert threads[0].is_alive()  # it stays, for whoever comes late, until it is told to go
    finally:
        stopping.set()
        for thread in threads:
            thread.join(10.0)
    ear.has_heard_the_end()
    steps = range(1, STEPS + 1)
    answers = [None, 1, 2, 3, None, 5, 6]  # those of the step before
    assert calls["machine"] == [(k * DT_NS, answers[k - 1]) for k in steps]
    assert calls["control"] == [pytest.approx((k * DT, k * DT, k)) for k in steps]
    assert calls["each third"] == [3 * DT_NS, 6 * DT_NS]
    assert calls["each"] == [k * DT_NS for k in steps]
    assert ("/valve_voltages", MUTE) in ear.silent
    assert [end for end in ear.silent if end[0] == END] == [(END, STEPS)]
    assert ear.quiet == [("/controller/status", k) for k in steps if k not in TOLD]
    assert ear.said() == {
        "/hydraulics/pressures": [*steps],
        "/clock": [*steps],
        "/valve_voltages": [k for k in steps if k != MUTE],
        "/controller/status": [*TOLD],
    }
    assert ear.batched == {node: [(0, 3), (3, 6), (6, 7), (7, 7)] for node in ("machine", "control")}
    (took,) = re.match(rf"{STEPS - 1} steps in (\S+) s: ", logged[0]).groups()
    assert 0.0 < float(took) < time.monotonic() - begun


def test_whoever_leads_stays_so_many_steps_before_the_recorder_and_no_more(make_node, monkeypatch):
    monkeypatch.setattr(lockstep, "extra_time", lambda *_: 0.0)
    recorder = make_node("recorder")
    taken = recorder.create_publisher(
        topics.message_class(topics.RECORDED), topics.RECORDED.name, lockstep_qos()
    )
    machine = LockstepClock(make_node("machine"), 0.2, leads=True, recorded=True)
    stopping = threading.Event()
    assert machine._wait_for_recorder(400, stopping)  # nothing is asked of it in the first steps
    with pytest.raises(NodeFailure, match=f"step {401}: waited 0.2 s for /lockstep/recorded"):
        machine._wait_for_recorder(401, stopping)
    taken.publish(pack_clock(DT_NS))
    assert machine._wait_for_recorder(401, stopping)
    stopping.set()
    assert not machine._wait_for_recorder(402, stopping)


def test_what_a_late_reader_waits_for_is_told_beside_what_all_wait_for(make_node):
    node = make_node("reader")
    clock = LockstepClock(node, 1.0)
    assert clock._batch_steps == 1  # unless asked otherwise
    assert len(clock._no_output_subscriptions) == 1
    for _ in range(2):  # once for all such topics
        clock.polled_subscription(topics.CONTROLLER_STATUS)
    assert [told.subscription.topic_name for told in clock._no_output_subscriptions] == [
        "/lockstep/silence",
        "/lockstep/quiet",
    ]
    last = clock.on(topics.JOY, lambda *_: None)
    assert clock._inputs[0] is last


def test_of_latched_and_stampless_topics_a_node_speaks_as_live(make_node):
    clock = LockstepClock(make_node("machine"), 1.0)
    for topic in (topics.ROBOT_DESCRIPTION, topics.EVENTS):
        clock.publisher(topic)
    clock.publisher(topics.PRESSURES)
    assert [made.name for made in clock._publishers] == ["/hydraulics/pressures"]
    assert clock._transient_local == ["/robot_description std_msgs/msg/String latched"]
    assert isinstance(clock.polled_subscription(topics.JOY), StepSubscription)


def test_a_node_waits_as_long_as_its_guard_says_and_in_the_first_step_for_20_s_at_least(
    make_node, monkeypatch
):
    monkeypatch.setattr(lockstep, "extra_time", lambda *_: 0.0)
    clock, patient = (LockstepClock(make_node(f"guard_{guard}"), guard) for guard in (2, 30))
    joy, stopping = clock.polled_subscription(topics.JOY), threading.Event()

    def waits(whose, step, seconds):
        try:
            return whose._wait(joy, step, time.monotonic() - seconds, stopping)
        except NodeFailure as failure:
            return str(failure).split(";")[0]

    begun = time.monotonic()
    assert waits(clock, 1, 18.0) is True
    assert time.monotonic() - begun > 0.09  # asleep
    assert waits(clock, 1, 20.5) == "step 1: waited 20 s for /joy of joystick"
    assert waits(clock, 2, 1.0) is True
    assert waits(clock, 2, 2.5) == "step 2: waited 2 s for /joy of joystick"
    assert waits(patient, 1, 28.0) is True
    assert waits(patient, 1, 30.5) == "step 1: waited 30 s for /joy of joystick"
    monkeypatch.setattr(lockstep, "extra_time", lambda *_: 3.0)
    assert waits(clock, 2, 4.0) is True
    assert waits(clock, 2, 5.5) == "step 2: waited 2 s for /joy of joystick"


def test_who_reads_nothing_follows_the_clock_and_nobody_takes_plain_arrays(make_node):
    node, stopping, logged = make_node("any"), threading.Event(), []
    clock = LockstepClock(node, 1.0)
    stopping.set()
    clock.run(stopping)
    assert [polled.name for polled in clock._inputs] == ["/clock"]
    node.get_logger = lambda: SimpleNamespace(info=logged.append)
    clock._log_speed(6, 0.015)
    assert logged == ["6 steps in 0.015 s: 2.00 times as fast as live"]
    node.declare_parameter("plain_arrays", True)
    with pytest.raises(NodeFailure, match="'plain_arrays' is true; allowed in lockstep: false"):
        clock.run(stopping)
    node.set_parameters([Parameter("plain_arrays", value=False)])
    clock.run(stopping)


def test_what_nobody_waits_for_is_told_once_in_so_many_steps_a_topic_in_each(make_node):
    clock, told = LockstepClock(make_node("machine"), 1.0, quiet=3), defaultdict(list)
    clock._publishers = [
        SimpleNamespace(
            published_step=0, name=name, awaited=name == "a", tell=lambda name=name: told[name].append(step)
        )
        for name in "abcd"
    ]
    clock._no_output = SimpleNamespace(publish=lambda _: told["silence"].append(step))
    clock._idle = SimpleNamespace(
        note=lambda at, names: told["idle"].append((at, names)), tell=lambda at: told["report"].append(at)
    )
    clock._batch = SimpleNamespace(tell=lambda at: told["batch"].append(at))
    for step in range(1, 8):
        clock._make(step)
    assert told == {
        "a": [3, 6],
        "b": [2, 5],
        "c": [1, 4, 7],
        "d": [3, 6],
        "silence": [*range(1, 8)],
        "idle": [(k, ["b", "c", "d"]) for k in range(1, 8)],
        "report": [3, 6],
        "batch": [3, 6],
    }
