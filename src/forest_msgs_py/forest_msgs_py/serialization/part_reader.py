"""What there is of some values, NaN for the rest: a machine without a sensor leaves its label out."""

import math
from typing import Any

from forest_msgs_py.interfaces.messages import read_float_array
from forest_msgs_py.interfaces.topics import JOINT_STATE, Topic, message_class
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader, decoded


class PartReader:
    """Reads arrays, or the positions of joint states.

    Args:
        topic: row of the topic table.
        labels: wanted; of a joint state with ".position".
    """

    def __init__(self, topic: Topic, labels: tuple[str, ...]) -> None:
        self._topic = topic
        self._wanted = tuple(label.removesuffix(".position") for label in labels)
        self._there, self._reader, self._size = self._wanted, self._of(self._wanted), -1

    def read(self, data: bytes) -> tuple[float, ...]:
        """Return a message's values by the wanted labels."""
        found = self._numbers(data) if len(data) == self._size else None
        if found is None:  # other labels than in the last message, or a number that is none
            self._there = self._labels_of(data)
            if not self._there:
                return (math.nan,) * len(self._wanted)
            self._reader, self._size = self._of(self._there), len(data)
            found = self._numbers(data)
        values = dict(zip(self._there, found or (), strict=False))
        return tuple(values.get(label, math.nan) for label in self._wanted)

    def _of(self, labels: tuple[str, ...]) -> Any:
        is_joints = self._topic.type == JOINT_STATE
        return JointReader(labels) if is_joints else ArrayReader(self._topic, labels)

    def _numbers(self, data: bytes) -> tuple[float, ...] | None:
        if isinstance(self._reader, JointReader):
            joints = self._reader.read(data)
            return None if joints.problem else joints.values.position
        array = self._reader.read(data, 0)
        return None if array.problem else array.values

    def _labels_of(self, data: bytes) -> tuple[str, ...]:
        """Return the wanted labels that a message has, each with a finite number."""
        message = decoded(data, message_class(self._topic))
        if message is None:
            return ()
        if self._topic.type == JOINT_STATE:
            return tuple(label for label in self._wanted if label in message.name)
        return tuple(
            label for label in self._wanted if not read_float_array(self._topic, message, 0, (label,)).problem
        )
