"""How well `forest-bag play` keeps the times: how late messages are, beside a bare timer in the same run.

A bag with the demo's load (15 topics of 200 Hz) is played at rate 1. Measured are

- ``player``: what the player itself says (``--stats``): handing over minus due time,
- ``readers``: from outside, source timestamps of what a listener received against the bag's log times;
  the earliest message counts as punctual,
- ``timer``: a loop that only waits for the same due times, in a process of its own, meanwhile: what this
  machine and its other work leave to anybody.

    python benchmarks/player.py [--seconds 10] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

TOPICS, RATE_HZ, BYTES = 15, 200, 150
DOMAIN = "74"
SHARES = (50, 99, 99.9, 100)  # of the messages [%]


def write_bag(directory: Path, seconds: float) -> int:
    """Write the bag; return its number of messages."""
    from forest_bag.write.bag_writer import BagWriter
    from forest_msgs_py.interfaces.topic_qos import offered_qos
    from forest_msgs_py.interfaces.topics import JOY

    writer = BagWriter(directory)
    names = [f"/load_{number}" for number in range(TOPICS)]
    for name in names:
        writer.add_topic(name, "std_msgs/msg/String", [offered_qos(JOY)], "")
    count = int(seconds * RATE_HZ)
    text = (BYTES + 1).to_bytes(4, "little") + b"x" * BYTES + b"\0"
    for step in range(count):
        for number, name in enumerate(names):  # spread over the period, as nodes are
            stamp = 10**18 + (step * TOPICS + number) * 10**9 // (RATE_HZ * TOPICS)
            writer.write(name, b"\0\1\0\0" + text, stamp, stamp, step + 1)
    writer.close()
    return count * TOPICS


def listen(count: int) -> None:
    """Collect source timestamps of all messages; print lateness in ms."""
    import rclpy
    from rclpy.qos import QoSProfile
    from std_msgs.msg import String

    from forest_msgs_py.runtime.polled_subscription import PolledSubscription

    rclpy.init()
    node = rclpy.create_node("listener")
    inboxes = [
        PolledSubscription(node, String, f"/load_{n}", QoSProfile(depth=count), raw=True)
        for n in range(TOPICS)
    ]
    stamps: list[list[int]] = [[] for _ in inboxes]
    print("ready", flush=True)
    end = None
    while end is None or time.monotonic() < end:
        for inbox, found in zip(inboxes, stamps, strict=True):
            new = [info["source_timestamp"] for _, info in inbox.take()]
            found += new
            if new:
                end = time.monotonic() + 2.0
        time.sleep(0.05)
    late = []
    for number, found in enumerate(stamps):
        due = (np.arange(len(found)) * TOPICS + number) / (RATE_HZ * TOPICS)
        late.append((np.array(found) - stamps[0][0]) * 1e-9 - due)
    everything = np.concatenate(late)
    print(
        json.dumps({"heard": len(everything), "late_ms": shares(everything - everything.min())}), flush=True
    )


def shares(late_s: np.ndarray) -> dict[str, float]:
    """Lateness [ms] that shares of the messages do not exceed."""
    return {f"p{share:g}": round(1e3 * float(np.percentile(late_s, share)), 3) for share in SHARES}


def wait_only(seconds: float) -> dict[str, float]:
    """What a bare timer reaches."""
    condition, late = threading.Condition(), []
    begin = time.monotonic()
    with condition:
        for step in range(int(seconds * RATE_HZ)):
            due = begin + step / RATE_HZ
            while (left := due - time.monotonic()) > 0:
                condition.wait(left)
            late.append(time.monotonic() - due)
    return shares(np.array(late))


def measure(seconds: float) -> dict[str, object]:
    """Run all three side by side."""
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        count = write_bag(bag, seconds)
        own = [sys.executable, __file__, "--part"]
        listener = subprocess.Popen([*own, f"listen {count}"], stdout=subprocess.PIPE, text=True)
        assert listener.stdout is not None
        listener.stdout.readline()
        command = [
            sys.executable,
            "-m",
            "forest_bag.cli.main",
            "play",
            str(bag),
            "--stats",
            "--wait-for-subscribers",
        ]
        player = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        timer = subprocess.Popen([*own, f"timer {seconds}"], stdout=subprocess.PIPE, text=True)
        said = player.communicate()[1]
        heard = json.loads(listener.communicate()[0])
        found = re.search(r"p50 ([\d.]+), p99 ([\d.]+), p99.9 ([\d.]+), at most ([\d.]+) ms", said)
        assert found is not None, said
        return {
            "messages": count,
            "heard": heard["heard"],
            "player": dict(zip([f"p{share:g}" for share in SHARES], map(float, found.groups()), strict=True)),
            "readers": heard["late_ms"],
            "timer": json.loads(timer.communicate()[0]),
        }


def main() -> None:
    """Measure and print."""
    import os

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--part", help=argparse.SUPPRESS)
    options = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = DOMAIN
    from forest_msgs_py.runtime.environment import prepare_environment

    prepare_environment()
    if options.part:
        what, number = options.part.split()
        if what == "listen":
            listen(int(number))
        else:
            print(json.dumps(wait_only(float(number))))
        return
    result = measure(options.seconds)
    print(f"{result['messages']} messages, {result['heard']} heard; late by [ms]:")
    for name in ("player", "readers", "timer"):
        print(f"  {name:8} {result[name]}")
    if options.json:
        options.json.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
