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

from __future__ import annotations

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
_UNREADABLE = "bytes that are no such message; allowed: %s"

Pick = Callable[[Sequence[float]], tuple[float, ...]]


class _Array(NamedTuple):
    prefix: bytes
    numbers: struct.Struct
    place: int
    size: int
    pick: Pick


class ArrayReader:
    """Reads a Float64MultiArray as `read_float_array` does.

    Args:
        topic: row of the topic table.
        labels: wanted; default: the topic's.
    """

    def __init__(self, topic: Topic, labels: tuple[str, ...] | None = None) -> None:
        self._topic, self._labels = topic, topic.labels if labels is None else labels
        self._class = message_class(topic)
        self._known: _Array | None = None

    def read(self, data: bytes, now_ns: int) -> Reading:
        """Values of the array, one per label, all finite; `now_ns` is the stamp of one that carries none."""
        known = self._known
        if known is not None and data.startswith(known.prefix) and len(data) >= known.size:
            numbers = known.numbers.unpack_from(data, known.place)
            stamp_ns, values = array_stamp(numbers), known.pick(numbers)
            if stamp_ns is not None and math.isfinite(sum(values)):
                return Reading(stamp_ns, values, "")
        return self._judge(data, now_ns)

    def _judge(self, data: bytes, now_ns: int) -> Reading:
        message = _decoded(data, self._class)
        if message is None:
            return Reading(now_ns, (), f"{self._topic.name}: {_UNREADABLE % self._topic.type}")
        reading = read_float_array(self._topic, message, now_ns, self._labels)
        if not reading.problem and message.layout.data_offset == STAMP_SIZE and _is_plain_cdr(data):
            self._known = self._learnt(data, message)
        return reading

    def _learnt(self, data: bytes, message: Any) -> _Array:
        end = after_dimensions(data) + 8  # behind data_offset and the count
        place = FIRST + aligned(end - FIRST, DOUBLE)
        text = message.layout.dim[0].label if message.layout.dim else ""
        names = [name.strip() for name in text.split(",")] if text else self._topic.labels
        at = {name: STAMP_SIZE + n for n, name in enumerate(names)}
        numbers = struct.Struct(f"<{len(message.data)}d")
        return _Array(
            prefix=data[:end],
            numbers=numbers,
            place=place,
            size=place + numbers.size,
            pick=_picker(at, self._labels),
        )


class _Joints(NamedTuple):
    prefix: bytes
    numbers: struct.Struct
    place: int
    size: int
    counts: Pick  # of velocities and efforts
    expected: tuple[float, ...]
    position: Pick
    velocity: Pick
    effort: Pick


class JointReader:
    """Reads a JointState as `read_joint_state` does.

    Args:
        names: of the joints, in the order in which they are wanted.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._known: _Joints | None = None

    def read(self, data: bytes) -> Reading:
        """The joints' values, whatever their order in the message."""
        known = self._known
        if known is not None and data.startswith(known.prefix, AFTER_STAMP) and len(data) >= known.size:
            numbers = known.numbers.unpack_from(data, known.place)
            values = JointValues(known.position(numbers), known.velocity(numbers), known.effort(numbers))
            finite = math.isfinite(sum(map(sum, values)))
            if finite and known.counts(numbers) == known.expected and _is_plain_cdr(data):
                return Reading(_header_stamp(data), values, "")
        return self._judge(data)

    def _judge(self, data: bytes) -> Reading:
        message = _decoded(data, _JOINT_STATE)
        if message is None:
            return Reading(0, JointValues(), f"joint state: {_UNREADABLE % topics.JOINT_STATE}")
        reading = read_joint_state(self._names, message)
        if not reading.problem and _is_plain_cdr(data):
            self._known = self._learnt(data, message)
        return reading

    def _learnt(self, data: bytes, message: Any) -> _Joints | None:
        """Where the numbers stand; None of a message that has other numbers than all or none of each kind."""
        n, rest = len(message.name), (len(message.velocity), len(message.effort))
        if len(message.position) != n or not set(rest) <= {0, n}:
            return None
        end = _after_names(data, n) + 4  # behind the count of positions
        place = FIRST + aligned(end - FIRST, DOUBLE)
        numbers = struct.Struct("<" + _joint_format(n, *rest))
        first = (n + 1, n + 1 + rest[0] + 1)  # velocity, effort, among what is unpacked
        at = {name: place for place, name in enumerate(message.name)}
        picks = [
            _picker({name: begin + k for name, k in at.items()}, self._names) if count else _nothing
            for begin, count in zip((0, *first), (n, *rest), strict=True)
        ]
        counts = itemgetter(first[0] - 1, first[1] - 1)
        return _Joints(data[AFTER_STAMP:end], numbers, place, place + numbers.size, counts, rest, *picks)


def read_joy_data(data: bytes, min_axes: int = 4, min_buttons: int = 1) -> tuple[Reading, str]:
    """Levers and buttons as `read_joy` reads them, and the message's frame_id."""
    try:
        return _joy(data, min_axes, min_buttons)
    except (struct.error, UnicodeDecodeError):
        message = _decoded(data, _JOY)
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


def _decoded(data: bytes, kind: Any) -> Any:
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


def _joint_format(positions: int, velocities: int, efforts: int) -> str:
    """Doubles, then twice a count and its doubles; counts are filled up to the next multiple of eight."""
    if not velocities:
        return f"{positions}dII{efforts}d"
    return f"{positions}dI4x{velocities}dI" + (f"4x{efforts}d" if efforts else "")


def _after_names(data: bytes, count: int) -> int:
    """Where the count of positions stands, behind the frame and the names of a JointState."""
    place = _after_string(data, AFTER_STAMP) + 4
    for _ in range(count):
        place = _after_string(data, place)
    return place


def _after_string(data: bytes, place: int) -> int:
    (length,) = struct.unpack_from("<I", data, place)
    return aligned(place + 4 + length, 4)


def _picker(at: dict[str, int], wanted: Sequence[str]) -> Pick:
    """Takes the wanted numbers, in their order."""
    places = [at[name] for name in wanted]
    first = places[0]
    if places == list(range(first, first + len(places))):
        return itemgetter(slice(first, first + len(places)))
    return itemgetter(*places)


def _nothing(_numbers: Sequence[float]) -> tuple[float, ...]:
    return ()
