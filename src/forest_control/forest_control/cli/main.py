"""`forest-control`: taught work from the command line.

Each verb is a module with `add_parser(subparsers)`, which names its flags and sets `command`, a function that
takes the parsed arguments and returns the exit code. What such a module needs from ROS it imports when it
runs: help must not wait for it. Exit codes: 0 well, 1 failed, 2 wrong arguments, 130 stopped.
"""

import argparse
import sys
from collections.abc import Sequence

from forest_control.cli import cycle_files, cycle_live
from forest_control.config.setting_file import SettingFileError
from forest_control.taught.tip_path import PathError
from forest_msgs_py.runtime import command_line
from forest_msgs_py.runtime.command_line import subcommand

PROGRAM = "forest-control"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    return command_line.run(PROGRAM, _parser().parse_args(arguments), (SettingFileError, PathError))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description="Taught work of the crane.")
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    text = "cycles of taught work: teach, look at, play"
    cycle = subcommand(verbs, "cycle", text)
    cycle_verbs = cycle.add_subparsers(title="verbs", required=True, metavar="VERB")
    cycle_files.add_parsers(cycle_verbs)
    cycle_live.add_parsers(cycle_verbs)
    return parser


if __name__ == "__main__":
    sys.exit(main())
