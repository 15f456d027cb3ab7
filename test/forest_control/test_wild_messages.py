"""Good and wild messages on every input of the live nodes: none raises, and no voltage is out of range.

What the nodes say goes aside: a second publisher of a command would be a stop, and hide the others.

The middleware itself sends no bytes that are no message of the type; readers get such in `test/fuzz`.

`WILD_MESSAGES=100000 scripts/test.sh test/forest_control/test_wild_messages.py` takes two minutes.
"""

import math
import os
import random
import time

import pytest

pytest.importorskip("rclpy")


from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import TOPICS, message_class

COUNT = int(os.environ.get("WILD_MESSAGES", "300"))  # on each input
NODES = {
    "controller": "forest_control.controller_node",
    "valve_driver": "forest_control.valve_driver_node",
    "simulator": "forest_sim.simulator_node",
}
RATING = 10.0  # [V]
GOOD = 0.8  # share of messages that can be read
AT_ONCE = 8  # messages of an input, in a row: fewer than a reader keeps


def among(names):
    """Those nodes under test that names of the table mean."""
    return {name.split(" ")[0] for name in names if "lockstep" not in name} & set(NODES)


INPUTS = [topic for topic in TOPICS if among(topic.subscribers)]
STOPS = (topics.EMERGENCY_STOP, topics.EMERGENCY_STOPPED)  # these all say and hear


def aside(topic):
    return f"aside/{topic.name}"


def arguments(node):
    said = [topic for topic in INPUTS if topic not in STOPS and node in among(topic.publishers)]
    return ["--ros-args", *(word for topic in said for word in ("-r", f"{topic.name}:={aside(topic)}"))]


def good(topic, rng):
    """A message of a topic that can be read; a valve opens by one after another that asks for nothing."""
    now, count = time.time_ns(), len(topic.labels)
    if topic.type == topics.FLOAT_ARRAY:
        return messages.float_array(topic, now, (rng.choice((0.0, 0.5)),) * count)
    if topic.type == topics.JOINT_STATE:
        return messages.joint_state(topic.labels, now, (0.1,) * count)
    message = message_class(topic)()
    if topic == topics.JOY:
        message.axes, message.buttons = [0.0] * 6, [0] * 21
    return message


def spoilt(message, rng):
    """The message with some of its fields others, missing, or too many; a field of another type cannot be."""
    for name, kind in message.get_fields_and_field_types().items():
        if rng.random() < 0.6:
            continue
        if "/" in kind and not kind.startswith("sequence"):
            spoilt(getattr(message, name), rng)
        elif kind == "boolean":
            setattr(message, name, False)  # a stop that is pressed would hide the others
        elif kind == "string":
            setattr(message, name, "".join(rng.choices("swing,bomtk \u20ac", k=rng.randint(0, 40))))
        elif "int" in kind and not kind.startswith("sequence"):
            setattr(message, name, rng.choice((0, 1, 2, 7, 2**31 - 1)))
        elif "double" in kind or "float" in kind:
            largest = 1e300 if "double" in kind else 1e38
            wild = (math.nan, math.inf, -math.inf, largest, -largest, 5e-324, 0.3, -7.0, 1.0)
            setattr(message, name, rng.choices(wild, k=rng.choice((0, 1, 3, 5, 8, 1000))))
        elif kind == "sequence<string>":
            setattr(message, name, rng.choices(("swing", "boom", "stick", "", "elbow"), k=rng.randint(0, 6)))
    return message


def test_whatever_comes_no_node_raises_and_no_voltage_is_out_of_range(peer, start_process):
    nodes = {name: start_process(["-m", module, *arguments(name)]) for name, module in NODES.items()}
    volts = peer.hear(topics.VALVE_VOLTAGES, aside(topics.VALVE_VOLTAGES))
    speakers = {
        topic: peer.node.create_publisher(message_class(topic), topic.name, qos(topic)) for topic in INPUTS
    }
    for speaker in speakers.values():
        peer.until(speaker.get_subscription_count)
    rng = random.Random(7)
    for begun in range(0, COUNT, AT_ONCE):
        for topic, speaker in speakers.items():
            for _ in range(min(AT_ONCE, COUNT - begun)):
                message = good(topic, rng)
                speaker.publish(message if rng.random() < GOOD else spoilt(message, rng))
        peer.executor.spin_once(timeout_sec=0.001)
        assert [name for name, node in nodes.items() if node.poll() is not None] == []
    peer.until(lambda: len(volts) > 100)
    said = [
        value
        for message in volts
        for value in messages.read_float_array(topics.VALVE_VOLTAGES, message, 0).values
    ]
    assert any(said), "the valves stayed shut: nothing was tried"
    assert all(math.isfinite(value) and abs(value) <= RATING for value in said)
    for name, node in nodes.items():
        assert "Traceback" not in node.text(), name
        assert node.stop() == 0, node.text()
