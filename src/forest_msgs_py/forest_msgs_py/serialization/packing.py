"""One topic's messages as CDR bytes, one at a time: for nodes that say the same thing again and again.

To build a message object and have rclpy turn it into bytes takes ten times as long as packing the numbers
into the bytes of an earlier message. Gaps between fields, in which ROS' serializer leaves what was in
memory, are zero here, so that a run that repeats, repeats to the byte.
"""

import math
import struct
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from forest_msgs_py.interfaces.messages import (
    JoyValues,
    pose_stamped,
    sensor_array,
    sensor_joint_state,
    twist_stamped,
)
from forest_msgs_py.interfaces.topics import FLOAT_ARRAY, JOINT_STATE, POSE, TWIST, Topic, columns
from forest_msgs_py.serialization.cdr import ENCAPSULATION, to_cdr
from forest_msgs_py.types import NS_PER_S

DOUBLE = 8  # bytes
MARKED_STAMP = 1_234_567_891_987_654_321  # [ns]
MARK = 1.2345678912345e-77  # times 1, 2, 3 …; no message has such numbers


class Run(NamedTuple):
    """Numbers that stand side by side, both in the message and among the values."""

    packer: struct.Struct
    place: int
    first: int
    end: int


class Template(NamedTuple):
    """A message's bytes, and where in them stamp and numbers stand; ``stamp`` None: it carries none."""

    data: bytes
    stamp: struct.Struct | None
    stamp_place: int
    runs: tuple[Run, ...]


class Packer:
    """Packs the messages of one topic.

    Args:
        topic: row of the topic table, of a type made of a stamp and numbers.
        frame: frame of poses and twists.
        plain: arrays without stamp.
    """

    def __init__(self, topic: Topic, frame: str = "", plain: bool = False) -> None:
        self._topic, self._frame, self._plain = topic, frame, plain
        self._size = len(columns(topic))
        self._templates: dict[tuple[bool, ...], Template | None] = {}
        self.whole = self._template((True,) * self._size)  # of a message in which nothing is missing

    def pack(self, stamp_ns: int, values: Sequence[float]) -> bytes | None:
        """A message with this stamp and these numbers, in the order of `topics.columns`.

        NaN stands for a sensor without a sample, which is left out; None if nothing is left.
        """
        if len(values) != self._size:
            raise ValueError(f"{self._topic.name}: {len(values)} numbers; allowed: {self._size}")
        template = self.whole
        if math.isnan(sum(values)):
            template = self._template(tuple(not math.isnan(value) for value in values))
        if template is None:
            return None
        data = bytearray(template.data)
        if template.stamp is not None:
            template.stamp.pack_into(data, template.stamp_place, *divmod(stamp_ns, NS_PER_S))
        for run in template.runs:
            run.packer.pack_into(data, run.place, *values[run.first : run.end])
        return bytes(data)

    def _template(self, present: tuple[bool, ...]) -> Template | None:
        """Learn, once, where the numbers of a message with these present stand."""
        if present not in self._templates:
            marks = [MARK * (n + 1) if there else math.nan for n, there in enumerate(present)]
            message = _message(self._topic, self._frame, marks, self._plain)
            self._templates[present] = None if message is None else self._learnt(to_cdr(message), marks)
        return self._templates[present]

    def _learnt(self, data: bytes, marks: list[float]) -> Template:
        wanted = [(n, struct.pack("<d", mark)) for n, mark in enumerate(marks) if not math.isnan(mark)]
        told = [(n, data.index(mark)) for n, mark in wanted if mark in data]
        if self._topic.type == FLOAT_ARRAY and self._plain:
            return Template(data, None, 0, _runs(told))
        stamp = struct.Struct("<dd" if self._topic.type == FLOAT_ARRAY else "<iI")
        place = data.index(stamp.pack(*divmod(MARKED_STAMP, NS_PER_S)))
        return Template(data, stamp, place, _runs(told))


class NumberPublisher:
    """Publishes stamps and numbers.

    Args:
        publish: publishes the bytes of a message of the topic.
        packer: of its messages.
    """

    def __init__(self, publish: Callable[[bytes], None], packer: Packer) -> None:
        self._publish, self._packer = publish, packer

    def publish(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Publish a message with this stamp and these numbers, unless all of them are missing."""
        data = self._packer.pack(stamp_ns, values)
        if data is not None:
            self._publish(data)


def pack_joy(stamp_ns: int, frame: str, joy: JoyValues) -> bytes:
    """A Joy message."""
    text = frame.encode() + b"\0"
    text += bytes(-len(text) % 4)
    size, axes, buttons = len(frame.encode()) + 1, len(joy.axes), len(joy.buttons)
    stamp = divmod(stamp_ns, NS_PER_S)
    numbers = struct.pack(f"<I{axes}fI{buttons}i", axes, *joy.axes, buttons, *joy.buttons)
    return b"".join((ENCAPSULATION, struct.pack("<iII", *stamp, size), text, numbers))


def pack_clock(stamp_ns: int) -> bytes:
    """A Clock message."""
    return ENCAPSULATION + struct.pack("<iI", *divmod(stamp_ns, NS_PER_S))


def _runs(told: list[tuple[int, int]]) -> tuple[Run, ...]:
    """Join numbers whose neighbours among the values are neighbours in the bytes, too."""
    if not told:
        return ()
    breaks = [
        index + 1
        for index, ((n, place), (after, then)) in enumerate(pairwise(told))
        if (after, then) != (n + 1, place + DOUBLE)
    ]
    edges = [0, *breaks, len(told)]
    return tuple(
        Run(struct.Struct(f"<{end - start}d"), told[start][1], told[start][0], told[end - 1][0] + 1)
        for start, end in pairwise(edges)
    )


def _message(topic: Topic, frame: str, values: list[float], plain: bool) -> Any:
    if topic.type == JOINT_STATE:
        n = len(topic.labels)
        return sensor_joint_state(topic.labels, MARKED_STAMP, values[:n], values[n : 2 * n], values[2 * n :])
    if topic.type in (POSE, TWIST):
        make = pose_stamped if topic.type == POSE else twist_stamped
        return None if any(map(math.isnan, values[:3])) else make(MARKED_STAMP, frame, values)
    return sensor_array(topic, MARKED_STAMP, values, plain)
