"""A node's clock: the computer's own live, the graph's in lockstep."""

import time

import pytest

pytest.importorskip("rclpy")

from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter

from forest_msgs_py.clock.lockstep import LockstepClock
from forest_msgs_py.clock.node_clock import LiveClock, node_clock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.stamps import stamp_in
from forest_msgs_py.serialization.unpacking import ArrayReader

NUMBERS = (1.0, -2.0, 3.0)


def test_a_live_node_hears_when_each_message_was_sent_and_counts_it(make_node, ros_context, wait_until):
    node = make_node("live")
    clock = node_clock(node)
    assert isinstance(clock, LiveClock)
    assert not clock.lockstep
    assert clock.now() == pytest.approx(time.monotonic(), abs=1.0)
    assert clock.stamp() == pytest.approx(time.time_ns(), abs=1e9)
    heard, ticks = [], []
    received = clock.on(topics.VALVE_VOLTAGES, lambda data, sent: heard.append((data, sent)))
    polled = clock.polled_subscription(topics.VALVE_VOLTAGES)
    clock.every(0.01, lambda: ticks.append(clock.now()))
    speak = number_publisher(clock, topics.VALVE_VOLTAGES).publish
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(node)
    wait_until(lambda: node.count_subscribers(topics.VALVE_VOLTAGES.name) == 2)
    stamp = clock.stamp()
    speak(stamp, NUMBERS)
    wait_until(lambda: heard and len(ticks) > 1, executor=executor)
    assert ArrayReader(topics.VALVE_VOLTAGES).read(heard[0][0], 0).values == NUMBERS
    assert stamp_in(topics.VALVE_VOLTAGES.type, heard[0][0]) == stamp
    assert heard[0][1] == pytest.approx(time.monotonic(), abs=5.0)
    assert received.count == 1
    assert received.subscription.topic_name == "/valve_voltages"
    assert polled.newest().message == heard[0][0]


def test_in_lockstep_parameters_tell_the_steps_the_guard_and_whether_a_recorder_is_waited_for(make_node):
    told = {
        "lockstep": True,
        "lockstep_guard": 3.0,
        "lockstep_quiet": 5,
        "steps": 7,
        "wait_for_recorder": True,
    }
    names = [Parameter(name, value=value) for name, value in told.items()]
    leader = node_clock(make_node("machine", parameter_overrides=names), leads=True)
    follower = node_clock(make_node("other", parameter_overrides=names))
    assert isinstance(leader, LockstepClock)
    assert isinstance(follower, LockstepClock)
    assert leader.lockstep
    assert (leader._guard, leader._batch_steps, leader._steps, leader._leads) == (3.0, 5, 7, True)
    assert leader._recorded is not None
    assert leader._clock is not None
    assert (follower._guard, follower._batch_steps, follower._steps, follower._leads) == (3.0, 5, 0, False)
    assert follower._recorded is None
    assert follower._clock is None
    publisher = number_publisher(leader, topics.PRESSURES)
    leader._publishing = 1
    publisher.publish(5_000_000, (1.0,) * 12)
    assert leader._publishers[-1].published_step == 1
