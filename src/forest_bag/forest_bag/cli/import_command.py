"""`forest-bag from-csv`: somebody's measured log as a bag of our topics."""

import argparse
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from forest_bag.convert.log_map import LogMap, mappable, read_map, signal_units
from forest_bag.convert.measured_log import MeasuredLog, read_log
from forest_bag.write.bag_split import Attached
from forest_bag.write.bag_writer import BagWriter
from forest_description.types import Floats
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import JOY, JOY_AXES, JOY_BUTTONS, Topic, message_class
from forest_msgs_py.runtime.command_line import Subcommands, subcommand
from forest_msgs_py.types import NS_PER_S

FRAME = "base_link"


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "make a bag of this project's topics from a measured log"
    epilog = f"The map is described in docs/reference/bags.md. Topics: {', '.join(mappable())}."
    parser = subcommand(verbs, "from-csv", text, run, epilog)
    parser.add_argument("file", type=Path, metavar="FILE", help="CSV file of the log")
    parser.add_argument(
        "--map", type=Path, required=True, metavar="YAML", help="columns of the log and their signals"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="to be made (default: FILE without .csv)"
    )


def run(options: argparse.Namespace) -> int:
    """Import; return the exit code."""
    mapping = read_map(options.map)
    log = read_log(options.file, mapping)
    output = options.output or options.file.with_suffix("")
    writer = BagWriter(output)
    try:
        start = int(log.times_ns[0])
        writer.attach(Attached(f"import/{options.map.name}", "text/plain", options.map.read_bytes(), start))
        writer.note("forest_import", {"file": options.file.name, "sha256": _digest(options.file)})
        counts = _write(writer, log)
    finally:
        writer.close()
    print(summary(log, mapping, counts))
    print(f"{output}: {sum(counts.values())} messages")
    return 0


def _digest(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.sha256(stream.read()).hexdigest()


def _write(writer: BagWriter, log: MeasuredLog) -> dict[str, int]:
    """Write all messages in the order of their stamps; return how many by topic."""
    encoded = {
        topic: _encoder(topic)(labels, log.times_ns, values) for topic, (labels, values) in log.values.items()
    }
    counts = dict.fromkeys((f"/{topic.name}" for topic in encoded), 0)
    for topic in encoded:
        writer.add_topic(f"/{topic.name}", topic.type, [offered_qos(topic)], "")
    for row, stamp in enumerate(log.times_ns.tolist()):
        for topic, messages in encoded.items():
            data = messages[row]
            if data is not None:
                name = f"/{topic.name}"
                counts[name] += 1
                writer.write(name, data, stamp, stamp, counts[name])
    return counts


def _encoder(topic: Topic) -> Callable[[tuple[str, ...], NDArray[np.int64], Floats], list[bytes | None]]:
    return _encode_joy if topic == JOY else lambda *data: _encode_numbers(topic, *data)


def _encode_numbers(
    topic: Topic, labels: tuple[str, ...], stamps: NDArray[np.int64], values: Floats
) -> list[bytes | None]:
    """Sensors that the log has not got are absent, as ours are without a sample."""
    from forest_msgs_py.interfaces.topics import columns
    from forest_msgs_py.serialization.batch_encoder import Encoder

    whole = np.full((len(stamps), len(columns(topic))), np.nan)
    whole[:, [columns(topic).index(label) for label in labels]] = values
    return Encoder(topic, FRAME).encode(stamps, whole)


def _encode_joy(labels: tuple[str, ...], stamps: NDArray[np.int64], values: Floats) -> list[bytes | None]:
    """Axes and buttons that the log has not got are at rest."""
    from forest_msgs_py.interfaces.messages import ns_to_stamp
    from forest_msgs_py.serialization.cdr import to_cdr

    names = list(signal_units(JOY))
    kind: Any = message_class(JOY)
    encoded: list[bytes | None] = []
    for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True):
        whole = dict.fromkeys(names, 0.0) | dict(zip(labels, row, strict=True))
        numbers = list(whole.values())
        message = kind(axes=numbers[: len(JOY_AXES)], buttons=[round(x) for x in numbers[len(JOY_AXES) :]])
        message.header.stamp = ns_to_stamp(stamp)
        encoded.append(to_cdr(message))
    assert len(names) == len(JOY_AXES) + len(JOY_BUTTONS)
    return encoded


def summary(log: MeasuredLog, mapping: LogMap, counts: dict[str, int]) -> str:
    """Say how regular the log is, and what became of it."""
    intervals = log.intervals()
    span = (int(log.times_ns[-1]) - int(log.times_ns[0])) / NS_PER_S
    lines = [f"{len(log.times_ns)} rows, {span:.3f} s"]
    if len(intervals):
        place = int(np.argmax(intervals))
        when, line = log.times_ns[place] / NS_PER_S, log.lines[place + 1]
        low, high = 1e3 * np.percentile(intervals, (5, 95))
        lines += [
            f"median rate {log.rate():.4g} Hz, 90 % of the intervals {low:.4g} .. {high:.4g} ms",
            f"longest interval {1e3 * intervals[place]:.4g} ms, from {when:.3f} s on (line {line})",
        ]
    for topic, signals in mapping.topics.items():
        missing = int(np.isnan(log.values[topic][1]).sum())
        told = f", {missing} cells empty" if missing else ""
        lines.append(f"/{topic.name}: {counts[f'/{topic.name}']} messages of {', '.join(signals)}{told}")
    return "\n".join(lines)
