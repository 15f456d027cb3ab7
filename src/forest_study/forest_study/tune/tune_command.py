"""`forest-study tune`: gains for a machine file, searched for on the matrix' plants, judged on others."""

import argparse
import math
import sys
import time
from typing import Any

from forest_msgs_py.runtime.command_line import StatusLine, add_machine_option, whole
from forest_study.matrix.matrix_rows import matrix_rows
from forest_study.results import require_llvm, write_json
from forest_study.tune import tune_report
from forest_study.tune.bench import Bench
from forest_study.tune.gains import gains_of, point_of, profile, settings_of
from forest_study.tune.robustness import allowed, opened, worst
from forest_study.tune.search import Tried, best, search

UNSEEN = 100_000  # the first seed of the plants that judge: no search comes there
LEAST = 17  # trials: the rule's gains and two a number are what the optimiser's first model needs
NOT_DRIVEN = ("load",)  # rows without a path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add, rows = parser.add_argument, [name for name in matrix_rows() if name not in NOT_DRIVEN]
    add_machine_option(parser)
    text = f"rows of the matrix whose plants are driven: {', '.join(rows)} (default: plain)"
    add("--row", nargs="+", choices=rows, default=["plain"], metavar="NAME", help=text)
    text = "plants of the search, 2 at least (default: %(default)s)"
    add("--seeds", type=whole(2, 1000), default=16, metavar="N", help=text)
    text = "other plants that judge the result, 2 at least (default: %(default)s)"
    add("--unseen", type=whole(2, 1000), default=24, metavar="N", help=text)
    text = f"largest number of gains to be tried, {LEAST} at least (default: %(default)s)"
    add("--trials", type=whole(LEAST, 10_000), default=60, metavar="N", help=text)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        PathError: a path leaves the machine's reach.
        MachineError: the machine's file cannot be read, or lacks what is drawn.
        StudyError: LLVM is not installed, another search is in the directory, or a valve stays shut.
    """
    require_llvm("tune")
    rows = [matrix_rows()[name] for name in dict.fromkeys(options.row)]
    bench = Bench(options.out, options.machine, rows)
    plants = opened(bench.machine, [path.at(0.0) for row in rows for path in row.paths])
    rule = settings_of(point_of(bench.machine))
    found = search(bench, plants, range(options.seeds), options.trials, _Progress(options.trials).say)
    tuned = best(found, allowed(plants, rule)).settings
    unseen = range(UNSEEN, UNSEEN + options.unseen)
    gained = tune_report.compared(bench.run(tuned, unseen), bench.run(rule, unseen))
    least = {"rule": worst(plants, rule), "tuned": worst(plants, tuned)}
    told: dict[str, Any] = {
        "machine": bench.machine.name,
        "trials": [{**gains_of(t.settings), "cost": t.cost, "sensitivity": t.sensitivity} for t in found],
        "gains": {"rule": gains_of(rule), "tuned": gains_of(tuned)},
        "unseen": gained,
        "margins": {name: {a: m._asdict() for a, m in of.items()} for name, of in least.items()},
    }
    write_json(options.out / "tune.json", told)
    said = tune_report.answer(gained)
    text = f"{tune_report.table(gained)}\n\n{tune_report.robustness(least['rule'], least['tuned'])}"
    (options.out / "tune.md").write_text(text + "\n", encoding="utf-8")
    head = [f"Gains of {bench.machine.name}, by {_made(options)}", *said]
    (options.out / "profile.yaml").write_text(profile(tuned, head), encoding="utf-8")
    print("\n".join([text, "", *(f"  {line}" for line in said), f"  {options.out / 'profile.yaml'}"]))
    return 0


def _made(options: argparse.Namespace) -> str:
    """Return the command that makes the same."""
    return (
        f"forest-study tune --machine {options.machine} --row {' '.join(dict.fromkeys(options.row))} "
        f"--seeds {options.seeds} --trials {options.trials} --unseen {options.unseen}"
    )


class _Progress:
    """The line that tells how far the search is; a search may end before all its trials."""

    def __init__(self, trials: int) -> None:
        self._line, self._trials, self._begun = StatusLine(sys.stdout), trials, time.monotonic()
        self._best = 0.0

    def say(self, count: int, last: Tried) -> None:
        """Tell of the last trial."""
        self._best = min(self._best, last.cost)
        left = (time.monotonic() - self._begun) / count * (self._trials - count)
        change = 100.0 * math.expm1(self._best)
        self._line.show(f"{count} of {self._trials} trials, worst quarter {change:+.1f} %, {left:.0f} s left")
        if count == self._trials:
            self._line.end()
