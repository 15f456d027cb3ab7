"""`forest-study`: studies of machine and control together, from the command line.

Each subcommand is a module with a function that takes its arguments and returns the exit code; this one reads
arguments, makes the directory for results and turns errors into one sentence on standard error. Exit codes:
0 well, 1 failed, 2 wrong arguments, 130 stopped.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from forest_bringup.graph_lock import GraphError
from forest_control.taught.tip_path import PathError
from forest_description.config.parameter import MachineError
from forest_msgs_py.runtime import command_line
from forest_study.ablation import ablation_command, cycles_command
from forest_study.closed_loop.link_model import LinkError
from forest_study.demo import replay
from forest_study.diagnosis import diagnosis_command
from forest_study.faults import faults_command
from forest_study.latency import delay_study, placing, timing
from forest_study.learning import baseline_command
from forest_study.logs import logs_command
from forest_study.matrix import matrix_command
from forest_study.results import StudyError, new_directory
from forest_study.stability import bode_command
from forest_study.sweep import sweep_command
from forest_study.tracking import sway_command, track_command
from forest_study.tune import tune_command

PROGRAM = "forest-study"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one subcommand; return its exit code."""
    options = _parser().parse_args(arguments)
    return command_line.run(PROGRAM, options, (MachineError, StudyError, GraphError))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description="Study machine and control together.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    thesis = _command(
        commands,
        "thesis",
        _thesis,
        "the thesis' evaluation of its control schemes (section 5.2): numbers and pictures",
    )
    thesis.add_argument(
        "--plant",
        choices=("linear", "machine"),
        default="linear",
        help="the thesis' linear joints, or what it left open: the full machine (default: %(default)s)",
    )
    tracking = _command(
        commands, "track", _track, "the tip along a path, closed loop: how far it is from where it should be"
    )
    track_command.add_arguments(tracking)
    hidden = _command(
        commands, "matrix", _matrix, "plants hidden from the controller, drawn by seed: the worst of them"
    )
    matrix_command.add_arguments(hidden)
    text = "gains for a machine file, searched for on the matrix' plants and judged on others; a profile"
    tune_command.add_arguments(_command(commands, "tune", _tune, text))
    faulty = _command(
        commands,
        "faults",
        _faults,
        "faults in every state: time to zero voltage, the tip's way, what is told",
    )
    faults_command.add_arguments(faulty)
    changed = _command(
        commands, "ablation", _ablation, "control without each mechanism, or its constants halved and doubled"
    )
    ablation_command.add_arguments(changed)
    cycling = _command(
        commands,
        "cycles",
        _cycles,
        "limit cycles of a misjudged overlap: told and simulated",
    )
    cycles_command.add_arguments(cycling)
    late = _command(commands, "delay", _delay, "late links: tracking and stopping against 0 to 600 ms")
    delay_study.add_arguments(late)
    placing.add_arguments(
        _command(
            commands, "placing", _placing, "reaching and placing behind a late link, by a simulated operator"
        )
    )
    replaying = _command(
        commands, "replay", _replay, "nodes fed from a bag in lockstep: do they answer as they did?"
    )
    replay.add_arguments(replaying)
    punctual = _command(
        commands, "timing", _timing, "how late a live bag's messages were, and what that costs the tip"
    )
    timing.add_arguments(punctual)
    looped = _command(
        commands, "bode", _bode, "each joint's position loop: Bode plot, gain and phase margins"
    )
    bode_command.add_arguments(looped)
    swaying = _command(commands, "sway", _sway, "the hanging head after a stop, with anti-sway and without")
    sway_command.add_arguments(swaying)
    moving = _command(
        commands, "logs", _logs, "logs from the ground to the bunk and back, by simulated operators"
    )
    logs_command.add_arguments(moving)
    many = _command(commands, "sweep", _sweep, "thousands of runs from a study's file, resumable")
    sweep_command.add_arguments(many)
    text = "our controller and simple policies on the drawn tasks of the Gymnasium environment"
    baseline_command.add_arguments(_command(commands, "baseline", _baseline, text))
    text = "the monitor's false alarms and detections, from sweeps of kind diagnosis"
    diagnosis_command.add_arguments(_command(commands, "diagnosis", _diagnosis, text))
    return parser


def _command(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    function: Callable[[argparse.Namespace], int],
    text: str,
) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    parser.set_defaults(command=function)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="directory to be made, or empty"
    )
    return parser


def _thesis(options: argparse.Namespace) -> int:
    new_directory(options.out)
    if options.plant == "machine":
        from forest_study.thesis import thesis_machine_report

        return thesis_machine_report.report(options.out)
    from forest_study.thesis import thesis_report

    return thesis_report.report(options.out)


def _replay(options: argparse.Namespace) -> int:
    new_directory(options.out)
    return replay.run(options)


def _timing(options: argparse.Namespace) -> int:
    new_directory(options.out)
    return timing.run(options)


def _delay(options: argparse.Namespace) -> int:
    try:
        return delay_study.run(options)
    except LinkError as error:
        raise StudyError(f"delay: {error}") from error


def _placing(options: argparse.Namespace) -> int:
    return placing.run(options)


def _bode(options: argparse.Namespace) -> int:
    return bode_command.run(options)


def _sway(options: argparse.Namespace) -> int:
    return sway_command.run(options)


def _sweep(options: argparse.Namespace) -> int:
    return sweep_command.run(options)


def _baseline(options: argparse.Namespace) -> int:
    try:
        return baseline_command.run(options)
    except PathError as error:
        raise StudyError(f"baseline: {error}") from error


def _diagnosis(options: argparse.Namespace) -> int:
    return diagnosis_command.run(options)


def _logs(options: argparse.Namespace) -> int:
    return logs_command.run(options)


def _ablation(options: argparse.Namespace) -> int:
    new_directory(options.out)
    return ablation_command.run(options)


def _cycles(options: argparse.Namespace) -> int:
    new_directory(options.out)
    return cycles_command.run(options)


def _matrix(options: argparse.Namespace) -> int:
    new_directory(options.out)
    try:
        return matrix_command.run(options)
    except PathError as error:
        raise StudyError(f"matrix: {error}") from error


def _tune(options: argparse.Namespace) -> int:
    try:
        return tune_command.run(options)
    except PathError as error:
        raise StudyError(f"tune: {error}") from error


def _faults(options: argparse.Namespace) -> int:
    new_directory(options.out)
    return faults_command.run(options)


def _track(options: argparse.Namespace) -> int:
    try:
        return track_command.run(options)
    except PathError as error:
        raise StudyError(f"track: {error}") from error


if __name__ == "__main__":
    sys.exit(main())
