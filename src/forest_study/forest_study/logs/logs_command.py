"""`forest-study logs`: logs from the ground to the bunk and back, by simulated operators, in each mode."""

import argparse
import json
from pathlib import Path
from typing import Any

from forest_description.machine import load_machine
from forest_msgs_py.runtime.command_line import add_machine_option, number, whole
from forest_study.log_work import trial_measures
from forest_study.log_work.crane import MODES
from forest_study.logs import logs_report, recorded_logs, tables
from forest_study.results import StudyError, new_directory, write_json
from forest_study.sweep.store import Store
from forest_study.sweep.study import study_of
from forest_study.sweep.sweep_command import run_the_rest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add_machine_option(parser, "forwarder")
    text = "modes of the levers; the first is what the others are compared with (default: joint tip assisted)"
    add("--mode", nargs="+", choices=MODES, default=list(MODES[:3]), help=text)
    text = "operators: novice, expert, or files (default: both); live: a person, from --bag"
    add("--operator", nargs="+", default=["novice", "expert"], metavar="MODEL", help=text)
    text = "simulated persons, two or more for intervals (default: %(default)s)"
    add("--seeds", type=whole(1, 100_000), default=10, metavar="N", help=text)
    text = "round-trip times of the joystick's link [s] (default: 0)"
    add("--trip", nargs="+", type=number(0.0, 1.0, "s"), default=[0.0], metavar="T", help=text)
    add("--bag", type=Path, metavar="BAG", help="recorded run of a person, for --operator live")
    add("--workers", type=whole(1, 1024), metavar="N", help="processes (default: one per core)")


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code: 1 where a trial was not ended.

    Raises:
        StudyError: an operator or a directory is not usable, or the machine does not reach the logs.
        MachineError: the machine's file cannot be read.
        OSError: the disk is full.
    """
    if (options.operator == ["live"]) != (options.bag is not None) or "live" in options.operator[1:]:
        raise StudyError("logs: live is one person's recorded run; allowed: --operator live --bag BAG")
    if options.bag is not None:
        return _judge(options)
    study = study_of(_text(options))
    store = Store(options.out, study)
    run_the_rest(study, store, None, options.workers)
    found = tables.groups(store.finish(), _each(options.mode))
    told = {"machine": options.machine, "persons": options.seeds, "groups": tables.told(found)}
    write_json(options.out / "logs.json", told)
    text = tables.text(found)
    (options.out / "logs.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    machine, operators = load_machine(options.machine), _each(options.operator)
    page = options.out / "logs.html"
    logs_report.write(page, machine, operators, options.seeds, found, _made(options))
    print(f"  {page}")
    return 1 if any(n for group in found for n in group.failed.values()) else 0


def _judge(options: argparse.Namespace) -> int:
    """Tell the figures of a person's run."""
    run = recorded_logs.read(options.bag, load_machine(options.machine))
    told = trial_measures.figures(run.work)
    new_directory(options.out)
    write_json(options.out / "live.json", {"bag": str(options.bag), "figures": told, "misses_m": run.misses})
    print("| figure | person |\n|---|---|")
    print("\n".join(f"| {label} | {told[figure]:.4g} |" for figure, label in tables.SHOWN.items()))
    print(f"| farthest from a log's place, m | {max(run.misses):.2f} |")
    print(f"  {options.out / 'live.json'}")
    return 0


def _text(options: argparse.Namespace) -> str:
    """Return the options as a study's file; JSON is YAML."""
    study: dict[str, Any] = {
        "kind": "logs",
        "with": {"machine": options.machine},
        "vary": {
            "operator": _each(options.operator),
            "trip": _each(options.trip),
            "mode": _each(options.mode),
        },
        "seeds": options.seeds,
    }
    return json.dumps(study, indent=2) + "\n"


def _made(options: argparse.Namespace) -> str:
    """Return the command that makes the same."""
    modes, operators = " ".join(_each(options.mode)), " ".join(_each(options.operator))
    trips = " ".join(f"{trip:g}" for trip in _each(options.trip))
    return (
        f"forest-study logs --machine {options.machine} --mode {modes} --operator {operators} "
        f"--trip {trips} --seeds {options.seeds}"
    )


def _each(values: list[Any]) -> list[Any]:
    """Return each value once, in order."""
    return list(dict.fromkeys(values))
