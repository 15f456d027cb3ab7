"""SROS2's policies: no node may do what the table of topics does not tell of it."""

from xml.etree import ElementTree

import pytest

from forest_msgs_py.interfaces.access_policy import NODES, PARAMETER_EVENTS, heard, policy, spoken
from forest_msgs_py.interfaces.topics import TOPICS

COMMANDING = {
    "joy": {"joystick"},
    "valve_commands": {"controller"},
    "valve_voltages": {"valve_driver"},
    "joint_states": {"simulator"},
    "tip/taught_command": {"cycle", "twist"},
}


def allowed(verb, kind="topic"):
    """Return the names of each node's expressions of a verb, as the file has them."""
    found = {}
    for enclave in ElementTree.fromstring(policy()).iter("enclave"):
        (profile,) = enclave.iter("profile")
        assert enclave.get("path") == f"/forest/{profile.get('node')}"
        groups = [group for group in profile.iter(f"{kind}s") if group.get(verb) == "ALLOW"]
        found[profile.get("node")] = {name.text for group in groups for name in group}
    return found


@pytest.mark.parametrize("topic", COMMANDING)
def test_a_command_topic_has_the_speakers_that_it_needs(topic):
    assert {node for node, names in allowed("publish").items() if topic in names} == COMMANDING[topic]


def test_every_node_may_do_what_the_table_tells_and_no_more():
    assert set(allowed("publish")) == set(NODES)
    known = {topic.name for topic in TOPICS}
    for node in NODES:
        assert allowed("publish")[node] == set(spoken(node)) | {PARAMETER_EVENTS}
        assert allowed("subscribe")[node] == set(heard(node)) <= known
    assert "valve_voltages" in heard("simulator")
    assert {topic.name for topic in TOPICS if topic.recorded} <= allowed("subscribe")["recorder"]


def test_nobody_may_ask_for_a_service():
    assert not any(allowed("request", "service").values())
    assert allowed("reply", "service")["valve_driver"] == {"~/*"}


def test_taught_work_alone_has_an_action_and_nobody_may_ask_for_it():
    having = {node: names for node, names in allowed("execute", "action").items() if names}
    assert having == {"cycle": {"~/follow_joint_trajectory"}}
    assert not any(allowed("call", "action").values())
