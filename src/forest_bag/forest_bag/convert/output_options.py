"""What `forest-bag convert` is to write: the YAML file that `ros2 bag convert --output-options` takes.

output_bags:
- uri: moves                       # a directory to be made
  storage_id: mcap                 # or sqlite3
  topics: [/joint_states]          # or all_topics, topic_types, regex; services, all_services
  exclude_topics: []               # also exclude_topic_types, exclude_regex, exclude_services
  start_time_ns: 1700000000000000000   # first and last log time
  end_time_ns: 1700000060000000000
  max_bagfile_size: 0              # bytes; 0: one file
  max_bagfile_duration: 0          # s
  storage_preset_profile: zstd_fast
  compression_mode: file           # or message
  compression_format: zstd
"""

import re
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from forest_bag.storage.bag_files import BagError
from forest_bag.write.bag_split import Layout
from forest_msgs_py.interfaces.yaml_text import read_yaml
from forest_msgs_py.types import NS_PER_S

SERVICE_EVENT = "/_service_event"  # what the topics of introspected services end with
STORAGES = ("mcap", "sqlite3")
PRESETS = {
    "": ("zstd", 0),
    "none": ("none", 0),
    "fastwrite": ("none", 0),
    "zstd_fast": ("zstd", 0),
    "zstd_small": ("zstd", 4 << 20),  # [byte] of a chunk, as rosbag2_storage_mcap's
    "resilient": ("zstd", 0),  # of sqlite3, whose files are not compressed
}
"""Compression and size of the chunks, by rosbag2's name of a profile; 0: the usual size."""
MODES = ("", "none", "file", "message")
CHOICES = ("topics", "topic_types", "services", "regex")  # besides the flags all, all_topics, all_services
DEFAULTS: dict[str, Any] = {
    "uri": "",
    "storage_id": "",
    "storage_preset_profile": "",
    "storage_config_uri": "",
    "max_bagfile_size": 0,
    "max_bagfile_duration": 0.0,
    "max_cache_size": 0,
    "start_time_ns": -1,
    "end_time_ns": -1,
    "all": False,
    "all_topics": False,
    "all_services": False,
    "topics": [],
    "topic_types": [],
    "services": [],
    "regex": "",
    "exclude_topics": [],
    "exclude_topic_types": [],
    "exclude_services": [],
    "exclude_regex": "",
    "exclude": "",  # an older name of exclude_regex
    "include_hidden_topics": False,
    "include_unpublished_topics": False,
    "rmw_serialization_format": "",
    "compression_mode": "",
    "compression_format": "",
    "compression_queue_size": 0,
    "compression_threads": 0,
}
"""The keys of rosbag2; hidden topics, queues, threads and caches change nothing of what is written here."""
KINDS = {
    list: "a list of texts",
    str: "a text",
    bool: "true or false",
    int: "a whole number of 0 or more",
    float: "a number of 0 or more",
}


class TopicSelection(NamedTuple):
    """Which topics an output gets, by rosbag2's rules."""

    everything: bool
    all_services: bool
    names: frozenset[str]
    types: frozenset[str]
    services: frozenset[str]
    pattern: re.Pattern[str] | None
    excluded: frozenset[str]
    excluded_types: frozenset[str]
    excluded_pattern: re.Pattern[str] | None

    def wants(self, name: str, kind: str) -> bool:
        """Whether a topic of some type is wanted."""
        service = name.removesuffix(SERVICE_EVENT)
        shown = name if service == name else service
        if name in self.excluded or service in self.excluded or kind in self.excluded_types:
            return False
        if self.excluded_pattern is not None and self.excluded_pattern.search(shown):
            return False
        if self.pattern is not None and self.pattern.search(shown):
            return True
        if service != name:
            return self.all_services or service in self.services or name in self.services
        return self.everything or name in self.names or kind in self.types


class OutputBag(NamedTuple):
    """One bag to be written."""

    directory: Path
    layout: Layout
    selection: TopicSelection
    start_ns: int  # first log time
    end_ns: int  # last one; -1: no limit
    mode: str  # in which messages or files are compressed: file, message, or "": not at all


def read_outputs(file: Path) -> tuple[OutputBag, ...]:
    """Read a file of output options.

    Raises:
        BagError: something in it is not allowed; the text names it.
        OSError: it cannot be read.
    """
    try:
        tree = read_yaml(file)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BagError(f"{file} is not YAML: {' '.join(str(error).split())}") from error
    bags = tree.get("output_bags") if isinstance(tree, dict) else None
    if not isinstance(bags, list) or not bags:
        raise BagError(f"{file}: allowed: 'output_bags:' with a list of bags below it")
    outputs = tuple(_output(f"{file}: output_bags[{place}]", bag) for place, bag in enumerate(bags))
    directories = [output.directory for output in outputs]
    for directory in directories:
        if directories.count(directory) > 1 or directory.exists():
            raise BagError(f"{file}: {directory} exists, or is named twice; allowed: directories to be made")
    return outputs


def _output(where: str, tree: Any) -> OutputBag:
    if not isinstance(tree, dict):
        raise BagError(f"{where} is {tree!r}; allowed: a mapping of {', '.join(DEFAULTS)}")
    given = {**DEFAULTS, **{key: _checked(where, key, value) for key, value in tree.items()}}
    if not given["uri"]:
        raise BagError(f"{where} has no uri; allowed: a directory to be made")
    storage = _choice(where, "storage_id", given["storage_id"] or "mcap", STORAGES)
    preset = _choice(where, "storage_preset_profile", given["storage_preset_profile"], PRESETS)
    mode = _choice(where, "compression_mode", given["compression_mode"].lower(), MODES)
    _choice(where, "compression_format", given["compression_format"], ("", "zstd"))
    _choice(where, "rmw_serialization_format", given["rmw_serialization_format"], ("", "cdr"))
    compression, chunk_bytes = PRESETS[preset]
    layout = Layout(
        compression=compression,
        max_bytes=given["max_bagfile_size"],
        max_ns=round(given["max_bagfile_duration"] * NS_PER_S),
        chunk_bytes=chunk_bytes or Layout().chunk_bytes,
        storage=storage,
        repeats=False,  # a bag that is converted keeps the messages that it has
    )
    return OutputBag(
        directory=Path(given["uri"]),
        layout=layout,
        selection=_selection(where, given),
        start_ns=given["start_time_ns"],
        end_ns=given["end_time_ns"],
        mode="" if mode == "none" else mode,
    )


def _selection(where: str, given: dict[str, Any]) -> TopicSelection:
    everything, services = given["all"] or given["all_topics"], given["all"] or given["all_services"]
    if not (everything or services or any(given[key] for key in CHOICES)):
        raise BagError(f"{where} chooses no topic; allowed: all_topics: true, topics, topic_types or regex")
    return TopicSelection(
        everything,
        services,
        frozenset(given["topics"]),
        frozenset(given["topic_types"]),
        frozenset(given["services"]),
        _pattern(where, "regex", given["regex"]),
        frozenset((*given["exclude_topics"], *given["exclude_services"])),
        frozenset(given["exclude_topic_types"]),
        _pattern(where, "exclude_regex", given["exclude_regex"] or given["exclude"]),
    )


def _pattern(where: str, key: str, text: str) -> re.Pattern[str] | None:
    try:
        return re.compile(text) if text else None
    except re.error as error:
        raise BagError(f"{where}: {key} is {text!r}, which is no regular expression: {error}") from error


def _checked(where: str, key: str, value: Any) -> Any:
    if key not in DEFAULTS:
        raise BagError(f"{where}: unknown key {key!r}; allowed: {', '.join(DEFAULTS)}")
    kind, default = type(DEFAULTS[key]), DEFAULTS[key]
    good = isinstance(value, (int, float) if kind is float else kind)
    if kind is not bool and isinstance(value, bool):
        good = False
    elif good and kind in (int, float):
        good = value >= min(0, default)
    elif good and kind is list:
        good = all(isinstance(text, str) for text in value)
    if not good:
        raise BagError(f"{where}: {key} is {value!r}; allowed: {KINDS[kind]}")
    return value


def _choice(where: str, key: str, value: str, allowed: Collection[str]) -> str:
    if value not in allowed:
        words = ", ".join(word for word in allowed if word)
        raise BagError(f"{where}: {key} is {value!r}; allowed: {words}, or nothing")
    return value
