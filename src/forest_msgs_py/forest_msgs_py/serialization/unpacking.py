"""Numbers from CDR bytes, for nodes that hear the same thing again and again: the counterpart of `packing`.

To have rclpy make a message object of bytes, and to look through its names, takes many times as long as
unpacking the numbers from where they stood the last time. So a reader learns from the first message of a
talker where they stand; what looks otherwise, or has something wrong with it, goes through
:mod:`forest_msgs_py.interfaces.messages`, whose judgement is the only one.

===========  ===============================================================================================
symbol       meaning
===========  ===============================================================================================
prefix       bytes in front of the numbers: names, counts; the same in every message of a talker
place        offset of the first number in the bytes
===========  ===============================================================================================
"""

import math
import struct
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

from rclpy.serialization import deserialize_message

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import (
    STAMP_SIZE,
    JointValues,
    JoyValues,
    Reading,
    array_stamp,
    judged_joy,
    read_float_array,
    read_joint_state,
    read_joy,
)
from forest_msgs_py.interfaces.stamps import FIRST, after_dimensions, aligned
from forest_msgs_py.interfaces.topics import Topic, message_class, unlisted
from forest_msgs_py.serialization.cdr import ENCAPSULATION
from forest_msgs_py.types import NS_PER_S

DOUBLE = 8  # bytes
AFTER_STAMP = FIRST + 8
_JOINT_STATE = message_class(unlisted("", topics.JOINT_STATE))
_JOY = message_class(topics.JOY)
_POSE = message_class(topics.TIP_POSE)
_POSITION = struct.Struct("<3d")
_UNREADABLE = "bytes that are no such message; allowed: %s"

Pick = Callable[[Sequence[float]], tuple[float, ...]]


class _Layout(NamedTuple):
    """Where the numbers of a publisher's messages stand, as one of them showed."""

    fixed: tuple[tuple[int, bytes], ...]  # places of bytes that are the same in every message
    numbers: struct.Struct  # of each run
    places: tuple[int, ...]  # of the runs; 0: the run is empty
    size: int
    pick: Pick

    def runs(self, data: bytes) -> list[tuple[float, ...]] | None:
        """Return the numbers of each run; None: the message is laid out otherwise."""
        if len(data) < self.size:
            return None
        for place, part in self.fixed:
            if not data.startswith(part, place):
                return None
        return [self.numbers.unpack_from(data, place) if place else () for place in self.places]


class ArrayReader:
    """Reads a Float64MultiArray as `read_float_array` does.

    Args:
        topic: row of the topic table.
        labels: wanted; default: the topic's.
    """

    def __init__(self, topic: Topic, labels: tuple[str, ...] | None = None) -> None:
        self._topic, self._labels = topic, topic.labels if labels is None else labels
        self._class = message_class(topic)
        self._layout: _Layout | None = None

    def read(self, data: bytes, now_ns: int) -> Reading:
        """Values of the array, one per label, all finite; `now_ns` is the stamp of one that carries none."""
        if self._layout is not None and (runs := self._layout.runs(data)) is not None:
            stamp_ns, values = array_stamp(runs[0]), self._layout.pick(runs[0])
            if stamp_ns is not None and math.isfinite(sum(values)):
                return Reading(stamp_ns, values, "")
        return self._judge(data, now_ns)

    def _judge(self, data: bytes, now_ns: int) -> Reading:
        message = decoded(data, self._class)
        if message is None:
            return Reading(now_ns, (), f"{self._topic.name}: {_UNREADABLE % self._topic.type}")
        reading = read_float_array(self._topic, message, now_ns, self._labels)
        if not reading.problem and message.layout.data_offset == STAMP_SIZE and _is_plain_cdr(data):
            self._layout = self._learnt(data, message)
        return reading

    def _learnt(self, data: bytes, message: Any) -> _Layout:
        end = after_dimensions(data) + 8  # behind data_offset and the count
        place = FIRST + aligned(end - FIRST, DOUBLE)
        text = message.layout.dim[0].label if message.layout.dim else ""
        names = [name.strip() for name in text.split(",")] if text else list(self._topic.labels)
        numbers = struct.Struct(f"<{len(message.data)}d")
        pick = _picker([""] * STAMP_SIZE + names, self._labels)
        return _Layout(
            fixed=((0, data[:end]),), numbers=numbers, places=(place,), size=place + numbers.size, pick=pick
        )


class JointReader:
    """Reads a JointState as `read_joint_state` does.

    Args:
        names: of the joints, in the order in which they are wanted.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._layout: _Layout | None = None

    def read(self, data: bytes) -> Reading:
        """The joints' values, whatever their order in the message."""
        if self._layout is not None and (runs := self._layout.runs(data)) is not None:
            pick = self._layout.pick
            values = JointValues(*(pick(run) if run else () for run in runs))
            if math.isfinite(sum(map(sum, values))):
                return Reading(_header_stamp(data), values, "")
        return self._judge(data)

    def _judge(self, data: bytes) -> Reading:
        message = decoded(data, _JOINT_STATE)
        if message is None:
            return Reading(0, JointValues(), f"joint state: {_UNREADABLE % topics.JOINT_STATE}")
        reading = read_joint_state(self._names, message)
        if not reading.problem and _is_plain_cdr(data):
            self._layout = self._learnt(data, message)
        return reading

    def _learnt(self, data: bytes, message: Any) -> _Layout | None:
        """Where the numbers stand; None of a message that has other numbers than all or none of each kind."""
        n = len(message.name)
        counts = len(message.position), len(message.velocity), len(message.effort)
        if counts[0] != n or not set(counts) <= {0, n}:
            return None
        place = _after_names(data, n)
        fixed, places = [(0, ENCAPSULATION[:2]), (AFTER_STAMP, data[AFTER_STAMP:place])], []
        for count in counts:
            fixed.append((place, data[place : place + 4]))
            place += 4
            if count:
                place = FIRST + aligned(place - FIRST, DOUBLE)
            places.append(place if count else 0)
            place += DOUBLE * count
        numbers = struct.Struct(f"<{n}d")
        return _Layout(
            fixed=tuple(fixed),
            numbers=numbers,
            places=tuple(places),
            size=place,
            pick=_picker(message.name, self._names),
        )


def read_joy_data(data: bytes, min_axes: int = 4, min_buttons: int = 1) -> tuple[Reading, str]:
    """Levers and buttons as `read_joy` reads them, and the message's frame_id."""
    try:
        return _joy(data, min_axes, min_buttons)
    except (struct.error, UnicodeDecodeError):
        message = decoded(data, _JOY)
    if message is None:
        return Reading(0, JoyValues(), f"joy: {_UNREADABLE % topics.JOY_TYPE}"), ""
    return read_joy(message, min_axes, min_buttons), message.header.frame_id


def _joy(data: bytes, min_axes: int, min_buttons: int) -> tuple[Reading, str]:
    if not _is_plain_cdr(data):
        raise struct.error
    (length,) = struct.unpack_from("<I", data, AFTER_STAMP)
    place = aligned(AFTER_STAMP + 4 + length, 4)
    frame = data[AFTER_STAMP + 4 : AFTER_STAMP + 3 + length].decode()
    (count,) = struct.unpack_from("<I", data, place)
    axes = struct.unpack_from(f"<{count}f", data, place + 4)
    place += 4 + 4 * count
    (count,) = struct.unpack_from("<I", data, place)
    values = JoyValues(axes, struct.unpack_from(f"<{count}i", data, place + 4))
    return judged_joy(_header_stamp(data), values, min_axes, min_buttons), frame


def read_position(data: bytes) -> tuple[float, float, float] | None:
    """Position of a PoseStamped; None: the bytes are none."""
    try:
        if not _is_plain_cdr(data):
            raise struct.error
        behind = _after_string(data, AFTER_STAMP)
        x, y, z = _POSITION.unpack_from(data, FIRST + aligned(behind - FIRST, DOUBLE))
        return x, y, z
    except struct.error:
        message = decoded(data, _POSE)
    if message is None:
        return None
    place = message.pose.position
    return place.x, place.y, place.z


def decoded(data: bytes, kind: Any) -> Any:
    """The message, or None if the bytes are none: a loop must go on whatever arrives."""
    try:
        return deserialize_message(data, kind)
    except (RuntimeError, MemoryError, UnicodeDecodeError):
        return None


def _is_plain_cdr(data: bytes) -> bool:
    return data.startswith(ENCAPSULATION[:2])


def _header_stamp(data: bytes) -> int:
    sec, nanosec = struct.unpack_from("<iI", data, FIRST)
    return int(sec) * NS_PER_S + int(nanosec)


def _after_names(data: bytes, count: int) -> int:
    """Where the count of positions stands, behind the frame and the names of a JointState."""
    place = _after_string(data, AFTER_STAMP) + 4
    for _ in range(count):
        place = _after_string(data, place)
    return place


def _after_string(data: bytes, place: int) -> int:
    (length,) = struct.unpack_from("<I", data, place)
    return aligned(place + 4 + length, 4)


def _picker(names: Sequence[str], wanted: Sequence[str]) -> Pick:
    """Takes the wanted numbers, in their order, of those that belong to some names."""
    places = [names.index(name) for name in wanted]
    first = places[0]
    if places == list(range(first, first + len(places))):
        return itemgetter(slice(first, first + len(places)))
    return itemgetter(*places)
