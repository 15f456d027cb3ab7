"""A bag opened for the page: its span, signals, events and crane, found without reading all of it.

===========  ===============================================================================================
symbol       meaning
===========  ===============================================================================================
time         log time since the bag's first message [s]: the one clock that all its topics have
signal       ``TOPIC/LABEL``, as a live crane's; a topic in a namespace has its name in the topic table
===========  ===============================================================================================

Names, texts and sizes are whatever somebody recorded: all of them are limited.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from forest_bag.compare.pairing import WALL_CLOCK_TOPICS
from forest_bag.read.bag_reader import BagReader
from forest_bag.read.survey import string_text
from forest_bag.read.timeseries import series_of
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import RawMessage
from forest_description.machine import Machine
from forest_msgs_py.interfaces.topics import EVENTS, JOINT_STATES, JOINTS, ROBOT_DESCRIPTION, find
from forest_msgs_py.types import NS_PER_S
from forest_station.recordings.replay_crane import recorded_crane

SAMPLES = 9  # places, evenly over the bag, where labels are looked for: a sensor may come late
FIRST_MESSAGES = 20_000  # in which each topic's first message is looked for
LARGEST_MESSAGE = 1 << 16  # bytes; what is larger is a picture or a map
MOST_SIGNALS = 1000
MOST_EVENTS = 1000
LONGEST_TEXT = 200
LARGEST_URDF = 1 << 20


class ReplayBag:
    """An open bag; close it."""

    def __init__(self, path: str | Path, own: Machine) -> None:
        """Open a bag, damaged or not, of any kind that `BagReader` reads.

        Args:
            path: of the bag.
            own: the station's machine, where the bag does not tell.

        Raises:
            BagError: it is no bag, or has no message.
            OSError: it cannot be read.
        """
        self.reader = BagReader(path, lenient=True)
        try:
            self.start_ns, self.end_ns = self.reader.span
            if not any(file.pieces for file in self.reader.files):
                raise BagError(f"{self.reader.path.name} holds no message that can be read")
            self.notes: list[str] = []
            self.names = _names(self.reader)
            self.first = self._first_messages()
            late = self.names.keys() - self.first.keys()
            self._samples = self.first | self.reader.newest(late, self.end_ns)  # one message of each topic
            self.units: dict[str, str] = {}  # of every signal, in the order of a frame
            self.topics: dict[str, dict[str, int]] = {}  # recorded name → label → column
            self.angles: list[
                int
            ] = []  # columns of swing, boom and stick, where the passive joints are computed
            self._find_signals()
            self.crane = recorded_crane(self.reader, self._urdf(), own)
            self._add_crane()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let go of the files."""
        self.reader.close()

    @property
    def seconds(self) -> float:
        """Length [s]."""
        return (self.end_ns - self.start_ns) / NS_PER_S

    def description(self) -> dict[str, Any]:
        """Return what the page needs before the first frame, for JSON."""
        return {
            "start": self.start_ns / NS_PER_S,
            "seconds": self.seconds,
            "signals": list(self.units.items()),
            "events": list(self._events()),
            "first": {self.names[name]: self._since(message) for name, message in self.first.items()},
            "scene": self.crane.scene,
            "notes": [note[:LONGEST_TEXT] for note in (*self.reader.problems, *self.notes)],
        }

    def _urdf(self) -> str:
        """The recorded robot description; "" where there is none of a reasonable size."""
        message = next((m for name, m in self._samples.items() if find(name) == ROBOT_DESCRIPTION), None)
        return string_text(message.data) if message and len(message.data) <= LARGEST_URDF else ""

    def _since(self, message: RawMessage) -> float:
        return (message.log_ns - self.start_ns) / NS_PER_S

    def _first_messages(self) -> dict[str, RawMessage]:
        """The first message of each topic that begins early."""
        found: dict[str, RawMessage] = {}
        for number, message in enumerate(self.reader.messages()):
            found.setdefault(message.channel.topic, message)
            if number == FIRST_MESSAGES or len(found) == len(self.names):
                break
        return found

    def _find_signals(self) -> None:
        seen: dict[str, list[RawMessage]] = {name: [message] for name, message in self._samples.items()}
        wanted = [name for name in seen if find(name) not in (ROBOT_DESCRIPTION, EVENTS)]
        for time_ns in np.linspace(self.start_ns, self.end_ns, SAMPLES).tolist():
            for name, message in self.reader.newest(wanted, int(time_ns)).items():
                seen[name].append(message)
        for name in sorted(set(wanted) - set(WALL_CLOCK_TOPICS)):
            self._add_signals(name, seen[name])

    def _add_signals(self, name: str, messages: list[RawMessage]) -> None:
        told = self.names[name][:LONGEST_TEXT]
        if len(messages[0].data) > LARGEST_MESSAGE:
            self.notes.append(f"{told} is not shown: messages of {len(messages[0].data)} bytes")
            return
        try:
            series = series_of(self.reader.channels[name][0], messages)
        except ValueError as error:  # texts, or a type that nobody knows
            self.notes.append(f"{str(error)[:LONGEST_TEXT]}; it is not shown")
            return
        if len(self.units) + len(series.labels) > MOST_SIGNALS:
            self.notes.append(f"{told} is not shown: the page takes {MOST_SIGNALS} signals")
            return
        columns = self.topics.setdefault(name, {})
        for label, unit in zip(series.labels, series.units, strict=True):
            signal = f"{told}/{label}"
            if signal not in self.units and len(signal) <= 2 * LONGEST_TEXT:
                columns[label] = len(self.units)
                self.units[signal] = unit

    def _add_crane(self) -> None:
        """Add the passive joints' signals behind all others."""
        places = {name: place for place, name in enumerate(self.units)}
        angles = [places.get(f"{JOINT_STATES.name}/{joint}.position") for joint in JOINTS]
        if self.crane.note:
            self.notes.append(self.crane.note)
        if self.crane.machine is not None and None not in angles:
            self.angles = [place for place in angles if place is not None]
            self.units |= self.crane.signals

    def _events(self) -> Iterator[tuple[float, str]]:
        names = {name for name in self.names if find(name) == EVENTS}
        for number, message in enumerate(self.reader.messages(names) if names else ()):
            if number == MOST_EVENTS:
                return
            yield self._since(message), string_text(message.data[:LARGEST_MESSAGE])[:LONGEST_TEXT]


def _names(reader: BagReader) -> dict[str, str]:
    """Name under which the page knows each topic: a namespace is dropped unless two cranes were recorded."""
    plain = {name: row.name if (row := find(name)) else name for name in reader.channels}
    known = list(plain.values())
    return {name: (told if known.count(told) == 1 else name).lstrip("/") for name, told in plain.items()}
