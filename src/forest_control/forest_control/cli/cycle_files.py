"""`forest-control cycle list|check|rename`: the files of taught work, without a running graph."""

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

from forest_control.config.controller_settings import Parameters, Settings, parameters
from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace
from forest_control.taught.cycle_file import file_of, load_cycle, names, save_cycle
from forest_control.taught.plan import Hold, Step, assumed_start, planned
from forest_control.taught.tip_path import PathError
from forest_description.machine import Machine, load_machine
from forest_msgs_py.runtime.command_line import Command, Subcommands, subcommand

DIRECTORY = Path("cycles")


def add_parsers(verbs: Subcommands) -> None:
    """Add the verbs and their flags."""
    _verb(verbs, "list", "name all cycles, with length, duration, and what is out of reach", _list)
    check = _verb(verbs, "check", "tell a cycle's segments; exit code 1 if one is out of reach", _check)
    check.add_argument("name", metavar="NAME", help="name of the cycle")
    rename = _verb(verbs, "rename", "give a cycle of yours another name", _rename, known=False)
    rename.add_argument("name", metavar="NAME", help="name of the cycle")
    rename.add_argument("new", metavar="NEW", help="new name")


def add_directory(parser: argparse.ArgumentParser) -> None:
    """Add the flag that says where the user's cycles are."""
    parser.add_argument(
        "--directory",
        type=Path,
        default=DIRECTORY,
        metavar="DIR",
        help="directory of your cycles (default: cycles)",
    )


def _verb(
    verbs: Subcommands,
    name: str,
    text: str,
    run: Command,
    known: bool = True,
) -> argparse.ArgumentParser:
    parser = subcommand(verbs, name, text, run)
    add_directory(parser)
    if known:
        parser.add_argument("--machine", default="c180", help="machine that does the work (default: c180)")
        parser.add_argument(
            "--workspace", default="", help="workspace limits: a shipped name or a file (default: none)"
        )
    return parser


def _list(options: argparse.Namespace) -> int:
    machine, p = _crane(options)
    for name in names(options.directory):
        try:
            taught = load_cycle(name, options.directory)
            steps = planned(taught, assumed_start(taught, machine), p)
        except (SettingFileError, PathError) as error:
            print(f"{name:<16} refused: {error}")
            continue
        print(f"{name:<16} {_summary(steps)}  {taught.description}".rstrip())
    return 0


def _check(options: argparse.Namespace) -> int:
    machine, p = _crane(options)
    taught = load_cycle(options.name, options.directory)
    steps = planned(taught, assumed_start(taught, machine), p)
    for line in _lines(steps):
        print(line)
    print(f"{options.name}: {_summary(steps)}")
    return 0


def _rename(options: argparse.Namespace) -> int:
    taught, target = load_cycle(options.name, options.directory), file_of(options.new, options.directory)
    if target.exists():
        raise SettingFileError(f"cycle {options.new!r}: there is one; allowed: a name that is free")
    save_cycle(taught._replace(name=options.new), options.directory)
    own = file_of(options.name, options.directory)
    if own.exists():
        own.unlink()
    else:
        print(f"{options.name} is shipped and stays; {options.new} is a copy of it")
    return 0


def _crane(options: argparse.Namespace) -> tuple[Machine, Parameters]:
    machine = load_machine(options.machine)
    return machine, parameters(machine, Settings(), load_workspace(options.workspace))


def _summary(steps: tuple[Step, ...]) -> str:
    legs = [step for step in steps if not isinstance(step, Hold)]
    length, time = sum(leg.path.length for leg in legs), sum(leg.duration for leg in legs)
    count = len({step.number for step in steps})
    return f"{count:>2} segments  {length:5.1f} m  {math.ceil(time):>3} s"


def _lines(steps: tuple[Step, ...]) -> Iterator[str]:
    for step in steps:
        if isinstance(step, Hold):
            wait = f"{step.grapple.wait:g} s" if step.grapple.wait else "until confirmed"
            yield f"{step.number:>2}  {step.name:<16} grapple {step.grapple.action}, {wait}"
        else:
            stops = len(step.path.stops) - 2
            corners = f", stops on the way: {stops}" if stops else ""
            length = f"{step.path.length:.2f} m, {step.duration:.1f} s"
            yield f"{step.number:>2}  {step.name:<16} {length}{corners}"
