"""Faults that only processes can show: what is done to a live crane, what must happen, and the table of it.

Times count from the fault to the last open voltage. What the computer kept from the processes meanwhile is
taken off: they were ready to run, and it ran others.
"""

from __future__ import annotations

import json
import math
import os
import re
import resource
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from graph_processes import kill
from live_crane import LiveCrane, Outcome

NEVER = math.inf
BEGINS, LASTS = 3.3, 1.0  # [s] the fault begins up to LASTS later than BEGINS, by chance
FOUND = 2.5  # [s] until a second node of a name is found: it starts, and the supervisor looks once a second
WAY = 0.6  # [m] of the tip, in any cell in which it stops
ENDING = signal.SIGKILL, signal.SIGINT, signal.SIGTERM
LOGGED = re.compile(r"\[\w+\] \[[\d.]+\] |^graph: |^warning: | in ROS domain.*|/tmp/\S+ ?")
NODES = {  # in the order of the data; seconds to zero voltage once a node is gone or hangs
    "joystick": 0.41,  # joy_timeout 0.15 s, then the stop along the path
    "controller": 0.11,  # command_timeout, and a period
    "valve_driver": 0.02,  # what it does not say it cannot hold open; the machine's own timeout is 0.1 s
    "simulator": 0.21,  # state_timeout and command_timeout, and a period
}
HOG = "import os; os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))\nwhile True: pass"
SHOUTER = str(Path(__file__).with_name("shouter.py"))


class Cell(NamedTuple):
    """A fault, and what must happen."""

    text: str  # what is done
    do: Callable[[LiveCrane, float], float]  # given 0 .. 1 by chance; returns when it heals [s, time.time]
    zero: float | None  # [s] to zero voltage; None: the crane moves on
    told: str = ""  # what a sentence of log or /diagnostics holds; "": none is asked
    code: int | None = 0  # exit code of the graph; None: there is no supervisor
    again: bool = True  # it moves after the deliberate act


def supervised(act: Callable[[LiveCrane], float]) -> Callable[[LiveCrane, float], float]:
    """Return what does something to a graph in motion; `act` returns for how long it lasts [s]."""

    def do(crane: LiveCrane, chance: float) -> float:
        crane.start_graph()
        crane.until_time(BEGINS + LASTS * chance)
        crane.until_moving()
        crane.begin()
        lasts = act(crane)
        healed = time.time() + lasts
        if crane.graph.poll() is None:
            crane.until_acted()
        return healed

    return do


def signalled(node: str, number: signal.Signals) -> Callable[[LiveCrane, float], float]:
    """Return what sends a signal to a node; who was frozen goes on a second later."""

    def act(crane: LiveCrane) -> float:
        victim = crane.pids()[node]
        kill(victim, number)
        if number == signal.SIGSTOP:
            wait(crane, LASTS)
            kill(victim, signal.SIGCONT)
            return 0.0
        goes_on = node == "recorder" or (node == "joystick" and number != signal.SIGKILL)
        if not goes_on:  # a joystick that ends well has played to its end
            crane.until(lambda: crane.graph.poll() is not None)
        return NEVER

    return supervised(act)


def wait(crane: LiveCrane, seconds: float) -> None:
    """Let a time pass, in which the crane is listened to."""
    end = time.monotonic() + seconds
    crane.until(lambda: time.monotonic() >= end)


def second(node: str) -> Callable[[LiveCrane, float], float]:
    """Return what starts a second node of a name."""

    def act(crane: LiveCrane) -> float:
        more = ("-p", f"output:={crane.folder / 'second'}") if node == "recorder" else ()
        crane.start_node(node, *more)
        if node != "recorder":
            crane.until(lambda: crane.graph.poll() is not None)
        return NEVER

    return supervised(act)


def rival(topic: str, rate_hz: float) -> Callable[[LiveCrane, float], float]:
    """Return what has a stranger talk on a topic for a second."""

    def act(crane: LiveCrane) -> float:
        stranger = crane.start([SHOUTER, topic, str(rate_hz)])
        crane.until(lambda: "shouting" in stranger.text())
        crane.begin()
        wait(crane, LASTS)
        assert stranger.stop() == 0, stranger.text()
        return 0.0

    return supervised(act)


def full_disk(crane: LiveCrane) -> float:
    """Let the recorder's files grow no more: the kernel refuses as it refuses a full disk."""
    size = max(path.stat().st_size for path in (crane.folder / "bag").iterdir())
    resource.prlimit(crane.pids()["recorder"], resource.RLIMIT_FSIZE, (size, size))
    return NEVER


def no_memory(crane: LiveCrane) -> float:
    """Let the controller have no more memory than it has."""
    pid = crane.pids()["controller"]
    has = int(Path(f"/proc/{pid}/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.prlimit(pid, resource.RLIMIT_AS, (has, resource.RLIM_INFINITY))
    wait(crane, LASTS)
    resource.prlimit(pid, resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    return 0.0


def hogs(crane: LiveCrane) -> float:
    """Keep every processor busy for a second, twice over."""
    busy = [crane.start(["-c", HOG]) for _ in range(2 * (os.cpu_count() or 1))]
    wait(crane, LASTS)
    for one in busy:
        one.kill_group()
    return 0.0


def by_hand(order: Sequence[Sequence[str]], pause: float) -> Callable[[LiveCrane, float], float]:
    """Return what starts groups of nodes by hand, one after the other; the fault is the start of the last."""

    def do(crane: LiveCrane, _chance: float) -> float:
        for number, names in enumerate(order):
            if number:
                wait(crane, pause)
            crane.begin()
            for name in names:
                crane.start_node(name)
        crane.until_acted()
        return time.time()

    return do


def restarted(node: str) -> Callable[[LiveCrane, float], float]:
    """Return what kills a node without a supervisor, and starts it anew at once."""

    def do(crane: LiveCrane, chance: float) -> float:
        for name in ("simulator", "valve_driver", "controller", "recorder"):
            crane.start_node(name)
        crane.until(lambda: crane.ears.volts and crane.ears.tips)
        crane.start_node("joystick")
        crane.until_time(BEGINS + LASTS * chance)
        crane.until_moving()
        crane.begin()
        crane.processes[node].stop(signal.SIGKILL)
        crane.start_node(node, *(("-p", f"output:={crane.folder / 'anew'}") if node == "recorder" else ()))
        healed = time.time() + LASTS  # it is there sooner; nothing moves before a deliberate act
        crane.until_acted()
        return healed

    return do


def cells() -> dict[str, Cell]:
    """Return the table of live faults."""
    return {**of_nodes(), **of_others()}


def of_nodes() -> dict[str, Cell]:
    """Return what happens to a node."""
    found = dict[str, Cell]()
    for node, zero in NODES.items():
        others = [name for name in NODES if name != node]
        for number in ENDING:
            found[f"{node}: {number.name}"] = Cell(
                f"{number.name} to the {node}", signalled(node, number), zero, node, 1, again=False
            )
        found[f"{node}: SIGSTOP"] = Cell(
            f"the {node} stands still for a second", signalled(node, signal.SIGSTOP), zero
        )
        found[f"{node}: twice"] = Cell(
            f"a second {node} is started", second(node), FOUND, f"a second node {node}", 1, again=False
        )
        found[f"{node}: first"] = Cell(
            f"all but the {node} start 1 s later", by_hand([[node], others], 1.0), None, code=None
        )
        found[f"{node}: last"] = Cell(
            f"the {node} starts 4 s after the others", by_hand([others, [node]], 4.0), 0.0, code=None
        )
        found[f"{node}: restarted"] = Cell(
            f"the {node} is killed, and started anew", restarted(node), zero, code=None
        )
    for number in (signal.SIGINT, signal.SIGTERM):
        name = f"joystick: {number.name}"
        found[name] = found[name]._replace(told="played to its end", code=0)
    for name in ("joystick: last", "controller: last"):  # the joystick waits for the controller, then plays
        found[name] = found[name]._replace(zero=None)
    late = "valve_driver: last"  # until it comes joints stand that are told to move: a fault of their sensors
    found[late] = found[late]._replace(told="release the deadman", again=False)
    del found["joystick: restarted"]  # it plays anew, from centred levers
    goes_on = "the graph goes on without it"
    for number in ENDING:
        found[f"recorder: {number.name}"] = Cell(
            f"{number.name} to the recorder",
            signalled("recorder", number),
            None,
            goes_on if number == signal.SIGKILL else "",
            1 if number == signal.SIGKILL else 0,
        )
    found["recorder: SIGSTOP"] = Cell(
        "the recorder stands still for a second", signalled("recorder", signal.SIGSTOP), None
    )
    found["recorder: twice"] = Cell("a second recorder is started", second("recorder"), None)
    found["recorder: restarted"] = Cell(
        "the recorder is killed, and started anew", restarted("recorder"), None, code=None
    )
    return found


def of_others() -> dict[str, Cell]:
    """Return what happens beside the nodes."""
    several = "more than one node publishes"
    stopped = {"told": several, "again": False}
    return {
        "two joysticks": Cell("a stranger's /joy at rest, 20 Hz", rival("joy", 20.0), 0.3),
        "flood": Cell("a stranger's /joy at rest, 10 kHz", rival("joy", 10_000.0), 0.3),
        "two controllers": Cell(
            "a stranger's /valve_commands of 3 V, 20 Hz", rival("valve_commands", 20.0), 0.15, **stopped
        ),
        "two drivers": Cell(
            "a stranger's /valve_voltages of 3 V, 20 Hz", rival("valve_voltages", 20.0), 0.15, **stopped
        ),
        "two machines": Cell(
            "a stranger's /joint_states that stand, 20 Hz", rival("joint_states", 20.0), 0.15, several
        ),
        "disk full": Cell("the recorder's files cannot grow", supervised(full_disk), None, "cannot write", 1),
        "no memory": Cell("the controller gets no more memory, for a second", supervised(no_memory), None),
        "hogs": Cell("twice as many busy processes as processors, for a second", supervised(hogs), math.inf),
    }


def broken(cell: Cell, one: Outcome) -> list[str]:
    """Return what an outcome breaks, in sentences."""
    zero = one.zero - one.waited
    checks = (
        (cell.zero is None and not math.isinf(one.zero), f"the crane stopped after {one.zero:.2f} s"),
        (
            cell.zero is not None and zero > cell.zero,
            f"open for {one.zero:.2f} s, of which {one.waited:.2f} s waited; allowed: {cell.zero} s",
        ),
        (cell.zero is not None and one.way > WAY, f"the tip went {one.way:.2f} m; allowed: {WAY:g} m"),
        (one.restarted, "it moved again without a deliberate act"),
        (cell.again and not one.again, "it did not move after the deliberate act"),
        (one.code != cell.code, f"exit code {one.code}; wanted: {cell.code}"),
        (
            bool(cell.told) and not any(cell.told in said for said in one.told),
            f"nobody is told {cell.told!r}, but {one.told}",
        ),
        (bool(one.orphans), f"{', '.join(one.orphans)} outlived the graph"),
        (one.traceback, "a traceback was printed"),
    )
    return [sentence for wrong, sentence in checks if wrong]


def table(found: Mapping[str, Sequence[Outcome]]) -> str:
    """Return the table in Markdown: of each cell the worst repetition."""
    head = ("fault", "what is done", "must", "zero, s", "of it waited, s", "way, m", "lost", "told")
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for name, cell in cells().items():
        if name not in found:
            continue
        worst = max(found[name], key=lambda one: one.zero - one.waited)
        ways = [one.way for one in found[name] if cell.zero is not None and not math.isnan(one.way)]
        told = next((said for said in worst.told if cell.told and cell.told in said), "")
        row = (
            f"**{name}**" if any(broken(cell, one) for one in found[name]) else name,
            *(cell.text, _must(cell)),
            "moves on" if math.isinf(worst.zero) else f"{worst.zero:.2f}",
            "" if math.isinf(worst.zero) else f"{worst.waited:.2f}",
            f"{max(ways):.2f}" if ways else "",
            f"{max(one.lost for one in found[name])}",
            LOGGED.sub("", told).replace("|", "/"),
        )
        lines.append(f"| {' | '.join(row)} |")
    return "\n".join(lines)


def _must(cell: Cell) -> str:
    if cell.zero is None:
        return "moves on"
    if math.isinf(cell.zero):
        return "may stop"
    zero = f"zero in {cell.zero:g} s" if cell.zero else "stays at zero"
    return zero + (", the graph ends" if cell.code == 1 else "")


PAGE = """
## Live

The same crane as processes, a graph of its own for each row; the worst of {count} repetitions. The
levers rock the swing, and are never centred until they rest on purpose.

- Zero counts at the valves' topic, without a stranger's voltages. Time in which threads waited for
  a processor is told, and not held against them.
- No row leaves a process behind, or prints a traceback. A tip that is stopped goes 0.6 m at most.
- Before the deliberate act, centred levers, nothing moves again. After it the crane moves, unless
  its graph has ended, an emergency stop is latched, or the deadman is to be released.
- A fault in **bold** broke its bound.
- `lost` counts messages of the machine's state.
- In other states the same holds as offline: who is killed or hangs is silent to the others.

{table}
"""


def page(rows: Sequence[str]) -> str:
    """Return the section of the page, of rows of JSON."""
    found: dict[str, list[Outcome]] = {}
    for name, outcome in map(json.loads, rows):
        found.setdefault(name, []).append(Outcome(*outcome))
    return PAGE.format(count=min(map(len, found.values())), table=table(found))


if __name__ == "__main__":
    print(page(Path(sys.argv[1]).read_text("utf-8").splitlines()))
