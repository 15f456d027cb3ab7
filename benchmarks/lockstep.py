"""What a step in lockstep costs: processor time of each of the demo's five nodes, and time on the wall.

The demo's graph runs twice in lockstep, for a few steps and for many: the difference of the processor times,
which are those of whole processes, is that of the steps between. The time on the wall is what the simulator
says at the run's end; it means something on a computer that does nothing else.

    python benchmarks/lockstep.py [--steps 4000]
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import threading
import time
from pathlib import Path

from forest_bringup import graph, lockstep_run
from forest_msgs_py.types import PERIOD

FEW = 20  # steps
LOOK = 0.05  # [s]
TICK = os.sysconf("SC_CLK_TCK")  # [1/s]


class Watch(threading.Thread):
    """Processor time [s] of this process' children, by node, as long as they live."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.seconds: dict[str, float] = {}
        self._over = threading.Event()

    def run(self) -> None:
        """Look until told to stop."""
        while not self._over.wait(LOOK):
            for task in Path("/proc/self/task").iterdir():
                for pid in (task / "children").read_text(encoding="ascii").split():
                    self._look(Path("/proc", pid))

    def _look(self, process: Path) -> None:
        try:
            node = re.search(rb"(\w+)_node\0", (process / "cmdline").read_bytes())
            fields = (process / "stat").read_text(encoding="ascii").rpartition(")")[2].split()
        except OSError:  # it has ended
            return
        if node is not None:
            self.seconds[node[1].decode()] = (int(fields[11]) + int(fields[12])) / TICK

    def end(self) -> None:
        """Stop."""
        self._over.set()
        self.join()


def measured(steps: int, out: Path) -> tuple[dict[str, float], float]:
    """Run the graph; return each node's processor time [s], and times as fast as live."""
    nodes = [
        graph.joystick("thesis", 86400.0, 0),
        *graph.control("c180_hoses", "coordinated", shadow=False, describe=False),
        graph.simulator("c180_hoses"),
        graph.recorder(out / "bag"),
    ]
    watch = Watch()
    watch.start()
    try:
        lockstep_run.run(nodes, steps, out / "log")
    finally:
        watch.end()
    told = re.search(r"([\d.]+) times as fast", (out / "log" / "simulator.log").read_text(encoding="utf-8"))
    return watch.seconds, float(told[1]) if told else 0.0


def table(few: dict[str, float], many: dict[str, float], steps: int, factor: float) -> str:
    """The table; `steps` are those between the two runs."""
    each = {node: 1e3 * (many[node] - few.get(node, 0.0)) / steps for node in many}
    wall = f"{1e3 * PERIOD / factor:.2f} ms on the wall, {factor:.2f} x real time" if factor else "-"
    rows = [f"| {node} | {cost:.2f} |" for node, cost in (each | {"together": sum(each.values())}).items()]
    return "\n".join(("| node | CPU ms per step |", "|---|---|", *rows, "", f"A step: {wall}."))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--steps", type=int, default=4000, help="of the long run (default: %(default)s)")
    steps = max(10 * FEW, parser.parse_args().steps)
    with tempfile.TemporaryDirectory() as out:
        few, _ = measured(FEW, Path(out, "few"))
        many, factor = measured(steps, Path(out, "many"))
    print(table(few, many, steps - FEW, factor))
    load = os.getloadavg()[0]
    print(
        f"{os.cpu_count()} cores, load {load:.1f} at the end, {time.strftime('%Y-%m-%d')}.", file=sys.stderr
    )


if __name__ == "__main__":
    main()
