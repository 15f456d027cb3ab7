import pytest

pytest.importorskip("rclpy")

from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state
from forest_msgs_py.interfaces.topic_qos import qos

MACHINE = load_machine("c180_hoses")
ANGLES = 0.1, 0.4, -1.4
LENGTHS = tuple(
    cylinder_length(angle, drive.linkage)
    for angle, drive in zip(ANGLES[1:], (MACHINE.boom, MACHINE.stick), strict=True)
)
OFF = 0.05  # [m]
AT_ONCE = 20  # states


def test_a_length_that_does_not_belong_to_its_angle_is_told_on_diagnostics(peer, start_node):
    heard = peer.hear(topics.DIAGNOSTICS)
    process = start_node("monitor_node", "-p", "machine:=c180_hoses")
    said = {
        topic: peer.node.create_publisher(topics.message_class(topic), topic.name, qos(topic))
        for topic in (topics.JOINT_STATES, topics.ACTUATOR_STATES, topics.VALVE_VOLTAGES, topics.SUPPLY)
    }
    stamps = iter(range(10**9, 10**13, 5_000_000))
    zero = (0.0, 0.0, 0.0)

    def told():
        for _ in range(AT_ONCE):
            stamp = next(stamps)
            lengths = (0.0, LENGTHS[0] + OFF, LENGTHS[1])
            said[topics.ACTUATOR_STATES].publish(joint_state(topics.ACTUATORS, stamp, lengths, zero, zero))
            said[topics.VALVE_VOLTAGES].publish(float_array(topics.VALVE_VOLTAGES, stamp, zero))
            said[topics.JOINT_STATES].publish(joint_state(topics.JOINTS, stamp, ANGLES, zero, zero))
        return any("do not belong together" in one.message for one in statuses())

    def statuses():
        found = {}
        for message in heard:
            found |= {one.name: one for one in message.status if one.name.startswith("monitor: ")}
        return list(found.values())

    peer.until(told)
    by_name = {one.name: one for one in statuses()}
    boom = by_name["monitor: boom"]
    assert boom.level == b"\x01"  # WARN: the machine works on
    assert boom.message.startswith("boom: cylinder's length and joint's angle do not belong together")
    assert "calibrate the sensor" in boom.message
    assert by_name["monitor: stick"].message == "well"
    silent = by_name["monitor: sensors"].message  # the file has them; nobody publishes them
    assert silent.startswith("swing_pressure_1_valve,")
    assert "and 14 more: no readings" in silent
    assert float({one.key: one.value for one in by_name["monitor: machine"].values}["boom_agree"]) >= 1.0
    assert process.poll() is None
