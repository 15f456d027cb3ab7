"""Joystick messages of a bag, to be published again.

Time counts from the beginning of the recorded run: the first /clock of a run in lockstep, else the
first joystick message. So a run in lockstep is repeated step by step, pauses included.
"""

from bisect import bisect_right
from pathlib import Path
from typing import NamedTuple

from forest_bag.read.bag_reader import READERS, BagReader
from forest_bag.storage.bag_files import BagError
from forest_control.operator.joystick_sources import LeverError
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.stamps import stamp_in
from forest_msgs_py.types import NS_PER_S

SUFFIXES = (*READERS, ".zstd")


class JoyRecord(NamedTuple):
    """Serialized messages and their times [ns since the run began]."""

    times_ns: tuple[int, ...]
    messages: tuple[bytes, ...]
    length: float  # [s] of the run

    def newest(self, elapsed_ns: int) -> int:
        """Return the place of the message that was the newest at a time; -1 before the first."""
        return bisect_right(self.times_ns, elapsed_ns) - 1


def is_bag(path: Path) -> bool:
    """Tell whether a joystick source is a bag rather than a CSV file."""
    return path.is_dir() or path.suffix in SUFFIXES


def read_joy_record(path: Path) -> JoyRecord:
    """Read the joystick of a bag.

    Raises:
        LeverError: there is no bag, or no joystick in it.
    """
    stamps: dict[topics.Topic, list[int]] = {topics.JOY: [], topics.CLOCK: []}
    messages: list[bytes] = []
    try:
        with BagReader(path) as bag:
            rows = {name: topics.find(name) for name in bag.channels}
            for message in bag.messages([name for name, row in rows.items() if row in stamps]):
                row = rows[message.channel.topic]
                assert row is not None
                stamps[row].append(stamp_in(row.type, message.data))
                if row == topics.JOY:
                    messages.append(message.data)
    except (BagError, OSError) as error:
        raise LeverError(str(error)) from error
    if not messages:
        raise LeverError(f"{path} holds no message of a joystick on /joy; allowed: a bag with one")
    run = stamps[topics.CLOCK] or stamps[topics.JOY]
    times = tuple(stamp - run[0] for stamp in stamps[topics.JOY])
    return JoyRecord(times, tuple(messages), (run[-1] - run[0]) / NS_PER_S)
