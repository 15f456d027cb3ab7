"""`forest-bag compare`: whether two bags are the same, and if not, where and by how much.

Exit codes: 0 the same, 1 different, 2 a bag that cannot be compared, or wrong arguments.
"""

import argparse
import json
import math
import sys
from pathlib import Path

from forest_bag.compare.comparison import Comparison, Tolerance
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.runtime.command_line import Subcommands, output_file, path_in_errors

PICTURES = ".png", ".pdf", ".svg"
TROUBLE = 2  # as diff and cmp do: 1 means "different"


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "compare two bags: to the last bit, or within a tolerance"
    parser = verbs.add_parser(
        "compare", help=text, description=f"{text[0].upper()}{text[1:]}. {__doc__.split(chr(10))[2]}"
    )
    parser.set_defaults(command=run)
    parser.add_argument("a", type=Path, metavar="A", help="a bag")
    parser.add_argument("b", type=Path, metavar="B", help="another bag")
    parser.add_argument(
        "--tolerance",
        type=_tolerance,
        nargs="+",
        default=[("", 0.0)],
        metavar="T",
        help="largest difference allowed, in each signal's unit; TOPIC=T or TOPIC.LABEL=T for some "
        "(default: 0, the same bytes and log times)",
    )
    parser.add_argument("--topics", nargs="+", metavar="TOPIC", help="compare only these")
    parser.add_argument("--ignore", nargs="+", default=[], metavar="TOPIC", help="topics not to compare")
    parser.add_argument(
        "--align",
        metavar="start|TOPIC",
        help="for bags of different times: numbers over the time since the bag's start, or since the first "
        "message of a topic, interpolated; log times, texts and bytes are left out",
    )
    parser.add_argument(
        "--json", type=output_file(), metavar="FILE", help="write the differences as JSON; -: standard output"
    )
    parser.add_argument(
        "--picture",
        type=output_file(*PICTURES),
        metavar="FILE",
        help="draw the largest differences (.png, .pdf, .svg)",
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")


def run(options: argparse.Namespace) -> int:
    """Compare; return the exit code."""
    try:
        comparison = _compared(options)
        _write(comparison, options)
    except BrokenPipeError:  # whoever read our output has left: that says nothing of the bags
        raise
    except (BagError, OSError) as error:
        named = (
            f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else error
        )
        print(f"forest-bag: {named}", file=sys.stderr)
        return TROUBLE
    return 0 if comparison.same(_allowed(options.tolerance)) else 1


def _compared(options: argparse.Namespace) -> Comparison:
    from forest_bag.compare.alignment import compare_aligned
    from forest_bag.compare.pairing import compare

    with BagReader(options.a) as a, BagReader(options.b) as b:
        there = a.channels.keys() | b.channels.keys()
        for name in (*options.ignore, *(options.topics or ())):
            if name not in there:
                raise BagError(f"no topic '{name}' in either bag; there are {', '.join(sorted(there))}")
        for name, _ in options.tolerance:
            if not any(name in ("", one) or name.startswith(f"{one}.") for one in there):
                raise BagError(f"--tolerance {name}: no such topic; there are {', '.join(sorted(there))}")
        if options.align is None:
            return compare(a, b, options.ignore, options.topics)
        return compare_aligned(a, b, options.align, options.ignore, options.topics)


def _write(comparison: Comparison, options: argparse.Namespace) -> None:
    from forest_bag.compare.comparison_report import as_json, table

    tolerance = _allowed(options.tolerance)
    to_stdout = options.json is not None and str(options.json) == "-"
    if not options.quiet and not to_stdout:
        print(table(comparison, tolerance))
        print(f"{options.a} and {options.b} {'are the same' if comparison.same(tolerance) else 'differ'}")
    if options.json is not None:
        text = json.dumps(as_json(comparison, tolerance, (str(options.a), str(options.b))), indent=2)
        if to_stdout:
            print(text)
        else:
            with path_in_errors(options.json):
                options.json.write_text(text + "\n", encoding="utf-8")
    if options.picture is not None:
        from forest_bag.compare.comparison_plot import draw

        draw(comparison, options.a, options.b, options.picture)


def _tolerance(text: str) -> tuple[str, float]:
    """``1e-6``, ``/joint_states=1e-6`` or ``/joint_states.boom.position=1e-6``."""
    name, _, number = text.rpartition("=")
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if not value >= 0.0 or math.isinf(value):
        raise argparse.ArgumentTypeError(
            f"{text!r}; allowed: a number of 0 or more, TOPIC=T or TOPIC.LABEL=T"
        )
    return name, value


def _allowed(given: list[tuple[str, float]]) -> Tolerance:
    """The longest name that fits decides."""
    table = dict(given)

    def tolerance(topic: str, label: str) -> float:
        for name in (f"{topic}.{label}", topic, ""):
            if name in table:
                return table[name]
        return 0.0

    return tolerance
