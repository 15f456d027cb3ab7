"""Messages that waited: their age is told, whatever the queue, a frozen process or a clock did to them."""

import math
import time

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces.messages import float_array
from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import VALVE_VOLTAGES, message_class
from forest_msgs_py.runtime import polled_subscription as inbox_module
from forest_msgs_py.runtime.node import publisher
from forest_msgs_py.runtime.polled_subscription import (
    PolledSubscription,
    ReceivedCount,
    polled_subscription,
    sent_at,
)
from forest_msgs_py.serialization.unpacking import ArrayReader


def sent(seconds_ago):
    return {
        "source_timestamp": time.time_ns() - round(seconds_ago * 1e9),
        "received_timestamp": time.time_ns(),
    }


def volts(data):
    return ArrayReader(VALVE_VOLTAGES).read(data, 0).values[0]


@pytest.fixture
def standing_clocks(monkeypatch):
    """Time stands still: what is between two looks at a clock is the busy machine's."""
    monkeypatch.setattr("time.time_ns", lambda: 1_800_000_000_000_000_000)
    monkeypatch.setattr("time.monotonic", lambda: 1000.0)


@pytest.mark.usefixtures("standing_clocks")
def test_age_counts_from_publishing_not_from_receiving():
    assert time.monotonic() - sent_at(sent(5.0)) == pytest.approx(5.0, abs=1e-6)


@pytest.mark.usefixtures("standing_clocks")
def test_a_message_from_the_future_is_as_good_as_old():
    assert sent_at(sent(-3600.0)) == -math.inf
    assert time.monotonic() - sent_at(sent(-0.01)) == pytest.approx(-0.01, abs=1e-6)


@pytest.mark.usefixtures("standing_clocks")
def test_a_tally_counts_and_tells_for_how_long_the_newest_message_has_been_sent():
    received = ReceivedCount()
    assert (received.count, received.age()) == (0, math.inf)
    for count, age in ((1, 4.0), (2, 0.5), (3, 0.0)):
        received.note(sent(age))
        assert received.count == count
        assert received.age() == pytest.approx(age, abs=1e-6)


@pytest.mark.usefixtures("standing_clocks")
def test_a_tally_tells_the_shortest_way_since_it_was_asked_last():
    received = ReceivedCount()
    assert received.shortest_way() == math.inf
    for way in (0.02, -0.5, 3.0):  # the sender's clock may be ahead
        received.note(sent(way))
    assert received.shortest_way() == pytest.approx(-0.5, abs=1e-6)
    received.note(sent(3.0))
    assert received.shortest_way() == pytest.approx(3.0, abs=1e-6)
    received.heard = (heard := []).append
    received.note(sent(1.0))
    assert heard == [sent(1.0)]


def test_newest_message_comes_with_its_time_and_older_ones_are_gone(make_node, wait_until):
    node = make_node("both")
    box, sender = polled_subscription(node, VALVE_VOLTAGES), publisher(node, VALVE_VOLTAGES)
    wait_until(lambda: sender.get_subscription_count() == 1)
    assert box.newest() is None
    before = time.monotonic()
    for swing in (1.0, 2.0, 3.0):
        sender.publish(float_array(VALVE_VOLTAGES, 0, (swing, 0.0, 0.0)))
    taken = []

    def arrived():
        taken.extend(volts(data) for data, _ in box.take())
        return len(taken) == 3

    wait_until(arrived)
    assert taken == [1.0, 2.0, 3.0]
    assert box.count == 3
    assert 0.0 <= box.age() <= time.monotonic() - before + inbox_module.CLOCK_TOLERANCE
    sender.publish(float_array(VALVE_VOLTAGES, 0, (4.0, 0.0, 0.0)))
    newest = []
    wait_until(lambda: newest.append(box.newest()) or newest[-1] is not None)
    assert volts(newest[-1].message) == 4.0
    assert before - inbox_module.CLOCK_TOLERANCE <= newest[-1].time <= time.monotonic() + 0.05
    assert box.newest() is None


@pytest.mark.usefixtures("standing_clocks")
@pytest.mark.parametrize(("ahead", "believed"), [(0.049, True), (0.05, False), (0.051, False)])
def test_clocks_may_differ_by_fifty_milliseconds(ahead, believed):
    assert (sent_at(sent(-ahead)) > -math.inf) == believed


@pytest.mark.usefixtures("standing_clocks")
def test_the_time_of_sending_is_told_by_this_process_clock_whatever_the_middleware_counts_from():
    assert sent_at(sent(0.25)) == pytest.approx(999.75, abs=1e-6)
    assert sent_at({"source_timestamp": time.time_ns(), "received_timestamp": 0}) == 1000.0


def test_a_stall_while_the_age_is_told_makes_a_message_older_never_newer(monkeypatch):
    looks = iter((0.0, 0.4))  # s at which the two clocks are read
    monkeypatch.setattr("time.time_ns", lambda: 1_800_000_000_000_000_000 + round(next(looks) * 1e9))
    monkeypatch.setattr("time.monotonic", lambda: 1000.0 + next(looks))
    message = {"source_timestamp": 1_800_000_000_000_000_000 - 100_000_000}  # at 999.9 s
    assert sent_at(message) == pytest.approx(999.5, abs=1e-6)


def test_both_messages_between_two_looks_are_told_oldest_first_each_with_its_own_time(make_node, wait_until):
    node = make_node("both")
    box, sender = polled_subscription(node, VALVE_VOLTAGES), publisher(node, VALVE_VOLTAGES)
    wait_until(lambda: sender.get_subscription_count() == 1)
    before = time.monotonic()
    for swing in (1.0, 2.0):
        sender.publish(float_array(VALVE_VOLTAGES, 0, (swing, 0.0, 0.0)))
    arrived = []
    wait_until(lambda: arrived.extend(box.arrivals()) or len(arrived) == 2)
    assert [volts(arrival.message) for arrival in arrived] == [1.0, 2.0]
    assert all(before - 0.05 <= arrival.time <= time.monotonic() + 0.05 for arrival in arrived)
    assert not list(box.arrivals())


def test_a_node_that_spins_is_not_woken_and_its_messages_wait(make_node, wait_until):
    from forest_msgs_py.runtime.static_executor import StaticExecutor

    node = make_node("both")
    box, sender = polled_subscription(node, VALVE_VOLTAGES), publisher(node, VALVE_VOLTAGES)
    wait_until(lambda: sender.get_subscription_count() == 1)
    executor = StaticExecutor(context=node.context)
    executor.add_node(node)
    turns = []
    node.create_timer(0.001, lambda: turns.append(1))
    sender.publish(float_array(VALVE_VOLTAGES, 0, (1.0, 0.0, 0.0)))
    wait_until(lambda: len(turns) > 20, executor=executor)
    executor.shutdown()
    assert not box.subscription.callback_group.can_execute(box.subscription)  # or it would wake for nothing
    newest = []
    wait_until(lambda: newest.append(box.newest()) or newest[-1] is not None)
    assert volts(newest[-1].message) == 1.0


def test_an_inbox_holds_messages_or_where_that_is_asked_for_their_bytes(make_node, wait_until):
    node, kind = make_node("both"), message_class(VALVE_VOLTAGES)
    parsed = PolledSubscription(node, kind, VALVE_VOLTAGES.name, qos(VALVE_VOLTAGES))
    raw, sender = polled_subscription(node, VALVE_VOLTAGES), publisher(node, VALVE_VOLTAGES)
    wait_until(lambda: sender.get_subscription_count() == 2)
    sender.publish(float_array(VALVE_VOLTAGES, 0, (1.0, 0.0, 0.0)))
    found = {}
    for name, box in (("parsed", parsed), ("raw", raw)):
        wait_until(lambda name=name, box=box: found.setdefault(name, box.newest()) or found.pop(name))
    assert isinstance(found["parsed"].message, kind)
    assert isinstance(found["raw"].message, bytes)


def test_an_inbox_keeps_ten_messages_of_a_fast_topic_the_present_and_not_the_past(make_node):
    assert polled_subscription(make_node("both"), VALVE_VOLTAGES).subscription.qos_profile.depth == 10
