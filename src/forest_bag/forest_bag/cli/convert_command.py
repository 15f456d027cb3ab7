"""`forest-bag convert`: bags written again as other bags, as `ros2 bag convert` does it."""

import argparse
from pathlib import Path

from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.runtime.command_line import Subcommands, subcommand


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "write bags again as others: filter, merge, split, storage, compression"
    parser = subcommand(verbs, "convert", text, run)
    parser.add_argument(
        "-i",
        "--input",
        action="append",
        nargs="+",
        required=True,
        metavar="BAG",
        help="directory, .mcap or .db3 file; may be repeated",
    )
    parser.add_argument(
        "-o",
        "--output-options",
        type=Path,
        required=True,
        metavar="FILE.yaml",
        help="output bags, with the keys of `ros2 bag convert`: docs/reference/bags.md",
    )


def run(options: argparse.Namespace) -> int:
    """Convert; return the exit code.

    Raises:
        BagError: the options or the bags do not allow it.
        OSError: a disk is full.
    """
    from forest_bag.convert.output_options import STORAGES, read_outputs
    from forest_bag.convert.rewrite import rewrite

    for words in options.input:
        if len(words) > 2 or (len(words) == 2 and words[1] not in STORAGES):
            raise BagError(f"--input {' '.join(words)}; allowed: a bag, and perhaps {' or '.join(STORAGES)}")
    outputs = read_outputs(options.output_options)
    with MergedBags([Path(words[0]) for words in options.input]) as source:
        held = sum(len(file.attachments) for reader in source.readers for file in reader.files)
        for output, writer in zip(outputs, rewrite(source, outputs), strict=True):
            files = f"{len(writer.files)} file{'s' * (len(writer.files) > 1)}"
            told = f"{writer.written} messages of {len(writer.counts)} topics in {files}"
            print(f"{output.directory}: {told}")
            if output.layout.storage == "sqlite3" and held:
                print(f"{output.directory}: attachments are left out; sqlite3 has no place for them")
    return 0
