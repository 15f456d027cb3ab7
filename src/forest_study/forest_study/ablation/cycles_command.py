"""`forest-study cycles`: limit cycles of a misjudged overlap, told by describing functions and simulated."""

import argparse
import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from forest_control.config.controller_settings import Settings
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_msgs_py.runtime.command_line import add_machine_option, number
from forest_study.ablation.bare_loop import Case, seen
from forest_study.results import StudyError, new_directory, require_llvm, write_json
from forest_study.stability.describing_function import limit_cycle

SHARES = (0.9, 1.05, 1.1, 1.2)  # [1] believed over true overlap
HEAD = "| joint | overlap, V | believed | told: Hz | mrad | simulated: Hz | mrad |\n" + 7 * "|---" + "|"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Give the verb its arguments."""
    add_machine_option(parser)
    parser.add_argument(
        "--overlap",
        nargs="+",
        type=number(0.5, 2.0),
        default=list(SHARES),
        metavar="SHARE",
        help="believed over true overlap (default: 0.9 1.05 1.1 1.2)",
    )


def run(options: argparse.Namespace) -> int:
    """Print both, and write `cycles.json` and `cycles.md`; return the exit code.

    Raises:
        MachineError: the machine's file cannot be read.
        StudyError: LLVM is not installed, or a loop cannot be linearised.
    """
    new_directory(options.out)
    require_llvm("cycles")
    machine = load_machine(options.machine)
    tip = start_tip(machine)
    cases = [Case(options.machine, tip, axis, share) for axis in range(3) for share in options.overlap]
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        simulated = list(pool.map(seen, cases))
    rows: list[dict[str, Any]] = []
    lines = [HEAD]
    for case, found in zip(cases, simulated, strict=True):
        true = machine.valve_of(case.axis).deadband_voltage
        surplus = (case.overlap - 1.0) * true
        try:
            told = limit_cycle(machine, pose_at(tip, machine), case.axis, surplus, Settings())
        except ValueError as error:
            raise StudyError(f"cycles: {error}") from error
        predicted = "none | –" if told is None else f"{told.frequency:.1f} | {1e3 * told.angle:.2f}"
        lines.append(
            f"| {AXES[case.axis]} | {true:g} | {case.overlap:g} | {predicted} "
            f"| {found.frequency:.1f} | {1e3 * found.amplitude:.2f} |"
        )
        rows.append({**case._asdict(), "told": told and told._asdict(), "simulated": found._asdict()})
    write_json(options.out / "cycles.json", {"cases": rows})
    text = "\n".join(lines)
    (options.out / "cycles.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    return 0
