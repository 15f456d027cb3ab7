"""The delay as a process: messages pass unread, late; nonsense is refused."""

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import joint_state, stamp_to_ns


def test_messages_come_late_and_as_they_were(peer, start_process):
    late = ("topic_in:=joint_states", "topic_out:=late", "delay:=0.2")
    options = [word for parameter in late for word in ("-p", parameter)]
    start_process(["-m", "forest_study.delay_node", "--ros-args", *options])
    heard = peer.hear(topics.JOINT_STATES, "late")
    sender = peer.speak(topics.JOINT_STATES)

    sent = []

    def come():  # again and again: the delay may know its listener later than the listener knows the delay
        sent.append(now())
        sender.publish(joint_state(topics.JOINTS, sent[-1], (0.1, 0.2, 0.3)))
        return heard

    def now():
        return peer.node.get_clock().now().nanoseconds

    peer.until(come)
    stamp = stamp_to_ns(heard[0].header.stamp)
    assert stamp in sent
    assert now() - stamp >= 0.2e9
    assert list(heard[0].position) == [0.1, 0.2, 0.3]


def test_nonsense_is_refused_in_one_line(domain_id, start_process):
    refused = {
        "topic_in:=nothing": "parameter 'topic_in' is 'nothing'; allowed: one of joy, ",
        "topic_out:=joy": "parameter 'topic_out' is 'joy'; allowed: another than topic_in",
    }
    for given, said in refused.items():
        process = start_process(["-m", "forest_study.delay_node", "--ros-args", "-p", given])
        assert process.ended() == 2
        assert said in process.text()
        assert process.text().count("\n") == 1
