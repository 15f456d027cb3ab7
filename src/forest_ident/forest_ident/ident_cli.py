"""`forest-ident`: from experiments to a machine file, from the command line.

Each verb is a module with `add_parser(subparsers)`, which names its flags and sets `command`, a function that
takes the parsed arguments and returns the exit code. Exit codes: 0 well, 1 failed, 2 wrong arguments, 130
stopped.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from forest_description.machine import MachineError
from forest_ident import ident_actuator, ident_experiment, ident_fit, ident_questions, ident_validate
from forest_ident.actuator_record import RecordError
from forest_ident.session import SessionError
from forest_msgs_py.bag_files import BagError
from forest_sim import command_line

PROGRAM = "forest-ident"
VERBS = (ident_experiment, ident_fit, ident_validate, ident_questions, ident_actuator)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    errors = (BagError, MachineError, RecordError, SessionError)
    return command_line.run(PROGRAM, _parser().parse_args(arguments), errors)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description="Learn a crane's parameters from its records, and check them."
    )
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    for verb in VERBS:
        verb.add_parser(verbs)
    return parser


if __name__ == "__main__":
    sys.exit(main())
