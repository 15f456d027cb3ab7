"""`forest-bag`: record, repair and use bags, with verbs and flags as `ros2 bag` users know them.

Each verb is a module with `add_parser(subparsers)`, which names its flags and sets `command`, a function that
takes the parsed arguments and returns the exit code. What such a module needs from ROS it imports when it
runs: help must not wait for it. Exit codes: 0 well, 1 failed, 2 wrong arguments, 130 stopped.
"""

import argparse
import sys
from collections.abc import Sequence

from forest_bag.cli import (
    compare_command,
    convert_command,
    import_command,
    info_command,
    play_command,
    plot_command,
    record_command,
    recover_command,
    reindex_command,
    table_command,
)
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.runtime import command_line

PROGRAM = "forest-bag"
VERBS = (
    *(record_command, recover_command, play_command, info_command, compare_command),
    *(convert_command, reindex_command, table_command, plot_command, import_command),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    return command_line.run(PROGRAM, _parser().parse_args(arguments), (BagError,))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description="Record, repair and use bags.")
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    for verb in VERBS:
        verb.add_parser(verbs)
    return parser


if __name__ == "__main__":
    sys.exit(main())
