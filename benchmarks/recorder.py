"""What recording costs: processor time per message, beside a node that throws the bytes away.

One talker publishes three topics of serialized JointState at 3 kHz each, one after the other to

- ``bare``: a node with three raw subscriptions whose callbacks do nothing, spun by rclpy,
- ``polled``: the same, but looking every 10 ms for what has arrived, as the recorder does,
- ``recorder``: `forest-bag record`, compressed or not; its bag is counted afterwards.

Processor time is that of the whole process, read from /proc while the talker talks: start and end do not
count. Messages are those that the listener took.

    python benchmarks/recorder.py [--seconds 10] [--rate 3000] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

TOPICS = ("fast_1", "fast_2", "fast_3")
DOMAIN = "73"
WARM_UP = 2.0  # [s] for discovery
QUEUE = 10_000
LISTENERS = ("bare", "polled", "recorder none", "recorder lz4", "recorder zstd")


def talk(seconds: float, rate: float) -> None:
    """Publish until the time is over; say when it began and how many there were."""
    import rclpy
    from sensor_msgs.msg import JointState

    from forest_msgs_py.interfaces import messages
    from forest_msgs_py.serialization.cdr import to_cdr

    rclpy.init()
    node = rclpy.create_node("talker")
    publishers = [node.create_publisher(JointState, topic, QUEUE) for topic in TOPICS]
    while not all(publisher.get_subscription_count() for publisher in publishers):
        time.sleep(0.01)
    time.sleep(WARM_UP)
    data = to_cdr(messages.joint_state(("swing", "boom", "stick"), 1, (1.0, 2.0, 3.0)))
    print("begin", flush=True)
    begin, sent, total = time.monotonic(), 0, int(seconds * rate)
    while sent < total:
        due = min(total, int((time.monotonic() - begin) * rate))
        for _ in range(sent, due):
            for publisher in publishers:
                publisher.publish(data)
        sent = due
        time.sleep(0.3 / rate)
    print("end", flush=True)
    time.sleep(1.0)
    print(len(TOPICS) * sent, flush=True)


def listen(polled: bool) -> None:
    """Throw bytes away until a signal comes; say how many messages there were."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.qos import QoSProfile
    from sensor_msgs.msg import JointState

    from forest_msgs_py.runtime.polled_subscription import PolledSubscription

    rclpy.init()
    node = rclpy.create_node("listener")
    count = 0

    def callback(_data: bytes) -> None:
        nonlocal count
        count += 1

    try:
        if polled:
            inboxes = [
                PolledSubscription(node, JointState, topic, QoSProfile(depth=QUEUE), raw=True)
                for topic in TOPICS
            ]
            while rclpy.ok():
                count += sum(1 for inbox in inboxes for _ in inbox.take())
                time.sleep(0.01)
        for topic in TOPICS:
            node.create_subscription(JointState, topic, callback, QUEUE, raw=True)
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    print(count, flush=True)


def processor_time(pid: int) -> float:
    """Return what a process has used until now [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid: int) -> float:
    """Return a process' resident memory."""
    text = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


def measure(listener: str, seconds: float, rate: float, folder: Path) -> dict[str, Any]:
    """Run talker and listener; return a row of the table."""
    kind, _, compression = listener.partition(" ")
    bag = folder / f"bag_{compression}"
    command = [sys.executable, __file__, "--role", kind]
    if kind == "recorder":
        command = [sys.executable, "-m", "forest_bag.cli.main", "record", "-o", str(bag)]
        command += ["--compression", compression, "--topics", *(f"/{topic}" for topic in TOPICS)]
    hearing = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    talking = subprocess.Popen(
        [sys.executable, __file__, "--role", "talk", "--seconds", str(seconds), "--rate", str(rate)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert talking.stdout is not None
    talking.stdout.readline()
    before, memory = processor_time(hearing.pid), memory_mb(hearing.pid)
    talking.stdout.readline()
    sent = int(talking.stdout.readline())
    used, grown = processor_time(hearing.pid) - before, memory_mb(hearing.pid) - memory
    talking.wait()
    hearing.send_signal(signal.SIGINT)
    output, _ = hearing.communicate()
    heard = recorded(bag) if kind == "recorder" else int(output.split()[-1])
    return {
        "listener": listener,
        "sent": sent,
        "heard": heard,
        "microseconds_per_message": 1e6 * used / max(1, heard),
        "memory_growth_mb": grown,
    }


def recorded(bag: Path) -> int:
    """Return how many messages of the talker a bag holds, by mcap's own reader."""
    from mcap.reader import NonSeekingReader

    count = 0
    for file in bag.glob("*.mcap"):
        with file.open("rb") as stream:
            messages = NonSeekingReader(stream).iter_messages(log_time_order=False)
            count += sum(channel.topic.lstrip("/") in TOPICS for _, channel, _ in messages)
    return count


def table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as Markdown; the last column compares with the bare node."""
    bare = rows[0]["microseconds_per_message"]
    lines = [
        "| listener | sent | lost | µs per message | times bare | memory grows |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        cost, lost = row["microseconds_per_message"], row["sent"] - row["heard"]
        cells = (row["listener"], row["sent"], lost, f"{cost:.1f}", f"{cost / bare:.2f}")
        lines.append(f"| {' | '.join(map(str, cells))} | {row['memory_growth_mb']:.1f} MB |")
    return "\n".join(lines)


def main() -> None:
    """Measure every listener and print the table."""
    parser = argparse.ArgumentParser(description="Processor time per recorded message.")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rate", type=float, default=3000.0, help="of each of the three topics [Hz]")
    parser.add_argument("--listeners", nargs="+", choices=LISTENERS, default=LISTENERS)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--role", choices=("talk", "bare", "polled"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.role == "talk":
        return talk(options.seconds, options.rate)
    if options.role:
        return listen(options.role == "polled")
    os.environ.setdefault("ROS_DOMAIN_ID", DOMAIN)
    with tempfile.TemporaryDirectory(prefix="forest-recorder-") as folder:
        rows = [measure(kind, options.seconds, options.rate, Path(folder)) for kind in options.listeners]
    print(table(rows))
    if options.json:
        options.json.write_text(json.dumps({"rows": rows}, indent=2) + "\n", encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
