import math

import pytest

pytest.importorskip("rclpy")

from forest_description.machine import load_machine
from forest_ident.online import online_estimator
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state, read_float_array
from forest_msgs_py.interfaces.topic_qos import qos


def test_labels_are_those_of_the_topic():
    p = online_estimator.parameters(load_machine("c180_hoses"))
    assert len(online_estimator.report(online_estimator.initial(p))) == len(topics.IDENTIFICATION.labels)


def test_it_tells_what_it_believes_while_the_joints_come(peer, start_node):
    heard = peer.hear(topics.IDENTIFICATION)
    process = start_node("online_node", "-p", "report_period:=0.1")
    joints = peer.node.create_publisher(
        topics.message_class(topics.JOINT_STATES), topics.JOINT_STATES.name, qos(topics.JOINT_STATES)
    )
    volts = peer.node.create_publisher(
        topics.message_class(topics.VALVE_VOLTAGES), "valve_voltages", qos(topics.VALVE_VOLTAGES)
    )
    stamps = iter(range(10**9, 10**12, 5_000_000))

    def told():
        stamp = next(stamps)
        volts.publish(float_array(topics.VALVE_VOLTAGES, stamp, (0.0, 0.0, 0.0)))
        joints.publish(joint_state(topics.JOINTS, stamp, (0.0, 0.5, -1.5), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        return len(heard) > 1

    peer.until(told)
    labels = ("boom_deadband_forward", "boom_damping")
    edge, damping = read_float_array(topics.IDENTIFICATION, heard[-1], 0, labels).values
    assert edge == pytest.approx(1.0)
    assert math.isclose(damping, load_machine("c180_hoses").boom.damping)
    assert process.poll() is None
