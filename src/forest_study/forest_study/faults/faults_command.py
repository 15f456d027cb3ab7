"""`forest-study faults`: every fault in every state that it can meet; the worst seed counts."""

import argparse
from typing import Any

from forest_description.machine import Machine, load_machine
from forest_msgs_py.runtime.command_line import add_machine_option, whole
from forest_study.faults.catalogue import FAULTS
from forest_study.faults.fault import State
from forest_study.faults.fault_report import broken, page, worst
from forest_study.faults.trials import Outcome, cell
from forest_study.results import new_directory, require_llvm, write_json

STATES = {state.value: state for state in State}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add(
        "--only",
        nargs="+",
        choices=tuple(FAULTS),
        metavar="FAULT",
        help="faults to be injected (default: all)",
    )
    add(
        "--state",
        nargs="+",
        choices=tuple(STATES),
        metavar="STATE",
        help=f"states: {', '.join(STATES)} (default: all)",
    )
    add(
        "--seeds",
        type=whole(1, 1000),
        default=20,
        metavar="N",
        help="seeds of each cell (default: %(default)s)",
    )
    add_machine_option(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code: 1 if a bound is broken.

    Raises:
        MachineError: the machine's file cannot be read.
        StudyError: LLVM is not installed.
    """
    new_directory(options.out)
    require_llvm("faults")
    machine, seeds = load_machine(options.machine), range(options.seeds)
    wanted = [STATES[name] for name in options.state or STATES]
    study = Study(options, machine)
    for name in options.only or FAULTS:
        for state in (one for one in wanted if one in FAULTS[name].bounds):
            study.cells[name, state] = cell(FAULTS[name], state, seeds, machine)
        study.write()
        print(name, flush=True)
    failures = study.write()
    print("\n".join(failures))
    print(f"  {len(study.cells)} cells, {len(failures)} bounds broken; {options.out / 'faults.md'}")
    return int(bool(failures))


class Study:
    """What has been found so far; it is written anew after each fault, for a run may be stopped.

    Args:
        options: of the command.
        machine: that is simulated.
    """

    def __init__(self, options: argparse.Namespace, machine: Machine) -> None:
        self._out, self._seeds, self._machine = options.out, options.seeds, machine.name
        self.cells = dict[tuple[str, State], list[Outcome]]()

    def write(self) -> list[str]:
        """Write page and figures; return what breaks a bound, in sentences."""
        failures = [
            f"{name}, {state.value}, seed {one.seed}: {text}"
            for (name, state), outcomes in self.cells.items()
            for one in outcomes
            for text in broken(FAULTS[name].bounds[state], one)
        ]
        report: dict[str, Any] = {"machine": self._machine, "seeds": self._seeds, "broken": failures}
        found = {place: worst(outcomes) for place, outcomes in self.cells.items()}
        report["cells"] = {f"{name}, {state.value}": of for (name, state), of in found.items()}
        write_json(self._out / "faults.json", report)
        text = page(self._machine, self._seeds, FAULTS, found)
        (self._out / "faults.md").write_text(text, encoding="utf-8")
        return failures
