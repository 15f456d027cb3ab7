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
        "drive the tip along a path in closed loop and measure its errors",
    ),
    Command(
        "matrix",
        "matrix.matrix_command",
        "drive drawn plants that the controller does not know, and print the worst",
    ),
    Command(
        "tune",
        "tune.tune_command",
        "search gains for a machine file on drawn plants, judge them on others, and write a profile",
    ),
    Command(
        "faults",
        "faults.faults_command",
        "inject faults in every state: time to zero voltage, distance of the tip, message",
    ),
    Command(
        "ablation",
        "ablation.ablation_command",
        "drive without each mechanism of control, or with its constants halved and doubled",
    ),
    Command("cycles", "ablation.cycles_command", "predict and simulate limit cycles of a misjudged overlap"),
    Command("delay", "latency.delay_study", "measure tracking and stopping behind links of 0 to 600 ms"),
    Command("placing", "latency.placing", "let a simulated operator reach and place behind a late link"),
    Command(
        "replay",
        "demo.replay",
        "feed nodes from a bag in lockstep and compare their answers with the recorded ones",
    ),
    Command(
        "timing", "latency.timing", "measure how late a live bag's messages were, and what that costs the tip"
    ),
    Command(
        "bode",
        "stability.bode_command",
        "draw the Bode plot of each joint's position loop, with gain and phase margins",
    ),
    Command(
        "sway",
        "tracking.sway_command",
        "measure the sway of the hanging head after a stop, with anti-sway and without",
    ),
    Command("logs", "logs.logs_command", "let simulated operators load and unload logs"),
    Command("sweep", "sweep.sweep_command", "make the runs of a study file, by the thousand, resumable"),
    Command(
        "baseline",
        "learning.baseline_command",
        "compare our controller with simple policies on the Gymnasium environment",
    ),
    Command(
        "diagnosis",
        "diagnosis.diagnosis_command",
        "count the monitor's detections and false alarms in sweeps of kind diagnosis",
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
