"""`forest-bag reindex`: a bag's metadata.yaml made anew from its files."""

import argparse
from pathlib import Path

from forest_msgs_py.runtime.command_line import Subcommands, subcommand


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "make a bag's metadata.yaml anew from its files"
    parser = subcommand(verbs, "reindex", text, run)
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="directory of the bag; its files are not changed"
    )


def run(options: argparse.Namespace) -> int:
    """Reindex; return the exit code.

    Raises:
        BagError: this is no directory of bag files, or one of them is damaged.
        OSError: it cannot be read or written.
    """
    from forest_bag.recovery.reindex import reindex

    about = reindex(options.bag)
    count, topics = about["message_count"], len(about["topics_with_message_count"])
    files = about["relative_file_paths"]
    print(f"{options.bag}: {count} messages of {topics} topics in {', '.join(files)}")
    return 0
