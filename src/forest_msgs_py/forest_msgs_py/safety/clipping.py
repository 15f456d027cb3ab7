"""Voltages beyond a valve's rating: a node clips them, and /diagnostics tells which, and how often."""

from collections.abc import Sequence
from typing import Any

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import Topic


class Clipping:
    """What is clipped of a topic's values.

    Args:
        topic: of three voltages.
        ratings: of the axes [V].
    """

    def __init__(self, topic: Topic, ratings: Sequence[float]) -> None:
        self._topic, self._ratings, self._count = topic, ratings, 0

    def caution(self, values: Sequence[float]) -> str:
        """Return which value [V] is beyond its rating, and so is clipped; "" for none."""
        for label, value, rating in zip(self._topic.labels, values, self._ratings, strict=True):
            if abs(value) > rating:
                self._count += 1
                return f"{self._topic.name}: {label} is {value:g} V, clipped to its rating of {rating:g} V"
        return ""

    def values(self) -> dict[str, Any]:
        """Return ratings [V] and count by their names on /diagnostics."""
        ratings = zip(topics.JOINTS, self._ratings, strict=True)
        return {f"{axis} rating [V]": rating for axis, rating in ratings} | {
            "clipped since start": self._count
        }
