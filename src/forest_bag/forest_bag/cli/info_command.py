"""`forest-bag info`: what is in a bag."""

import argparse
import datetime
import json
from pathlib import Path
from typing import Any

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.survey import Survey, TopicInfo, survey
from forest_bag.storage.raw_messages import BagFile
from forest_msgs_py.runtime.command_line import Subcommands, subcommand
from forest_msgs_py.types import NS_PER_S

EPOCH_NS = 10**17  # log times below are simulated time, not a date


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "show a bag's topics, QoS, gaps, losses, files, events and attachments"
    parser = subcommand(verbs, "info", text, run)
    parser.add_argument("bag", type=Path, metavar="BAG", help="directory, .mcap or .db3 file, damaged or not")
    parser.add_argument("--json", action="store_true", help="print JSON, with times in ns")


def run(options: argparse.Namespace) -> int:
    """Print it; 1 if the bag is damaged."""
    with BagReader(options.bag, lenient=True) as reader:
        found = survey(reader)
        print(json.dumps(as_json(reader, found), indent=2) if options.json else as_text(reader, found))
        return 0 if reader.complete else 1


def as_json(reader: BagReader, found: Survey) -> dict[str, Any]:
    """Everything, by name."""
    first, last = reader.span
    return {
        "bag": str(reader.path),
        "complete": reader.complete,
        "problems": reader.problems,
        "notes": reader.notes,
        "bytes": reader.size,
        "start_ns": first,
        "end_ns": last,
        "duration_s": (last - first) / NS_PER_S,
        "messages": sum(topic.count for topic in found.topics.values()),
        "lost": sum(topic.lost for topic in found.topics.values()),
        "files": [_file(file) for file in reader.files],
        "topics": {name: _topic(topic) for name, topic in found.topics.items()},
        "events": [{"time_ns": time, "text": text} for time, text in found.events],
        "attachments": [{"name": name, "bytes": len(data)} for name, data in _attachments(reader)],
        "metadata": {
            name: values for file in reader.files for name, values in file.metadata if name != "rosbag2"
        },
    }


def _file(file: BagFile) -> dict[str, Any]:
    return {
        "name": file.path.name,
        "bytes": file.path.stat().st_size,
        "start_ns": min((piece.first_ns for piece in file.pieces), default=0),
        "end_ns": max((piece.last_ns for piece in file.pieces), default=0),
        "complete": file.complete,
    }


def _topic(topic: TopicInfo) -> dict[str, Any]:
    return {
        "type": topic.type,
        "type_hash": topic.type_hash,
        "qos": topic.qos,
        "messages": topic.count,
        "bytes": topic.bytes,
        "rate_hz": topic.rate_hz,
        "start_ns": topic.first_ns,
        "end_ns": topic.last_ns,
        "lost": topic.lost,
        "gaps": topic.gaps,
        "longest_gap_s": topic.longest_ns / NS_PER_S if topic.period_ns else None,
        "longest_gap_at_ns": topic.longest_at_ns if topic.period_ns else None,
    }


def as_text(reader: BagReader, found: Survey) -> str:
    """The same for people."""
    told = as_json(reader, found)
    first = told["start_ns"]
    lines = [
        f"bag        {told['bag']}{'' if told['complete'] else '  (damaged)'}",
        *(f"problem    {problem}" for problem in told["problems"]),
        *(f"note       {note}" for note in told["notes"]),
        f"start      {_date(first)}",
        f"duration   {told['duration_s']:.3f} s",
        f"messages   {told['messages']}, lost {told['lost']}",
        f"size       {_size(told['bytes'])}",
    ]
    for file in told["files"]:
        span = f"{_since(file['start_ns'], first)} .. {_since(file['end_ns'], first)}"
        lines.append(f"file       {file['name']}  {_size(file['bytes'])}  {span}")
    width = max((len(name) for name in told["topics"]), default=0)
    lines += [_topic_line(name, topic, first, width) for name, topic in told["topics"].items()]
    lines += [f"event      {_since(event['time_ns'], first)}  {event['text']}" for event in told["events"]]
    lines += [f"attached   {file['name']}  {_size(file['bytes'])}" for file in told["attachments"]]
    for name, values in told["metadata"].items():
        lines.append(f"metadata   {name}: {', '.join(f'{key} {value}' for key, value in values.items())}")
    return "\n".join(lines)


def _topic_line(name: str, topic: dict[str, Any], first_ns: int, width: int) -> str:
    notes = [f"{topic['rate_hz']:.1f} Hz"] if topic["longest_gap_s"] is not None else []
    if topic["lost"]:
        notes.append(f"lost {topic['lost']}")
    if topic["gaps"]:
        place = _since(topic["longest_gap_at_ns"], first_ns)
        count, longest = topic["gaps"], topic["longest_gap_s"]
        notes.append(f"{count} gap{'s' * (count > 1)}, longest {longest:.3f} s at {place}")
    notes += topic["qos"] or ["QoS unknown"]
    return f"topic      {name:{width}} {topic['messages']:>8}  {topic['type']}  {'; '.join(notes)}"


def _attachments(reader: BagReader) -> list[tuple[str, bytes]]:
    """Of all files; splits repeat them."""
    return list({a.name: (a.name, a.data) for file in reader.files for a in file.attachments}.values())


def _since(time_ns: int, first_ns: int) -> str:
    return f"{(time_ns - first_ns) / NS_PER_S:.3f} s"


def _date(time_ns: int) -> str:
    if time_ns < EPOCH_NS:
        return f"{time_ns / NS_PER_S:.3f} s, simulated time"
    return datetime.datetime.fromtimestamp(time_ns / NS_PER_S).astimezone().isoformat(" ", "milliseconds")


def _size(count: int) -> str:
    return f"{count / 1e6:.2f} MB" if count >= 100_000 else f"{count / 1e3:.1f} kB"
