"""SROS2's access control for a full ROS: each node may say and hear what the table of topics tells, no more.

An enclave for each node of a live graph, `/forest/NODE`. Beside its topics a node may do what rclpy does by
itself: log, and tell of its parameters. It answers to services of its own; nobody may ask.
"""

import re
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from forest_msgs_py.interfaces.topics import TOPICS

NODES = (
    *("joystick", "controller", "valve_driver", "simulator", "recorder"),
    *("cycle", "twist", "monitor", "viewer"),
)
PARAMETER_EVENTS = "parameter_events"  # of every node of rclpy
ACTIONS = ("~/follow_joint_trajectory",)  # of the node for taught work, where control_msgs is installed
STOPS = "emergency_stop", "reset_emergency_stop"  # services without a node's name: the controller's


def spoken(node: str) -> list[str]:
    """Return the topics that a node may publish."""
    return [topic.name for topic in TOPICS if _names(node, topic.publishers)]


def heard(node: str) -> list[str]:
    """Return the topics that a node may subscribe to; a recorder hears all that is recorded."""
    records = node == "recorder"
    return [topic.name for topic in TOPICS if _names(node, topic.subscribers) or (records and topic.recorded)]


def _names(node: str, people: Sequence[str]) -> bool:
    """Tell whether a row names a node, with whatever parts of a machine; lockstep is of no secured graph."""
    return any(re.fullmatch(rf"every node|{node}( with .*| \(live\))?", name) for name in people)


def policy() -> str:
    """Return the policy file for `ros2 security generate_artifacts`."""
    root = Element("policy", version="0.2.0")
    enclaves = SubElement(root, "enclaves")
    for node in NODES:
        profiles = SubElement(SubElement(enclaves, "enclave", path=f"/forest/{node}"), "profiles")
        profile = SubElement(profiles, "profile", ns="/", node=node)
        _expressions(profile, "topic", "publish", [*spoken(node), PARAMETER_EVENTS])
        _expressions(profile, "topic", "subscribe", heard(node))
        _expressions(profile, "service", "reply", ["~/*", *(STOPS if node == "controller" else ())])
        _expressions(profile, "action", "execute", ACTIONS if node == "cycle" else ())
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _expressions(profile: Element, kind: str, verb: str, names: Sequence[str]) -> None:
    if names:
        group = SubElement(profile, f"{kind}s", {verb: "ALLOW"})
        for name in names:
            SubElement(group, kind).text = name
