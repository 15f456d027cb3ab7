"""`forest-study`: studies of machine and control together, from the command line.

Each subcommand is a module with a function that takes its arguments and returns the exit code; this one reads
arguments and turns errors into one sentence on standard error. It imports only the module that is asked for:
all of them take a second. Exit codes: 0 well, 1 failed, 2 wrong arguments, 130 stopped.
"""

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, Protocol, cast

from forest_bringup.graph_lock import GraphError
from forest_control.taught.tip_path import PathError
from forest_description.config.parameter import MachineError
from forest_msgs_py.runtime import command_line
from forest_study.closed_loop.link_model import LinkError
from forest_study.results import StudyError

PROGRAM = "forest-study"


class Study(Protocol):
    """A module that makes a study: it makes the directory `--out` once it knows that its arguments serve."""

    def add_arguments(self, parser: argparse.ArgumentParser, /) -> None:
        """Give the subcommand its arguments."""

    def run(self, options: argparse.Namespace, /) -> int:
        """Make the study; return the exit code."""


class Command(NamedTuple):
    """A subcommand."""

    name: str
    study: str  # module of forest_study
    text: str  # of its help


COMMANDS = (
    Command(
        "thesis",
        "thesis.thesis_command",
        "the thesis' evaluation of its control schemes (section 5.2): numbers and pictures",
    ),
    Command(
        "track",
        "tracking.track_command",
        "the tip along a path, closed loop: how far it is from where it should be",
    ),
    Command(
        "matrix",
        "matrix.matrix_command",
        "plants hidden from the controller, drawn by seed: the worst of them",
    ),
    Command(
        "tune",
        "tune.tune_command",
        "gains for a machine file, searched for on the matrix' plants and judged on others; a profile",
    ),
    Command(
        "faults",
        "faults.faults_command",
        "faults in every state: time to zero voltage, the tip's way, what is told",
    ),
    Command(
        "ablation",
        "ablation.ablation_command",
        "control without each mechanism, or its constants halved and doubled",
    ),
    Command("cycles", "ablation.cycles_command", "limit cycles of a misjudged overlap: told and simulated"),
    Command("delay", "latency.delay_study", "late links: tracking and stopping against 0 to 600 ms"),
    Command("placing", "latency.placing", "reaching and placing behind a late link, by a simulated operator"),
    Command("replay", "demo.replay", "nodes fed from a bag in lockstep: do they answer as they did?"),
    Command("timing", "latency.timing", "how late a live bag's messages were, and what that costs the tip"),
    Command(
        "bode", "stability.bode_command", "each joint's position loop: Bode plot, gain and phase margins"
    ),
    Command("sway", "tracking.sway_command", "the hanging head after a stop, with anti-sway and without"),
    Command("logs", "logs.logs_command", "logs from the ground to the bunk and back, by simulated operators"),
    Command("sweep", "sweep.sweep_command", "thousands of runs from a study's file, resumable"),
    Command(
        "baseline",
        "learning.baseline_command",
        "our controller and simple policies on the drawn tasks of the Gymnasium environment",
    ),
    Command(
        "diagnosis",
        "diagnosis.diagnosis_command",
        "the monitor's false alarms and detections, from sweeps of kind diagnosis",
    ),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one subcommand; return its exit code."""
    given = sys.argv[1:] if arguments is None else arguments
    options = _parser(*given[:1]).parse_args(given)
    return command_line.run(PROGRAM, options, (MachineError, StudyError, GraphError))


def _parser(wanted: str = "") -> argparse.ArgumentParser:
    """Return the parser, with the arguments of the wanted subcommand alone; "": of all."""
    parser = argparse.ArgumentParser(prog=PROGRAM, description="Study machine and control together.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, module, text in COMMANDS:
        command = command_line.subcommand(commands, name, text, _run)
        command.add_argument(
            "--out", type=Path, required=True, metavar="DIR", help="directory to be made, or empty"
        )
        if wanted in (name, ""):
            study = cast(Study, import_module(f"{__package__}.{module}"))
            command.set_defaults(subcommand=(name, study))
            study.add_arguments(command)
    return parser


def _run(options: argparse.Namespace) -> int:
    """Make the study; a path or a link that cannot be is told with the subcommand's name."""
    name: str = options.subcommand[0]
    study: Study = options.subcommand[1]
    try:
        return study.run(options)
    except (LinkError, PathError) as error:
        raise StudyError(f"{name}: {error}") from error


if __name__ == "__main__":
    sys.exit(main())
