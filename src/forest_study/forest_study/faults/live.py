"""Faults that only processes can show: each node of a live graph is killed, frozen, interrupted, terminated.

The levers rock the swing. A recorder of its own, outside of the graph, is the witness. What the computer kept
from the processes meanwhile is no fault of theirs, and is told beside (`waited`).
"""

import contextlib
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from forest_bag.read.timeseries import Bag, read_bag
from forest_bringup import graph
from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.live_graph import LiveGraph
from forest_msgs_py.runtime.environment import prepare_environment

NODES = {"joystick": 0.65, "controller": 0.2, "valve_driver": 0.2, "simulator": 0.35, "recorder": None}
"""Seconds from a node's end or freezing to zero voltage, at most; None: the graph goes on."""
SIGNALS = signal.SIGKILL, signal.SIGSTOP, signal.SIGINT, signal.SIGTERM
MET, ENDS, LISTENED = 30.0, 20.0, 2.5  # [s] until the graph moves; until it ends; after the fault
ROCKING = 0.4, 2.0  # [1] amplitude, [s] period of the swing's lever
NS = 1_000_000_000


class LiveOutcome(NamedTuple):
    """What came of a signal."""

    node: str
    number: str
    zero: float  # [s] from the signal to the last voltage that is not zero; infinite: it moves on
    waited: float  # [s] that the graph's threads waited for a processor meanwhile, in sum
    code: int  # exit code of the graph
    said: str  # its last line that names the node
    orphans: int
    traceback: bool
    lost: int  # messages, as the witness counts


def levers(directory: Path) -> Path:
    """Write levers that rock the swing for a minute, and never rest."""
    amplitude, period = ROCKING
    rows = [
        f"{k / 10:.1f},{amplitude * math.sin(2.0 * math.pi * k / 10 / period):.4f},0,0.05" for k in range(600)
    ]
    path = directory / "rocking.csv"
    path.write_text("\n".join(["time_s,swing,boom,stick", *rows, ""]), encoding="utf-8")
    return path


@contextlib.contextmanager
def process(module: str, arguments: Sequence[str], log: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Give a process of a session of its own, of which nothing is left afterwards."""
    with log.open("wb") as said:
        started = subprocess.Popen(
            [sys.executable, "-m", module, *arguments], stdout=said, stderr=said, start_new_session=True
        )
    try:
        yield started
    finally:
        if started.poll() is None:
            started.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            started.wait(ENDS)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(started.pid, signal.SIGKILL)
        started.wait()


def nodes_of(supervisor: int) -> dict[str, int]:
    """Return a supervisor's nodes and their process numbers."""
    found = dict[str, int]()
    for entry in Path("/proc").iterdir():
        with contextlib.suppress(OSError):
            if not entry.name.isdigit() or _parent(entry) != supervisor:
                continue
            words = {
                word.decode().rpartition(".")[2] for word in (entry / "cmdline").read_bytes().split(b"\0")
            }
            found |= {name: int(entry.name) for name in NODES if f"{name}_node" in words}
    return found


def _parent(entry: Path) -> int:
    return int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])


def waited(pids: Sequence[int]) -> float:
    """Return how long the threads of processes have waited for a processor so far [s]."""
    total = 0
    for pid in pids:
        with contextlib.suppress(OSError, IndexError):
            for task in Path(f"/proc/{pid}/task").iterdir():
                with contextlib.suppress(OSError):
                    total += int((task / "schedstat").read_text().split()[1])
    return total / NS


def signalled(node: str, number: signal.Signals, seed: int, directory: Path) -> LiveOutcome:
    """Return what comes of a signal to a node in motion; a new directory keeps bags and logs."""
    directory.mkdir(parents=True)
    prepare_environment()
    log, witness = directory / "graph.txt", graph.recorder(directory / "witness")
    options = ["--joystick", str(levers(directory)), "--record", str(directory / "bag")]
    asker = LiveGraph("/")
    try:
        with process("forest_bringup.graph", options, log) as running:
            _until(lambda: len(nodes_of(running.pid)) == len(NODES))
            with process(witness.module, witness.arguments, directory / "witness.txt"):
                asker.wait_for_message(topics.VALVE_VOLTAGES, lambda said: any(said.data[2:]), MET)
                time.sleep(1.0 + float(np.random.default_rng(seed).random()))
                nodes = nodes_of(running.pid)
                before, sent = waited([running.pid, *nodes.values()]), time.time_ns()
                os.kill(nodes[node], number)
                end = time.monotonic() + LISTENED
                while running.poll() is None and time.monotonic() < end:
                    time.sleep(0.05)
                after = waited([running.pid, *(pid for pid in nodes.values() if _alive(pid))])
                if running.poll() is None:
                    running.send_signal(signal.SIGINT)
                code = running.wait(ENDS)
            orphans = sum(_alive(pid) for pid in nodes.values())
    finally:
        asker.close()
    text = log.read_text(errors="replace")
    bag = read_bag(directory / "witness")
    return LiveOutcome(
        node=node,
        number=number.name,
        zero=_zero(bag, sent),
        waited=max(0.0, after - before),
        code=code,
        said=next((line for line in reversed(text.splitlines()) if node in line), ""),
        orphans=orphans,
        traceback="Traceback" in text,
        lost=sum(info.lost for info in bag.topics.values()),
    )


def _until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + MET
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"the graph is not there within {MET:g} s")
        time.sleep(0.05)


def _alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def _zero(bag: Bag, sent: int) -> float:
    """Return when the last open voltage was said after a time [ns], in s; infinite: it moves on."""
    series, said = bag.series(topics.VALVE_VOLTAGES), bag.sent_ns(topics.VALVE_VOLTAGES)
    opened = said[series.values.any(axis=1)]
    if not opened.size or opened[-1] <= sent:
        return 0.0
    after = float(opened[-1] - sent) / NS
    return math.inf if after > 0.8 * LISTENED else after


def live_faults(
    out: Path, repetitions: int, nodes: Sequence[str], progress: Callable[[str], None]
) -> list[LiveOutcome]:
    """Send every signal to every node, again and again; each has a directory for bags and logs."""
    found = list[LiveOutcome]()
    for repetition in range(repetitions):
        for node in nodes:
            for number in SIGNALS:
                name = f"{node}-{number.name}-{repetition}"
                found.append(signalled(node, number, 100 * repetition + len(found), out / name))
                progress(f"{name}: {found[-1]}")
    return found


def broken(one: LiveOutcome) -> list[str]:
    """Return what an outcome breaks, in sentences."""
    bound, found = NODES[one.node], []
    if bound is not None and one.zero - one.waited > bound:
        found.append(
            f"voltages for {one.zero:.2f} s, of which it waited {one.waited:.2f} s; allowed: {bound:g} s"
        )
    if bound is None and not math.isinf(one.zero):
        found.append("the crane stopped; a recorder may end")
    if one.orphans:
        found.append(f"{one.orphans} nodes outlived the graph")
    if one.traceback:
        found.append("a traceback was printed")
    return [f"{one.node}, {one.number}: {text}" for text in found]


def table(outcomes: Sequence[LiveOutcome]) -> str:
    """Return the live table in Markdown: the worst of the repetitions."""
    lines = ["| node | signal | must | zero, s | host took, s | graph's code | said |", "|---" * 7 + "|"]
    for node, bound in NODES.items():
        for number in SIGNALS:
            of = [one for one in outcomes if (one.node, one.number) == (node, number.name)]
            if of:
                worst = max(of, key=lambda one: one.zero - one.waited)
                must = "moves on" if bound is None else f"zero in {bound:g} s"
                zero = "moves on" if math.isinf(worst.zero) else f"{worst.zero:.2f}"
                codes = ", ".join(sorted({str(one.code) for one in of}))
                cells = (node, number.name, must, zero, f"{worst.waited:.2f}", codes, worst.said or "nothing")
                lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
