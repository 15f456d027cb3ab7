"""`forest-study ablation`: control without each mechanism, or with each constant halved and doubled."""

import argparse
import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from forest_compile.kernel_cache import can_compile
from forest_description.machine import Machine, load_machine
from forest_msgs_py.runtime.command_line import number, whole
from forest_study.ablation.constants import NODES, ROOMS, Changes, numbers, scaled
from forest_study.ablation.trials import Figures, Trial, tried
from forest_study.results import StudyError, write_json

NOTHING = "nothing"
MECHANISMS: dict[str, Changes] = {
    NOTHING: {},
    "holding": {f"config.controller_settings.{name}_ERROR": 0.0 for name in ("HOLD", "RELEASE")},
    "inching": {"servo.inching.ARRIVED": 1e9},
    "stronger inches": {"servo.inching.STRONGEST": 1.0},
    "hold zone": {"valve_driver.hold_zone": 0.0},
    "zone that doubles": {"valve.valve_hold.WIDEST": 1.0},
    "low-pass of the error": {"servo.coordinated_servo.ERROR_LAG": 1e-6},
    "integral at rest": {"servo.coordinated_servo.MOST_GATHERED": 0.0},
    "nothing, with adaptation": {"valve_driver.adapt": True},
    "search, with adaptation": {"valve_driver.adapt": True, "valve.valve_adaptation.SEARCH": 0.0},
}
FACTORS = (0.5, 2.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Give the verb its arguments."""
    add = parser.add_argument
    add("--machine", default="c180", metavar="NAME|FILE", help="default: %(default)s")
    add(
        "--constants",
        nargs="+",
        choices=(*ROOMS, *NODES),
        metavar="ROOM",
        help=f"instead of mechanisms, constants of these rooms and nodes: {', '.join((*ROOMS, *NODES))}",
    )
    add("--only", default="", metavar="TEXT", help="of these, whose name has it in it")
    add("--pushes", type=whole(1, 1000), default=20, metavar="N", help="default: %(default)s")
    add(
        "--overlap",
        type=number(0.5, 2.0),
        default=1.0,
        metavar="SHARE",
        help="believed over true overlap while pushed (default: %(default)s)",
    )
    add(
        "--tilt",
        type=number(-15.0, 15.0, "deg"),
        default=0.0,
        metavar="DEG",
        help="of the platform while pushed, which the controller does not know (default: %(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        MachineError: the machine's file cannot be read.
        StudyError: LLVM is not installed, or no constant has such a name.
    """
    if not can_compile():
        raise StudyError("ablation needs LLVM, which is not installed: pip install 'forest-crane[fast]'")
    machine, rooms = load_machine(options.machine), options.constants
    changes = MECHANISMS if rooms is None else _constants(rooms, options.only, machine)

    def one(name: str) -> Figures | None:
        tilt = math.radians(options.tilt)
        found = tried(Trial(options.machine, changes[name], options.pushes, options.overlap, tilt))
        print(_line(name, found), flush=True)
        return found

    print(HEAD, flush=True)
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        found = dict(zip(changes, pool.map(one, changes), strict=True))
    told = {name: None if row is None else row._asdict() for name, row in found.items()}
    write_json(options.out / "ablation.json", {**_conditions(options), "without": told})
    names = sorted(found, key=_effect(found), reverse=True) if options.constants else list(found)
    text = "\n".join([HEAD, RULE, *(_line(name, found[name]) for name in names)])
    (options.out / "ablation.md").write_text(text + "\n", encoding="utf-8")
    print(f"  {options.out / 'ablation.md'}")
    return 0


HEAD = "| changed | cross-track, mm | governed, mm | slow, mm/s | V/s | cycles | rest, mm |"
RULE = "|---|---|---|---|---|---|---|"


def _line(name: str, row: Figures | None) -> str:
    if row is None:
        return f"| {name} | control failed | | | | | |"
    return (
        f"| {name} | {row.paths_mm:.2f} | {row.governed_mm:.2f} | {row.slow_mm_s:.1f} | {row.volts_s:.0f} "
        f"| {row.cycles} | {row.rest_mm:.1f} |"
    )


def _conditions(options: argparse.Namespace) -> dict[str, str | float]:
    names = ("machine", "pushes", "overlap", "tilt")
    return {name: getattr(options, name) for name in names}


def _constants(rooms: list[str], only: str, machine: Machine) -> dict[str, Changes]:
    """Return the changes of all constants, behind none."""
    found = {name: value for name, value in numbers(tuple(rooms), machine).items() if only in name}
    if not found:
        raise StudyError(f"no constant of {', '.join(rooms)} has {only!r} in its name")
    changes: dict[str, Changes] = {NOTHING: {}}
    for name, value in found.items():
        changes |= {f"{name} × {factor:g}": {name: scaled(value, factor)} for factor in FACTORS}
    return changes


def _effect(found: dict[str, Figures | None]) -> Callable[[str], float]:
    """Return the greatest relative change of a figure, by the change's name."""
    usual = found[NOTHING]

    def effect(name: str) -> float:
        row = found[name]
        if row is None or usual is None:
            return math.inf
        return max(abs(a - b) / max(abs(b), 1.0) for a, b in zip(row, usual, strict=True))

    return effect
