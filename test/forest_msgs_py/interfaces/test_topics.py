"""The topic table is sound, and docs/reference/topics.md shows it."""

import subprocess
import sys
from pathlib import Path

import pytest

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topic_reference import markdown
from forest_msgs_py.interfaces.topics import TOPICS

DOCS = Path(__file__).resolve().parents[3] / "docs" / "reference" / "topics.md"
ROS_WORLD = {"/clock", "/diagnostics", "/rosout", "/tf", "/tf_static"}


def test_docs_are_the_table():
    assert DOCS.read_text() == markdown() + "\n"


def test_every_topic_of_the_module_is_in_the_table_once():
    assert topics.JOY in TOPICS
    assert topics.RECORDED in TOPICS
    assert len({row.name for row in TOPICS}) == len(TOPICS)


@pytest.mark.parametrize("row", TOPICS, ids=lambda row: row.name)
def test_every_value_has_one_label_and_a_unit(row):
    assert len(row.labels) == len(row.units)
    assert len(set(row.labels)) == len(row.labels)
    assert all(row.units)
    assert row.publishers or row.name in ROS_WORLD
    assert row.name.startswith("/") == (row.name in ROS_WORLD)


def test_the_twelve_transducers_are_named_by_axis_port_and_place():
    assert topics.PRESSURES.labels[:4] == (
        "swing_1_valve",
        "swing_1_actuator",
        "swing_2_valve",
        "swing_2_actuator",
    )
    assert len(topics.PRESSURES.labels) == 12


def test_the_table_needs_no_ros():
    code = "import sys, forest_msgs_py.interfaces.topics; sys.exit('rclpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("row", TOPICS, ids=lambda row: row.name)
def test_type_and_qos_of_every_topic_exist(row):
    pytest.importorskip("rclpy")
    if row in (topics.TF, topics.TF_STATIC):
        pytest.importorskip("tf2_msgs")
    assert topics.message_class(row).__name__ == row.type.rsplit("/", 1)[1]
    profile = qos(row)
    assert profile.depth == (1 if row.transient_local else 200 if row.rate_hz >= 100 else 10)
    assert qos(row, reading=True).depth == 10
    assert profile.reliability.short_key == "reliable"
    assert profile.durability.short_key == ("transient_local" if row.transient_local else "volatile")


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("/joint_states", topics.JOINT_STATES),
        ("/crane_1/joint_states", topics.JOINT_STATES),
        ("/crane_1/ground_truth/joint_states", topics.GROUND_TRUTH_JOINT_STATES),
        ("/clock", topics.CLOCK),
        ("/my_joint_states", None),
    ],
)
def test_a_resolved_name_finds_its_row_in_any_namespace(name, row):
    assert topics.find(name) == row


def test_what_machines_and_joysticks_of_others_say_is_heard_from_best_effort_publishers_too():
    rclpy_qos = pytest.importorskip("rclpy.qos")
    lossy = rclpy_qos.QoSProfile(depth=5, reliability=rclpy_qos.ReliabilityPolicy.BEST_EFFORT)
    heard = {
        row.name
        for row in TOPICS
        if rclpy_qos.qos_check_compatible(lossy, qos(row, reading=True))[0]
        != rclpy_qos.QoSCompatibility.ERROR
    }
    sensed = {"joint_states", "actuator_states", *(f"hydraulics/{what}" for what in ("pressures", "supply"))}
    assert heard == {"joy", "delta_twist_cmds", "hydraulics/flows", "hydraulics/auxiliary", *sensed}
    assert all(qos(row).reliability == rclpy_qos.ReliabilityPolicy.RELIABLE for row in TOPICS)
