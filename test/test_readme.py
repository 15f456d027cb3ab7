"""The README's tables are the code's."""

import re
from pathlib import Path

import pytest

from forest_msgs_py.interfaces.topics import TOPICS

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text("utf-8")
CORE = "joy", "valve_commands", "valve_voltages", "joint_states", "actuator_states"


@pytest.mark.parametrize("name", CORE)
def test_a_core_topic_is_told_as_in_the_code(name):
    (topic,) = (topic for topic in TOPICS if topic.name == name)
    assert f"| `{topic.name}` | {topic.type.replace('/msg/', '/')} | {topic.doc} |\n" in README


def test_every_package_is_in_the_table():
    packages = {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    assert set(re.findall(r"^\| `(forest_\w+)` \|", README, re.MULTILINE)) == packages
