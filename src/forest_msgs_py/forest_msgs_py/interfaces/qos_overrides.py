"""QoS of topics by a person's file, in the form that `--qos-profile-overrides-path` of rosbag2 takes.

    /topic_name:
      history: keep_last
      depth: 10
      reliability: best_effort
      durability: volatile
      lifespan: {sec: 1, nsec: 0}

What is absent is as ROS has it by default: keep_last, depth 10, reliable, volatile. No ROS in here.
"""

from pathlib import Path
from typing import Any

import yaml

from forest_msgs_py.interfaces.qos_profiles import DURABILITY, HISTORY, LIVELINESS, RELIABILITY, Qos, profile
from forest_msgs_py.interfaces.yaml_text import read_yaml

WORDS = {
    "history": HISTORY,
    "reliability": RELIABILITY,
    "durability": DURABILITY,
    "liveliness": LIVELINESS,
}
DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")
KEYS = (*WORDS, "depth", *DURATIONS, "avoid_ros_namespace_conventions")


class QosOverrideError(ValueError):
    """A file of overrides is not usable; the message names it and says what is allowed."""


def read_overrides(file: Path) -> dict[str, Qos]:
    """Return the profiles of a file, by topic.

    Raises:
        QosOverrideError: something in it is not allowed.
        OSError: it cannot be read.
    """
    try:
        tree = read_yaml(file)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise QosOverrideError(f"{file} is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(tree, dict):
        raise QosOverrideError(f"{file}: allowed: a mapping of topics to QoS profiles")
    return {str(topic): _checked(f"{file}: {topic}", entry) for topic, entry in tree.items()}


def _checked(where: str, entry: Any) -> Qos:
    if not isinstance(entry, dict):
        raise QosOverrideError(f"{where} is {entry!r}; allowed: a mapping of {', '.join(KEYS)}")
    for key, value in entry.items():
        problem = _problem(key, value)
        if problem:
            raise QosOverrideError(f"{where}: {problem}")
    return profile(entry)


def _problem(key: Any, value: Any) -> str:
    """Say what is wrong with one policy; "" if nothing is."""
    if key not in KEYS:
        return f"unknown key {key!r}; allowed: {', '.join(KEYS)}"
    if key in WORDS:
        words = [word for word in WORDS[key] if word not in ("unknown", "best_available")]
        return "" if value in words else f"{key} is {value!r}; allowed: {', '.join(words)}"
    if key == "depth":
        return "" if _is_count(value) else f"depth is {value!r}; allowed: a whole number of 0 or more"
    if key in DURATIONS:
        good = (
            isinstance(value, dict) and set(value) == {"sec", "nsec"} and all(map(_is_count, value.values()))
        )
        return "" if good else f"{key} is {value!r}; allowed: sec and nsec, 0 or more"
    return "" if isinstance(value, bool) else f"{key} is {value!r}; allowed: true or false"


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0
