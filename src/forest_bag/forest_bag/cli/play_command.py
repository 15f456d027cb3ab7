"""`forest-bag play`: a bag's messages onto their topics again, in their time."""

import argparse
import sys
from pathlib import Path

from forest_bag.play.play_options import NAME, PlayOptions
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.runtime.command_line import number

CANNOT_PLAY = 2  # exit code
CHECKED_PER_S = 150e6  # bytes of a file, by zstd some 6 times as many (benchmarks/checking.py)
LONG = 3.0  # [s] of checking, of which one is told beforehand
CLOCK_HZ = 40.0  # as `ros2 bag play`


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its flags."""
    text = "publish a bag's messages again, in their time"
    parser = verbs.add_parser(
        "play",
        help=text,
        description=text.capitalize() + ".",
        epilog="Keys: space pause, right next message, left 5 s back, up or + faster, down or - "
        "slower. Services ~/pause, ~/resume, ~/toggle_paused, ~/play_next (std_srvs/Trigger); parameters "
        "rate and seek.",
    )
    parser.set_defaults(command=run)
    parser.add_argument("bag", type=Path, metavar="BAG", help="a directory, .mcap or .db3")
    parser.add_argument(
        "-r", "--rate", type=number(0.0, 1e6), default=1.0, help="default: 1; 0: as fast as possible"
    )
    parser.add_argument("-l", "--loop", action="store_true", help="again and again")
    parser.add_argument("--start-offset", type=number(0.0), default=0.0, metavar="S", help="begin there")
    parser.add_argument(
        "--duration",
        "--playback-duration",
        dest="duration",
        type=number(0.0),
        metavar="S",
        help="of the bag's time (default: to its end)",
    )
    parser.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="only these")
    parser.add_argument(
        "--exclude",
        "--exclude-topics",
        dest="exclude",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="all but these",
    )
    parser.add_argument(
        "-m",
        "--remap",
        nargs="+",
        type=_remap,
        default=[],
        metavar="OLD:=NEW",
        help="publish under another name",
    )
    parser.add_argument(
        "--clock",
        nargs="?",
        type=number(0.1, 1e4),
        const=CLOCK_HZ,
        default=0.0,
        metavar="HZ",
        help="publish the bag's time on /clock (default rate: 40)",
    )
    parser.add_argument("-p", "--start-paused", action="store_true", help="wait for space, or ~/resume")
    parser.add_argument(
        "--wait-for-subscribers", action="store_true", help="begin when every topic that is played has one"
    )
    parser.add_argument(
        "-d",
        "--delay",
        type=number(0.0, 3600.0),
        default=0.5,
        metavar="S",
        help="before the first message, for readers to find the player (default: 0.5)",
    )
    parser.add_argument(
        "--no-check",
        action="store_true",
        help="play at once: without it the whole bag is read first, and not played if bytes were changed",
    )
    parser.add_argument("--stats", action="store_true", help="tell at the end how late messages were")


def run(options: argparse.Namespace) -> int:
    """Play; return the exit code."""
    try:
        if not options.no_check:
            _check(options.bag)
    except (BagError, OSError) as error:
        print(f"forest-bag: {error}", file=sys.stderr)
        return CANNOT_PLAY
    from forest_bag.player_node import PlayerNode
    from forest_msgs_py.runtime.node import run_node

    chosen = PlayOptions(
        bag=options.bag,
        rate=options.rate,
        loop=options.loop,
        start_offset=options.start_offset,
        duration=options.duration,
        topics=tuple(options.topics),
        exclude=tuple(options.exclude),
        remaps=tuple(options.remap),
        clock=options.clock,
        paused=options.start_paused,
        wait_for_subscribers=options.wait_for_subscribers,
        delay=options.delay,
        stats=options.stats,
    )
    return run_node(lambda: PlayerNode(chosen), [])


def _check(bag: Path) -> None:
    """Read all of a bag: what is found behind half of it would be found with the machine in motion.

    Raises:
        BagError: this is no bag, or bytes of it were changed.
        OSError: it cannot be read.
    """
    with BagReader(bag) as reader:
        seconds = reader.size / CHECKED_PER_S
        if seconds > LONG:
            print(
                f"forest-bag: checking {bag} first, some {seconds:.0f} s (not with --no-check)",
                file=sys.stderr,
            )
        reader.check()


def _remap(text: str) -> tuple[str, str]:
    old, mark, new = text.partition(":=")
    if not (old and mark and NAME.fullmatch(new)):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: OLD:=NEW, two topic names")
    return old, new
