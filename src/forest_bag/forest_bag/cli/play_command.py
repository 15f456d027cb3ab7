"""`forest-bag play` and `burst`: bags' messages onto their topics again, in their time or at once."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from forest_bag.play.play_options import NAME, PlayOptions
from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.interfaces.qos_overrides import QosOverrideError, read_overrides
from forest_msgs_py.runtime.command_line import Command, Subcommands, number, subcommand, whole

CANNOT_PLAY = 2  # exit code
CHECKED_PER_S = 150e6  # bytes of a file, by zstd some 6 times as many (benchmarks/checking.py)
LONG = 3.0  # [s] of checking, of which one is told beforehand
CLOCK_HZ = 40.0  # as `ros2 bag play`
KEYS = (
    "Keys: space pause, right next message, left 5 s back, up or + faster, down or - slower. Services: "
    "docs/reference/bags.md; parameters rate and seek."
)


def add_parser(verbs: Subcommands) -> None:
    """Add both verbs and their flags."""
    _add_play(_add(verbs, "play", "publish bags' messages again, in their time", run))
    burst = _add(verbs, "burst", "publish bags' messages as fast as possible, then pause", run_burst)
    burst.add_argument(
        "-n",
        "--num-messages",
        type=whole(0, 10**9),
        default=0,
        metavar="N",
        help="messages to publish before a pause (default: all, then end)",
    )


def _add(
    verbs: Subcommands,
    name: str,
    text: str,
    command: Command,
) -> argparse.ArgumentParser:
    """Add a verb with what both have in common."""
    parser = subcommand(verbs, name, text, command, KEYS)
    add = parser.add_argument
    add(
        "bags",
        type=Path,
        nargs="+",
        metavar="BAG",
        help="directory, .mcap or .db3 file; several are merged by time",
    )
    add("--start-offset", type=number(0.0), default=0.0, metavar="S", help="time in the bag to begin at")
    add("--topics", nargs="+", default=[], metavar="TOPIC", help="topics to use (default: all)")
    add("--exclude", "--exclude-topics", dest="exclude", nargs="+", default=[], metavar="TOPIC",
        help="topics to leave out")  # fmt: skip
    add("-m", "--remap", nargs="+", type=_remap, default=[], metavar="OLD:=NEW",
        help="publish topic OLD as NEW")  # fmt: skip
    add("--qos-profile-overrides-path", type=Path, metavar="FILE.yaml",
        help="QoS of the publishers (default: as recorded)")  # fmt: skip
    add("-d", "--delay", type=number(0.0, 3600.0), default=0.5, metavar="S",
        help="time before the first message, for subscribers to be found (default: 0.5)")  # fmt: skip
    add("--wait-for-subscribers", action="store_true",
        help="begin when every played topic has a subscriber")  # fmt: skip
    add("--no-check", action="store_true",
        help="begin at once, without the check of all bytes before the first message")  # fmt: skip
    return parser


def _add_play(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "-r",
        "--rate",
        type=number(0.0, 1e6),
        default=1.0,
        help="speed of the bag's time (default: 1; 0: as fast as possible)",
    )
    add("-l", "--loop", action="store_true", help="begin again at the end")
    add("--duration", "--playback-duration", dest="duration", type=number(0.0), metavar="S",
        help="length to be played, in the bag's time (default: to the end)")  # fmt: skip
    add("--clock", nargs="?", type=number(0.1, 1e4), const=CLOCK_HZ, default=0.0, metavar="HZ",
        help="publish the bag's time on /clock at this rate (default: 40)")  # fmt: skip
    add("-p", "--start-paused", action="store_true", help="begin at the space bar, or at ~/resume")
    add("--stats", action="store_true", help="print at the end how late the messages were")


def run(options: argparse.Namespace) -> int:
    """Play; return the exit code."""
    return _played(
        options,
        lambda common: common._replace(
            rate=options.rate,
            loop=options.loop,
            duration=options.duration,
            clock=options.clock,
            paused=options.start_paused,
            stats=options.stats,
        ),
    )


def run_burst(options: argparse.Namespace) -> int:
    """Burst; return the exit code."""
    return _played(options, lambda common: common._replace(burst=options.num_messages))


def _played(options: argparse.Namespace, further: Callable[[PlayOptions], PlayOptions]) -> int:
    try:
        path = options.qos_profile_overrides_path
        overrides = {} if path is None else read_overrides(path)
        if not options.no_check:
            _check(options.bags)
    except (BagError, QosOverrideError, OSError) as error:
        print(f"forest-bag: {error}", file=sys.stderr)
        return CANNOT_PLAY
    from forest_bag.player_node import PlayerNode
    from forest_msgs_py.runtime.node import run_node

    common = PlayOptions(
        bags=tuple(options.bags),
        start_offset=options.start_offset,
        topics=tuple(options.topics),
        exclude=tuple(options.exclude),
        remaps=tuple(options.remap),
        overrides=overrides,
        wait_for_subscribers=options.wait_for_subscribers,
        delay=options.delay,
    )
    return run_node(lambda: PlayerNode(further(common)), [])


def _check(bags: list[Path]) -> None:
    """Read all of the bags: what is found behind half of it would be found with the machine in motion.

    Raises:
        BagError: one is no bag, or bytes of it were changed.
        OSError: one cannot be read.
    """
    with MergedBags(bags) as reader:
        seconds = reader.size / CHECKED_PER_S
        if seconds > LONG:
            told = f"checking {reader.path} first, some {seconds:.0f} s (not with --no-check)"
            print(f"forest-bag: {told}", file=sys.stderr)
        reader.check()


def _remap(text: str) -> tuple[str, str]:
    old, mark, new = text.partition(":=")
    if not (old and mark and NAME.fullmatch(new)):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: OLD:=NEW, two topic names")
    return old, new
