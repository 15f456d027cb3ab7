"""Two hosts: the crane beside its driver and recorder there, the joystick here, and a poor link between.

`python benchmarks/two_hosts.py --out DIR [--cases TEXT ...] [--picture FILE]`, as root, 20 s a case, makes
two network namespaces. Each case is a live graph of its own with the same levers, on a link that delays,
loses or is cut. What has been run is kept in DIR, and not run again. All is judged by what the recorder
beside the machine wrote. Delays are those of a round trip, half of it each way.
"""

import argparse
import contextlib
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

import hosts
from live_crane import AGAIN, BEGUN, ENDS, REST
from processes import Process

from two_hosts import HERE, THERE, Outcome, Times, TwoHosts

DOMAIN = 77
CUT_AT = BEGUN + 0.7  # [s]
SHIFT = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <time.h>
int clock_gettime(clockid_t id, struct timespec *t) {
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    int code = real(id, t);
    if (id == CLOCK_REALTIME) t->tv_sec += atoi(getenv("SHIFT_S"));
    return code;
}
"""


class Case(NamedTuple):
    """A link, and what happens to it."""

    trip: float = 0.0  # [s] there and back
    jitter: float = 0.0  # [s] one way, up to
    loss: float = 0.0  # 0..1
    cut: float = 0.0  # [s]
    ahead: int = 0  # [s] the machine's clock
    controller: str = "here"  # here: beside the operator; there: beside the machine


DELAYS = (0.0, 0.02, 0.08, 0.15, 0.24, 0.4)
CASES = {
    **{f"{1e3 * trip:g} ms": Case(trip) for trip in DELAYS},
    "80 ms, jitter of 40 ms": Case(0.08, jitter=0.04),
    "20 ms, 5 % lost": Case(0.02, loss=0.05),
    **{f"cut for {cut:g} s": Case(0.02, cut=cut) for cut in (0.1, 0.5, 2.0, 5.0)},
    "machine's clock 3 s ahead": Case(0.02, ahead=3),
    "machine's clock 3 s behind": Case(0.02, ahead=-3),
    **{f"{1e3 * trip:g} ms, controller there": Case(trip, controller="there") for trip in DELAYS},
    "5 % lost, controller there": Case(0.02, loss=0.05, controller="there"),
    **{
        f"cut for {cut:g} s, controller there": Case(0.02, cut=cut, controller="there")
        for cut in (0.1, 0.5, 2.0, 5.0)
    },
}


@contextlib.contextmanager
def link(case: Case) -> Iterator[list[str]]:
    """Give the two hosts."""
    numbers = {"delay": case.trip / 2.0, "jitter": case.jitter, "loss": case.loss}
    options = [word for name, value in numbers.items() for word in (f"--{name}", str(value))]
    addresses = [f"{HERE}/24", f"{THERE}/24"]
    with hosts.hosts("here", "there") as at, hosts.slow_link(at, addresses, *options):
        yield at


def shifted(seconds: int, folder: Path) -> dict[str, str]:
    """Return the environment of a host whose clock is ahead; the C compiler makes that clock."""
    if not seconds:
        return {}
    library = folder / "shift.so"
    command = ["cc", "-shared", "-fPIC", "-xc", "-", "-o", str(library), "-ldl"]
    subprocess.run(command, input=SHIFT, text=True, check=True)
    return {"LD_PRELOAD": str(library), "SHIFT_S": str(seconds)}


def run(case: Case, folder: Path) -> dict[str, Any]:
    """Run a case; return what came of it."""
    started: list[Process] = []

    def start(words: list[str], environment: Any) -> Process:
        started.append(Process(words, folder / f"log{len(started)}", env=environment, cwd=folder))
        return started[-1]

    cut, healed = math.inf, math.inf
    here = ("joystick", "controller") if case.controller == "here" else ("joystick",)
    with link(case) as at:
        try:
            graph = TwoHosts(start, at, folder, Times(), here, shifted(case.ahead, folder))
            if case.cut:
                graph.until(CUT_AT)
                cut, _, healed = graph.cut(case.cut)
            found = graph.end(case.ahead)
        finally:
            for process in started:
                process.kill_group()
    kept = {name: value.tolist() for name, value in found._asdict().items() if isinstance(value, np.ndarray)}
    return {**found._asdict(), **kept, "cut": cut, "healed": healed}


def row(name: str, kept: dict[str, Any], reference: Outcome | None) -> str:
    """Return a case's row of the table."""
    one, cut, healed = outcome(kept), kept["cut"], kept["healed"]
    moving = (one.opened >= BEGUN) & (one.opened < REST)
    last = f"{one.opened[moving].max():.1f}" if moving.any() else "never"
    away = f"{1e3 * apart(one, reference):.0f}" if reference is not None and moving.any() else ""
    is_cut = math.isfinite(cut)
    stops = is_cut and healed - cut > 0.25
    restarts = stops and (one.moved(healed, REST) or (healed > AGAIN and one.moved(healed, ENDS)))
    again = one.moved(max(healed, AGAIN) if is_cut and healed < AGAIN else AGAIN, ENDS)
    cells = (
        *(name, last, away, "" if one.share == 1.0 else f"{100.0 * one.share:.0f} %"),
        f"{one.zero_after(cut, healed):.2f}" if is_cut else "",
        "**yes**" if restarts else "no",
        "yes" if again else "no",
        *(str(one.unanswered), "; ".join(one.told[:3]).replace("|", "/")),
    )
    return f"| {' | '.join(cells)} |"


def apart(one: Outcome, other: Outcome) -> float:
    """Return the greatest distance between the tips of two runs at one time of motion [m]."""
    at = np.arange(BEGUN, REST, 0.01)
    tips = [
        np.stack([np.interp(at, run.time, run.tip[:, k]) for k in range(3)], axis=1) for run in (one, other)
    ]
    return float(np.linalg.norm(tips[0] - tips[1], axis=1).max())


def outcome(kept: dict[str, Any]) -> Outcome:
    """Return an outcome that was kept as JSON."""
    arrays = {name: np.array(kept[name]) for name in ("opened", "time", "tip")}
    return Outcome(**arrays, share=kept["share"], unanswered=kept["unanswered"], told=tuple(kept["told"]))


def draw(found: dict[str, dict[str, Any]], path: Path) -> None:
    """Draw how the tip goes sideways in each case."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    groups = [
        [name for name in found if CASES[name].cut == cut and CASES[name].controller == where]
        for cut, where in ((0.0, "here"), (0.0, "there"))
    ]
    groups.append([name for name in found if CASES[name].cut])
    figure, axes = pyplot.subplots(len(groups), 1, figsize=(8.0, 10.0), sharex=True)
    for axis, group in zip(axes, groups, strict=True):
        for name in group:
            one = outcome(found[name])
            axis.plot(one.time, one.tip[:, 1], label=name, linewidth=1.0)
        axis.axvspan(REST, AGAIN, color="0.9")
        axis.set_ylabel("tip sideways, m")
        if group:
            axis.legend(fontsize=6, loc="upper left")
    axes[-1].set_xlim(BEGUN - 0.3, ENDS)
    axes[-1].set_xlabel("time since the joystick's first sample, s; grey: the levers rest")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


HEAD = (
    *("case", "last open, s", "tip off, mm", "slowed to", "zero after, s", "moved by itself"),
    *("moved on purpose", "unanswered", "told"),
)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="results are kept there")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), metavar="TEXT")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    if why := hosts.reason():
        parser.error(why)
    os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
    found: dict[str, dict[str, Any]] = {}
    for name in options.cases:
        folder = options.out / name.replace(" ", "_").replace("%", "percent").replace("'", "")
        file = folder / "outcome.json"
        if not file.exists():
            folder.mkdir(parents=True)
            file.write_text(json.dumps(run(CASES[name], folder.resolve())))
        found[name] = json.loads(file.read_text())
    print(f"| {' | '.join(HEAD)} |")
    print("|---" * len(HEAD) + "|")
    reference = outcome(found["0 ms"]) if "0 ms" in found else None
    for name, kept in found.items():
        print(row(name, kept, reference))
    if options.picture:
        draw(found, options.picture)


if __name__ == "__main__":
    main()
