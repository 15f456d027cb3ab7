"""Whether a recorder's memory stays the same over a day at the demo's rates, in a fraction of the day.

A recorded session is written again and again through the recorder's own `Session`, its times moved on, with
the recorder's files of an hour and its flushes of 0.1 s. Files that are done are deleted: a day is 40 GB.

    python benchmarks/recording_day.py [--hours 24] [--bag bags/coordinated] [--compression none]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.mcap_chunk import COMPRESSIONS
from forest_bag.write.bag_session import Session
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import FLUSH_PERIOD_S
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import JOY

NS = 1_000_000_000
HOUR_NS = 3600 * NS
BAG = Path(__file__).parents[1] / "bags" / "coordinated"


def resident_mb() -> float:
    """Return this process' resident memory."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


def load(bag: Path) -> tuple[list[tuple[str, bytes, int, int]], dict[str, str], int]:
    """Return messages (topic, bytes, time from the first [ns], sequence), topics' types, and length [ns]."""
    with BagReader(bag) as reader:
        begun, ended = reader.span
        found = [(m.channel.topic, m.data, m.log_ns - begun, m.sequence) for m in reader.messages()]
        types = {name: channels[0].type for name, channels in reader.channels.items()}
    return found, types, ended - begun


def record(directory: Path, bag: Path, hours: float, compression: str) -> None:
    """Write so many hours; print a line for each."""
    messages, types, length = load(bag)
    session = Session(directory / "day", Layout(compression, 0, HOUR_NS))
    for name, kind in types.items():
        session.add_topic(name, kind, [offered_qos(JOY)], "")
    session.start()
    flushed, hour, offset, begun, written = 0, 0, 0, time.process_time(), 0
    print(
        f"start: {resident_mb():.1f} MB, {len(messages) * NS / length:.0f} messages/s on {len(types)} topics",
        flush=True,
    )
    while offset < hours * HOUR_NS:
        for topic, data, log_ns, sequence in messages:
            now = offset + log_ns
            session.write(topic, data, now, now, sequence)
            if now - flushed > FLUSH_PERIOD_S * NS:
                session.flush()
                flushed = now
        written, offset = written + len(messages), offset + length
        if offset // HOUR_NS > hour:
            hour = offset // HOUR_NS
            for file in sorted(session.directory.glob("*.mcap"))[:-1]:
                file.unlink()
            used = time.process_time() - begun
            print(f"{hour} h: {resident_mb():.1f} MB, {written} messages, {used:.0f} s CPU", flush=True)
    session.stop()
    print(f"stop: {resident_mb():.1f} MB")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--bag", type=Path, default=BAG)
    parser.add_argument("--compression", choices=COMPRESSIONS, default="none")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        record(Path(directory), options.bag, options.hours, options.compression)


if __name__ == "__main__":
    main()
