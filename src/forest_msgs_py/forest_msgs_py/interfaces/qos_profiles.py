"""QoS profiles as bags tell them: every version of rosbag2's metadata, as one kind of profile.

Up to version 8 of ``metadata.yaml`` policies are numbers (those of rmw's enumerations) and the list is a text
of YAML inside the YAML; from 9 on they are words and a list. MCAP channels hold the text in either form.
A depth of 0 or a history ``unknown`` is what publishers told before DDS said more: a default stands in.

No ROS in here.
"""

from typing import Any, NamedTuple

import yaml

from forest_msgs_py.interfaces.yaml_text import parsed

NEVER_S = 9223372036  # rmw's infinite duration
DEFAULT_DEPTH = 10
MOST_DEPTH = 10_000  # a publisher keeps its whole queue in memory
HISTORY = ("system_default", "keep_last", "keep_all", "unknown")
RELIABILITY = ("system_default", "reliable", "best_effort", "unknown", "best_available")
DURABILITY = ("system_default", "transient_local", "volatile", "unknown", "best_available")
LIVELINESS = ("system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown", "best_available")


class Qos(NamedTuple):
    """What a publisher offers; durations in ns, 0: without limit."""

    depth: int = DEFAULT_DEPTH
    keep_all: bool = False
    reliable: bool = True
    transient_local: bool = False
    deadline_ns: int = 0
    lifespan_ns: int = 0
    manual: bool = False  # liveliness manual_by_topic
    lease_ns: int = 0


def described(qos: Any) -> list[str]:
    """Each profile for people, in the words of the topic table; what the bag leaves open is "unknown".

    Args:
        qos: as of `offered`.
    """
    return [_description(entry) for entry in _entries(qos)]


def offered(qos: Any) -> list[Qos]:
    """The profiles of a topic's publishers; [] where the bag tells none, or nothing that can be read.

    Args:
        qos: ``offered_qos_profiles`` of a bag: a list, or a text of YAML.
    """
    return [profile(entry) for entry in _entries(qos)]


def in_words(qos: Any) -> list[dict[str, Any]]:
    """Return the profiles of a topic's publishers with the words of rosbag2's metadata version 9.

    Args:
        qos: as of `offered`.
    """
    words = {
        "history": HISTORY,
        "reliability": RELIABILITY,
        "durability": DURABILITY,
        "liveliness": LIVELINESS,
    }
    return [
        {key: _word(value, words[key]) if key in words else value for key, value in entry.items()}
        for entry in _entries(qos)
    ]


def for_replay(profiles: list[Qos]) -> Qos:
    """One profile that serves every reader which the recorded publishers together served.

    Reliable or transient local if one of them was; the queue holds what all their queues held. Deadline,
    lifespan and liveliness are those of the first, if all agree: one of several is no promise for all.
    """
    if not profiles:
        return Qos()
    depths = [profile.depth for profile in profiles]
    transient_local = any(profile.transient_local for profile in profiles)
    joint = Qos(
        min(sum(depths) if transient_local else max(depths), MOST_DEPTH),
        any(profile.keep_all for profile in profiles),
        any(profile.reliable for profile in profiles),
        transient_local,
    )
    limits = {profile[4:] for profile in profiles}
    return Qos(*joint[:4], *profiles[0][4:]) if len(limits) == 1 else joint


def _entries(qos: Any) -> list[dict[str, Any]]:
    if isinstance(qos, str):
        try:
            qos = parsed(qos)
        except yaml.YAMLError:
            return []
    return [entry for entry in qos if isinstance(entry, dict)] if isinstance(qos, list) else []


def _description(entry: dict[str, Any]) -> str:
    def told(policy: str, words: tuple[str, ...], others: dict[str, str]) -> str:
        word = _word(entry.get(policy), words)
        if word in ("unknown", "none"):
            return f"{policy} unknown"
        return others.get(word, word.replace("_", " "))

    history, depth = _word(entry.get("history"), HISTORY), entry.get("depth")
    depth_told = f"depth {depth}" if isinstance(depth, int) and depth > 0 else "depth unknown"
    return ", ".join(
        (
            told("reliability", RELIABILITY, {}),
            told("durability", DURABILITY, {"transient_local": "latched"}),
            "keep all" if history == "keep_all" else depth_told,
        )
    )


def profile(entry: dict[str, Any]) -> Qos:
    """Return one publisher's profile, whatever its entry leaves open as ROS has it by default."""
    history = _word(entry.get("history"), HISTORY)
    depth = entry.get("depth")
    lifespan = _duration(entry.get("lifespan"))
    return Qos(
        depth=min(depth, MOST_DEPTH) if isinstance(depth, int) and depth > 0 else DEFAULT_DEPTH,
        keep_all=history == "keep_all",
        reliable=_word(entry.get("reliability"), RELIABILITY) != "best_effort",
        transient_local=_word(entry.get("durability"), DURABILITY) == "transient_local",
        deadline_ns=_duration(entry.get("deadline")),
        lifespan_ns=lifespan,
        manual=_word(entry.get("liveliness"), LIVELINESS) == "manual_by_topic",
        lease_ns=_duration(entry.get("liveliness_lease_duration")),
    )


def _word(value: Any, words: tuple[str, ...]) -> str:
    if isinstance(value, int) and not isinstance(value, bool):
        return words[value] if 0 <= value < len(words) else "unknown"
    return str(value).lower()


def _duration(value: Any) -> int:
    if not isinstance(value, dict):
        return 0
    sec, nsec = value.get("sec", 0), value.get("nsec", 0)
    if not (isinstance(sec, int) and isinstance(nsec, int)) or not 0 <= sec < NEVER_S:
        return 0
    return sec * 1_000_000_000 + nsec
