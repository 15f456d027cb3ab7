"""What a killed recorder loses: seconds of a topic between the last message in the bag and `kill -9`.

A talker publishes a serialized JointState of some 100 bytes at 1 kHz. A recorder beside it is killed at a
random moment after it has said "recording to", and mcap's own reader looks for the last message in what it
left. The time lost is between that message and the last that was published before the kill: what still
waited in the middleware counts, a talker that was kept from talking does not. Busy processes beside stand
for a loaded computer.

    python benchmarks/killed.py [--kills 40] [--rate 1000] [--load 0 4] [--json FILE]
"""

from __future__ import annotations

import argparse
import itertools
import json
import mmap
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from forest_msgs_py.runtime.environment import LOOPBACK_PROFILE, prepare_environment

TOPIC = "fast"
SHARED_MEMORY = "          <transport_id>shared_memory</transport_id>\n"  # as a transport in the profile
DOMAINS = itertools.cycle(range(60, 80))
QUEUE = 10_000
TOLD = "recording to"
BUSY = "while True: pass"
SEED = 12
PATIENCE = 120.0  # [s] for a recorder to begin


def talk(rate: float, clock: Path) -> None:
    """Publish until killed; a file tells when the last message was published [ns]."""
    import rclpy
    from sensor_msgs.msg import JointState

    from forest_msgs_py.interfaces import messages
    from forest_msgs_py.serialization.cdr import to_cdr

    prepare_environment()
    rclpy.init()
    publisher = rclpy.create_node("talker").create_publisher(JointState, TOPIC, QUEUE)
    data = to_cdr(messages.joint_state(("swing", "boom", "stick"), 1, (1.0, 2.0, 3.0)))
    begin, sent = time.monotonic(), 0
    with clock.open("r+b") as stream, mmap.mmap(stream.fileno(), 8) as last:
        while True:
            due = int((time.monotonic() - begin) * rate)
            for _ in range(sent, due):
                publisher.publish(data)
                last[:] = time.time_ns().to_bytes(8, "little")
            sent = due
            time.sleep(0.3 / rate)


@contextmanager
def running(
    commands: list[list[str]], environment: Mapping[str, str], output: TextIO
) -> Iterator[list[subprocess.Popen[bytes]]]:
    """Processes that are killed at the end, whatever happens."""
    started = [subprocess.Popen(one, env=environment, stdout=output, stderr=output) for one in commands]
    try:
        yield started
    finally:
        for process in started:
            process.kill()
            process.wait()


def kill_one(folder: Path, wait: float, rate: float) -> float | None:
    """Kill a recorder so long after its word [s]; return the seconds lost, None if the bag holds nothing."""
    clock, log, bag, profile = (folder / name for name in ("clock", "log", "bag", "profile.xml"))
    clock.write_bytes(bytes(8))
    # Not by shared memory: in what a killed process leaves of it, others of its domain wait for ever.
    profile.write_text(LOOPBACK_PROFILE.read_text().replace(SHARED_MEMORY, ""))
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(next(DOMAINS)),
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile),
    }
    talker = [sys.executable, __file__, "--role", "talk", "--rate", str(rate), "--clock", str(clock)]
    record = [sys.executable, "-m", "forest_bag.cli.main", "record", "-o", str(bag), "--topics", f"/{TOPIC}"]
    with log.open("w") as output, running([talker, record], environment, output) as (_, recorder):
        end = time.monotonic() + PATIENCE
        while TOLD not in log.read_text():
            if time.monotonic() > end or recorder.poll() is not None:
                raise RuntimeError(f"no recording began within {PATIENCE:g} s: {log.read_text()}")
            time.sleep(0.005)
        time.sleep(wait)
        sent_ns = int.from_bytes(clock.read_bytes(), "little")
        recorder.kill()
    last_ns = last_published(bag)
    return None if last_ns is None else max(0, sent_ns - last_ns) * 1e-9


def last_published(bag: Path) -> int | None:
    """Return the last publish time of the topic in a killed bag [ns], by mcap's own reader."""
    from mcap.exceptions import McapError
    from mcap.reader import NonSeekingReader

    last = None
    for file in bag.glob("*.mcap"):
        with file.open("rb") as stream:
            try:
                for _, _, message in NonSeekingReader(stream).iter_messages(
                    [f"/{TOPIC}"], log_time_order=False
                ):
                    last = message.publish_time
            except McapError:  # the file has no end
                pass
    return last


def measure(kills: int, first: float, span: float, load: int, rate: float) -> dict[str, Any]:
    """Kill many recorders; return a row of the table.

    Args:
        kills: how many.
        first: the earliest kill after the recorder's word [s].
        span: the latest one is so much later [s].
        load: busy processes beside.
        rate: of the topic [Hz].
    """
    moments = random.Random(SEED)
    busy = [[sys.executable, "-c", BUSY] for _ in range(load)]
    lost = []
    with Path(os.devnull).open("w") as nowhere, running(busy, os.environ, nowhere):
        for _ in range(kills):
            with tempfile.TemporaryDirectory(prefix="forest-killed-") as folder:
                lost.append(kill_one(Path(folder), first + moments.uniform(0.0, span), rate))
    return {"load": load, "first": first, "span": span, "lost": lost}


def table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| busy processes | killed after its word, s | kills | bag empty | half lost less, s | 95 % | most |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        lost = sorted(seconds for seconds in row["lost"] if seconds is not None)
        half, most = (statistics.median(lost), lost[-1]) if lost else (float("nan"),) * 2
        share = lost[min(len(lost) - 1, int(0.95 * len(lost)))] if lost else float("nan")
        cells = (row["load"], f"{row['first']:g} to {row['first'] + row['span']:g}", len(row["lost"]))
        figures = (len(row["lost"]) - len(lost), f"{half:.3f}", f"{share:.3f}", f"{most:.3f}")
        lines.append(f"| {' | '.join(map(str, (*cells, *figures)))} |")
    return "\n".join(lines)


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description="What a killed recorder loses.")
    parser.add_argument("--kills", type=int, default=40, help="per row")
    parser.add_argument("--rate", type=float, default=1000.0, help="of the topic [Hz]")
    parser.add_argument("--load", type=int, nargs="+", default=[0, 4], help="busy processes beside")
    parser.add_argument("--first", type=float, nargs="+", default=[0.0], help="earliest kills [s]")
    parser.add_argument("--span", type=float, default=1.5, help="of random moments after the earliest [s]")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--role", choices=("talk",), help=argparse.SUPPRESS)
    parser.add_argument("--clock", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.role:
        return talk(options.rate, options.clock)
    rows = []
    for load in options.load:
        for first in options.first:
            rows.append(measure(options.kills, first, options.span, load, options.rate))
            print(f"load average {os.getloadavg()[0]:.1f}", flush=True)
    print(table(rows))
    if options.json:
        options.json.write_text(json.dumps({"rows": rows}, indent=2) + "\n", encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
