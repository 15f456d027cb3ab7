"""`forest-study logs`: logs from the ground to the bunk and back, by simulated operators, in each mode."""

import argparse
import json
from typing import Any

from forest_msgs_py.runtime.command_line import number, whole
from forest_study.log_work.crane import MODES
from forest_study.logs import tables
from forest_study.results import write_json
from forest_study.sweep.store import Store
from forest_study.sweep.study import study_of
from forest_study.sweep.sweep_command import run_the_rest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add("--machine", default="forwarder", metavar="NAME|FILE", help="default: %(default)s")
    text = "what the levers move; the others are compared with the first (default: all)"
    add("--mode", nargs="+", choices=MODES, default=list(MODES), help=text)
    text = "novice, expert, or files (default: both)"
    add("--operator", nargs="+", default=["novice", "expert"], metavar="MODEL", help=text)
    add("--seeds", type=whole(1, 100_000), default=10, metavar="N", help="persons; default: %(default)s")
    text = "round trips of the joystick's link, s; default: 0"
    add("--trip", nargs="+", type=number(0.0, 1.0, "s"), default=[0.0], metavar="T", help=text)
    add("--workers", type=whole(1, 1024), metavar="N", help="processes (default: one a core)")


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code: 1 where a trial was not ended.

    Raises:
        StudyError: an operator or a directory is not usable, or the machine does not reach the logs.
        MachineError: the machine's file cannot be read.
        OSError: the disk is full.
    """
    study = study_of(_text(options))
    store = Store(options.out, study)
    run_the_rest(study, store, None, options.workers)
    found = tables.groups(store.finish(), _each(options.mode))
    report = {"machine": options.machine, "persons": options.seeds, "groups": tables.told(found)}
    write_json(options.out / "logs.json", report)
    text = tables.text(found)
    (options.out / "logs.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    print(f"  {options.out / 'logs.json'}")
    return 1 if any(n for group in found for n in group.failed.values()) else 0


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


def _each(values: list[Any]) -> list[Any]:
    """Return each value once, in order."""
    return list(dict.fromkeys(values))
