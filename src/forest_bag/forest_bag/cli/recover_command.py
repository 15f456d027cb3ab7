"""`forest-bag recover`: a bag that every reader accepts, from what a killed recorder or a full disk left."""

import argparse
from pathlib import Path

from forest_bag.recovery.bag_recovery import Recovered, recover
from forest_bag.storage.bag_files import BagError, bag_files
from forest_msgs_py.runtime.command_line import Subcommands, subcommand


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "make a whole bag of what is readable in a damaged one"
    parser = subcommand(verbs, "recover", text, run)
    parser.add_argument("bag", type=Path, help="directory or .mcap file of the bag, which is not changed")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="to be made (default: BAG_recovered)"
    )


def run(options: argparse.Namespace) -> int:
    """Recover and say what there was; return the exit code.

    Raises:
        BagError: there is nothing to recover, or no message.
        OSError: the output exists, or the disk is full.
    """
    files = bag_files(options.bag)
    output = options.output or options.bag.resolve().with_name(f"{options.bag.resolve().stem}_recovered")
    if output.exists():
        raise BagError(f"{output} exists; allowed: a directory to be made (-o DIR)")
    recovered = recover(files, output)
    print("\n".join(_report(recovered)))
    if not recovered.messages:
        raise BagError(f"no message of {options.bag} can be read; {output} holds what else there was")
    print(f"recovered {recovered.messages} messages of {len(recovered.topics)} topics: {output}")
    return 0


def _report(recovered: Recovered) -> list[str]:
    """One line for each file: whole, cut off, or with holes."""
    lines = []
    for path, recovery in recovered.files:
        skipped = sum(damage.length for damage in recovery.damages)
        if not recovery.path.stat().st_size:
            words = "empty"
        elif not recovery.damages:
            words = "whole" if recovery.complete else "whole, but not ended"
        else:
            first = recovery.damages[0].start
            words = f"{skipped} bytes not readable, the first of them at byte {first}"
        lines.append(f"{recovery.path.name}: {words}" + (f" -> {path.name}" if path else ""))
    if recovered.nameless:
        lines.append(f"{recovered.nameless} messages belong to topics whose definition was damaged: left out")
    return lines
