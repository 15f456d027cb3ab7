"""`forest-ident`: from experiments to a machine file, from the command line.

The program itself is `forest_study.experiments.forest_ident_main`, which adds the verb that starts a graph.
Each verb is a module
with `add_parser(subparsers)`, which names its flags and sets `command`, a function that takes the parsed
arguments and returns the exit code. Exit codes: 0 well, 1 failed, 2 wrong arguments, 3 trusted but for some
parameters, 4 not trusted, 130 stopped.
"""

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from forest_bag.storage.bag_files import BagError
from forest_description.config.parameter import MachineError
from forest_ident.actuator.record import RecordError
from forest_ident.cli import (
    actuator_command,
    diagnose_command,
    fit_command,
    questions_command,
    validate_command,
)
from forest_ident.measurements.session import SessionError
from forest_msgs_py.runtime import command_line

PROGRAM = "forest-ident"
VERBS = (fit_command, validate_command, diagnose_command, questions_command, actuator_command)
ERRORS = (BagError, MachineError, RecordError, SessionError)


def main(
    arguments: Sequence[str] | None = None,
    more_verbs: Sequence[Any] = (),
    more_errors: tuple[type[Exception], ...] = (),
) -> int:
    """Run one verb; return its exit code.

    Args:
        arguments: default: the command line's.
        more_verbs: modules of verbs, listed before those of this package.
        more_errors: exceptions of theirs whose text is the sentence for the user.
    """
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description="Learn a crane's parameters from its records, and check them."
    )
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    for verb in (*more_verbs, *VERBS):
        verb.add_parser(verbs)
    return command_line.run(PROGRAM, parser.parse_args(arguments), (*ERRORS, *more_errors))


if __name__ == "__main__":
    sys.exit(main())
