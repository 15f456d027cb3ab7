"""What a live graph takes: how late a voltage answers a state, beside a bare relay; processor, memory, start.

`python benchmarks/graph_load.py [--seconds 20] [--hog]` runs the graph at 200 Hz with levers that rock the
swing, and beside it three processes of rclpy of which two hand on what the first says. The times are those
of publishing, from the recorder's bag. With the right to it (root) run it as `chrt --rr 1 python …`.
"""

import argparse
import contextlib
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

from graph_processes import nodes_of

from forest_bag.read.timeseries import Bag, read_bag
from forest_control.operator.joystick_sources import LEAD_IN
from forest_msgs_py.interfaces import topics

DOMAIN = 76
TICKS = os.sysconf("SC_CLK_TCK")
SETTLES = 4.0  # [s] that are left out
HOG = "import os; os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))\nwhile True: pass"
RELAY = """
import sys
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray
from forest_msgs_py.runtime.environment import prepare_environment
prepare_environment()
rclpy.init()
node, place = Node("relay_" + sys.argv[1]), int(sys.argv[1])
out = node.create_publisher(Float64MultiArray, f"relay_{place}", 10)
if place:
    node.create_subscription(Float64MultiArray, f"relay_{place - 1}", out.publish, 10)
else:
    count = iter(range(10**9))
    node.create_timer(0.005, lambda: out.publish(Float64MultiArray(data=[float(next(count)), 0.0, 0.0, 0.0])))
rclpy.spin(node)
"""


@contextlib.contextmanager
def started(arguments: list[str], log: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Give a process that ends with the block."""
    with log.open("wb") as out:
        process = subprocess.Popen([sys.executable, *arguments], stdout=out, stderr=out)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(20)


def processor(pid: int) -> float:
    """Return the processor time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def own_mb(pid: int) -> float:
    """Return the memory that is a process' own [MB]."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(text.split("RssAnon:")[1].split()[0]) / 1024


def delays(bag: Bag, first: str, last: str, by_stamp: bool) -> np.ndarray:
    """Return how long after a message of one topic its answer on another was published [s]."""
    sent: list[dict[int, int]] = []
    for name in (first, last):
        series = bag.series(name)
        keys = series.time_ns if by_stamp else series.values[:, 0].astype(int)
        sent.append(dict(zip(keys.tolist(), bag.sent_ns(name).tolist(), strict=True)))
    both = [(sent[1][key] - begun) * 1e-9 for key, begun in sent[0].items() if key in sent[1]]
    return np.array(both[round(SETTLES * 200) :])


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--hog", action="store_true", help="a busy process for each processor")
    options = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        rows = ["0,0,0,0"]  # at rest until every node is there
        rows += [f"{k / 10:.1f},{0.4 * math.sin(math.pi * k / 10):.4f},0,0.1" for k in range(20, 6000)]
        (folder / "levers.csv").write_text("\n".join(["time_s,swing,boom,stick", *rows, ""]))
        for k in range(3):
            stack.enter_context(started(["-c", RELAY, str(k)], folder / f"relay{k}"))
        begun = time.monotonic()
        words = ["-m", "forest_bringup.graph", "--joystick", str(folder / "levers.csv")]
        graph = stack.enter_context(started([*words, "--record", str(folder / "bag")], folder / "log"))
        while "recording to" not in (folder / "log").read_text() and time.monotonic() - begun < 30.0:
            time.sleep(0.05)
        for k in range((os.cpu_count() or 1) * options.hog):
            stack.enter_context(started(["-c", HOG], folder / f"hog{k}"))
        time.sleep(SETTLES)
        nodes = nodes_of(graph)
        before, at = {name: processor(pid) for name, pid in nodes.items()}, time.monotonic()
        time.sleep(options.seconds)
        seconds = time.monotonic() - at
        print("| node | of a processor, % | own memory, MB |\n|---|---|---|")
        shares = {name: (processor(pid) - before[name]) / seconds for name, pid in nodes.items()}
        for name, pid in nodes.items():
            print(f"| {name} | {100.0 * shares[name]:.0f} | {own_mb(pid):.0f} |")
        print(f"| all | {100.0 * sum(shares.values()):.0f} | |\n")
        stack.close()
        report(folder / "bag", begun)


def report(path: Path, begun: float) -> None:
    """Print delays and the first motion."""
    bag = read_bag(path)
    print("| from, to | median, ms | p99, ms | messages |\n|---|---|---|---|")
    for text, found in (
        ("state, voltage", delays(bag, "/joint_states", "/valve_voltages", True)),
        ("bare relay", delays(bag, "/relay_0", "/relay_2", False)),
    ):
        median, p99 = 1e3 * np.percentile(found, (50, 99))
        print(f"| {text} | {median:.2f} | {p99:.2f} | {len(found)} |")
    series = bag.series(topics.VALVE_VOLTAGES)
    opened = bag.sent_ns(topics.VALVE_VOLTAGES)[series.values.any(axis=1)][0] * 1e-9
    rest = 2.0 + LEAD_IN
    after = opened - (time.time() - time.monotonic()) - begun - rest
    print(f"\nfirst voltage {after:.2f} s after the start, the {rest:g} s left out that the levers rest")


if __name__ == "__main__":
    main()
