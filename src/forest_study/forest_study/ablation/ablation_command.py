"""`forest-study ablation`: control without each mechanism, or with each constant halved and doubled."""

import argparse
import itertools
import math
from typing import Any

from forest_control.valve.load_estimate import FILLING
from forest_description.machine import load_machine
from forest_msgs_py.runtime.command_line import add_machine_option, number, whole
from forest_study.ablation import effects
from forest_study.ablation.constants import NODES, ROOMS, Changes, numbers, scaled
from forest_study.ablation.plants import FIGURES, NOT_ENDED
from forest_study.ablation.scenes import SCENES
from forest_study.ablation.trials import Figures, Trial, tried
from forest_study.results import StudyError, new_directory, require_llvm, write_json

NOTHING = "nothing"
MECHANISMS: dict[str, Changes] = {
    NOTHING: {},
    "holding": {f"config.controller_settings.{name}_ERROR": 0.0 for name in ("HOLD", "RELEASE")},
    "inching": {"servo.inching.ARRIVED": 1e9},
    "stronger inches": {"servo.inching.STRONGEST": 1.0},
    "hold zone": {"valve_driver.hold_zone": 0.0},
    "search": {"valve.valve_adaptation.FINE": 0.0},
    "low-pass of the error": {"servo.coordinated_servo.ERROR_LAG": 1e-6},
    "adaptation": {"valve_driver.adapt": False},
}
FACTORS = (0.5, 2.0)
OF_MECHANISMS = ("paths", "slow")
BYSTANDER, CHANCES = "valve.load_estimate.FILLING", 8  # what is changed by millionths, and how often


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Give the verb its arguments."""
    add = parser.add_argument
    add_machine_option(parser)
    add(
        "--constants",
        nargs="+",
        choices=(*ROOMS, *NODES),
        metavar="ROOM",
        help=f"instead of mechanisms, constants of these rooms and nodes: {', '.join((*ROOMS, *NODES))}",
    )
    add(
        "--only",
        nargs="+",
        default=[""],
        metavar="TEXT",
        help="mechanisms or constants whose name contains one of these",
    )
    add("--pushes", type=whole(1, 1000), default=20, metavar="N", help="pushes at each overlap and tilt")
    add(
        "--overlap",
        nargs="+",
        type=number(0.5, 2.0),
        default=[1.0],
        metavar="SHARE",
        help="believed over true overlap while pushed (default: 1)",
    )
    add(
        "--tilt",
        nargs="+",
        type=number(-15.0, 15.0, "deg"),
        default=[0.0],
        metavar="DEG",
        help="tilt of the platform while pushed, unknown to the controller (default: 0)",
    )
    add(
        "--plants",
        type=whole(0, 1000),
        default=0,
        metavar="N",
        help=f"plants of each of these rows of the matrix, too: {', '.join(FIGURES)} (default: none)",
    )


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        MachineError: the machine's file cannot be read.
        StudyError: LLVM is not installed, or no constant has such a name.
    """
    new_directory(options.out)
    require_llvm("ablation")
    load_machine(options.machine)
    lines, found = (_of_mechanisms if options.constants is None else _of_constants)(options)
    write_json(options.out / "ablation.json", {**_conditions(options), "without": found})
    (options.out / "ablation.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"  {options.out / 'ablation.md'}")
    return 0


def _of_mechanisms(options: argparse.Namespace) -> tuple[list[str], dict[str, Figures | None]]:
    """Print and return the table of mechanisms left out, and their figures."""
    changes, lines, found = _chosen(MECHANISMS, options.only), [HEAD, RULE], dict[str, Figures | None]()
    print(*lines, sep="\n", flush=True)
    for name, row in zip(changes, _tried(options, changes, OF_MECHANISMS), strict=True):
        found[name] = row
        lines.append(_line(name, row))
        print(lines[-1], flush=True)
    if options.plants:
        lines += ["", *_of_plants(found)]
        print(*lines[-len(found) - 3 :], sep="\n")
    return lines, found


def _of_plants(found: dict[str, Figures | None]) -> list[str]:
    """Return the table of the matrix' plants: of each figure the median and the worst plant."""
    columns = [(row, text) for row, told in FIGURES.items() for text in told.values()]
    head = " | ".join(("left out", *(f"{row}: {text}" for row, text in columns), NOT_ENDED))
    lines = [f"| {head} |", "|---" * (len(columns) + 2) + "|"]
    for name, row in found.items():
        if row is None:
            lines.append(f"| {name} | control failed {'| ' * len(columns)}|")
            continue
        pairs = ([row[f"{of}, {which}, {text}"] for which in ("median", "worst")] for of, text in columns)
        cells = " | ".join(f"{median:.3g} / {worst:.3g}" for median, worst in pairs)
        lines.append(f"| {name} | {cells} | {row[NOT_ENDED]:.0f} |")
    return lines


def _of_constants(options: argparse.Namespace) -> tuple[list[str], dict[str, Figures | None]]:
    """Print and return the table of constants at half and at twice, and their figures."""
    values = numbers(tuple(options.constants), load_machine(options.machine))
    values = {name: value for name, value in values.items() if _named(name, options.only)}
    if not values:
        raise StudyError(f"no constant of these has {' or '.join(options.only)} in its name")
    changes: dict[str, Changes] = {NOTHING: {}}
    changes |= {f"chance {k}": {BYSTANDER: FILLING * (1.0 + 1e-6 * k)} for k in range(1, CHANCES + 1)}
    for name, value in values.items():
        changes |= {f"{name} × {factor:g}": {name: scaled(value, factor)} for factor in FACTORS}
    rows = zip(changes, _tried(options, changes, tuple(SCENES)), strict=True)
    found = dict(itertools.islice(rows, 1 + CHANCES))
    same, by_chance = found[NOTHING], [row for row in found.values() if row is not None]
    if same is None:
        raise StudyError(f"control of {options.machine} fails without any change")
    usual, lines = effects.chance(by_chance), dict[str, tuple[float, str]]()
    print(effects.HEAD, flush=True)
    for name, value in values.items():
        both = dict(itertools.islice(rows, len(FACTORS)))
        half, twice = (effects.told(row, usual, same) for row in both.values())
        greatest = max(effects.effect(row, usual) for row in both.values())
        lines[name], found = (greatest, effects.line(name, value, half, twice)), found | both
        print(lines[name][1], flush=True)
    ranked = sorted(lines.values(), key=lambda one: -one[0])
    return [effects.HEAD, *(line for _, line in ranked)], found


def _tried(options: argparse.Namespace, changes: dict[str, Changes], scenes: tuple[str, ...]) -> Any:
    conditions = [(share, math.radians(tilt)) for tilt in options.tilt for share in options.overlap]
    return tried(
        [
            Trial(options.machine, one, scenes, options.pushes, conditions, options.plants)
            for one in changes.values()
        ]
    )


HEAD = "| changed | cross-track, mm | governed, mm | slow, mm/s | V/s | cycles | rest, mm |"
RULE = "|---|---|---|---|---|---|---|"
OF_ALL = ("cross-track, mm", "governed, mm", "slow, mm/s", "V/s")


def _line(name: str, row: Figures | None) -> str:
    if row is None:
        return f"| {name} | control failed | | | | | |"
    paths, governed, slow, volts = (row[one] for one in OF_ALL)
    cycles = " ".join(f"{value:.0f}" for one, value in row.items() if one.startswith("cycles"))
    rests = " ".join(f"{value:.1f}" for one, value in row.items() if one.startswith("rest"))
    return f"| {name} | {paths:.2f} | {governed:.2f} | {slow:.1f} | {volts:.0f} | {cycles} | {rests} |"


def _conditions(options: argparse.Namespace) -> dict[str, Any]:
    names = ("machine", "pushes", "overlap", "tilt", "plants")
    return {name: getattr(options, name) for name in names}


def _named(name: str, texts: list[str]) -> bool:
    return any(text in name for text in texts)


def _chosen(changes: dict[str, Changes], only: list[str]) -> dict[str, Changes]:
    """Return the changes whose name has one of some texts in it, behind none."""
    chosen = {name: change for name, change in changes.items() if _named(name, only)}
    if not chosen:
        raise StudyError(f"no mechanism has {' or '.join(only)} in its name")
    return {NOTHING: {}, **chosen}
