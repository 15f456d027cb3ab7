"""Many messages of one topic as CDR bytes at once, for writers that know their samples beforehand; and back.

A topic's messages differ in nothing but their stamp and their numbers, which stand at the same places in
each: those of a `Packer`'s template. So all are copies of it with the numbers put there.

============  ==============================================================================================
symbol        meaning
============  ==============================================================================================
stamps_ns     ROS time, int64 [N]
values        float64 [N, k], k numbers per message in the order of `topics.columns`
============  ==============================================================================================

Kept beside rosbags' typestore, whose bytes are the same: 0.7 µs a message instead of 14 µs
(`benchmarks/serialization.py`).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from forest_msgs_py.interfaces.stamps import MOST_STAMP
from forest_msgs_py.interfaces.topics import FLOAT_ARRAY, Topic
from forest_msgs_py.serialization.packing import DOUBLE, Packer
from forest_msgs_py.types import NS_PER_S


class Encoder:
    """Encodes and decodes the messages of one topic.

    Args:
        topic: row of the topic table.
        frame: frame of poses and twists.
    """

    def __init__(self, topic: Topic, frame: str = "") -> None:
        self._packer = Packer(topic, frame)
        template = self._packer.whole
        assert template is not None  # nothing is missing in it
        self._template = np.frombuffer(template.data, dtype=np.uint8)
        self._runs, self._stamp_place = template.runs, template.stamp_place
        self._stamp_kind = np.dtype("<f8,<f8" if topic.type == FLOAT_ARRAY else "<i4,<u4")

    def encode(self, stamps_ns: NDArray[np.int64], values: NDArray[np.float64]) -> list[bytes | None]:
        """Messages with these stamps [N] and numbers [N, k], in SI units, volts at the valves.

        A row with NaN in it, a sensor without a sample, becomes a message without that sensor; None if
        nothing is left.
        """
        buffer = np.tile(self._template, (len(stamps_ns), 1))
        stamps = np.empty(len(stamps_ns), self._stamp_kind)
        stamps["f0"], stamps["f1"] = np.divmod(stamps_ns, NS_PER_S)
        _put(buffer, self._stamp_place, stamps)
        for run in self._runs:
            _put(buffer, run.place, values[:, run.first : run.end].astype("<f8"))
        encoded: list[bytes | None] = [row.tobytes() for row in buffer]
        for row in np.flatnonzero(np.isnan(values).any(axis=1)).tolist():
            encoded[row] = self._packer.pack(int(stamps_ns[row]), values[row].tolist())
        return encoded

    def decode(self, messages: Sequence[bytes]) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
        """Stamps [N] and numbers [N, k] of messages that differ from the first only where numbers stand.

        None if one of them differs elsewhere, in its labels or its frame, say, or has no stamp.
        """
        size = len(self._template)
        if not messages or any(len(message) != size for message in messages):
            return None
        buffer = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(-1, size)
        spans = [(run.place, DOUBLE * (run.end - run.first)) for run in self._runs]
        fixed = np.ones(size, dtype=bool)
        for place, length in (*spans, (self._stamp_place, self._stamp_kind.itemsize)):
            fixed[place : place + length] = False
        if (buffer[:, fixed] != self._template[fixed]).any():
            return None
        stamp = _get(buffer, self._stamp_place, self._stamp_kind.itemsize).view(self._stamp_kind)[:, 0]
        sec, nanosec = stamp["f0"], stamp["f1"]
        if not ((np.abs(sec) < MOST_STAMP) & (np.abs(nanosec) < MOST_STAMP)).all():
            return None
        stamps = sec.astype(np.int64) * NS_PER_S + nanosec.astype(np.int64)
        return stamps, np.hstack([_get(buffer, *span).view("<f8") for span in spans])


def _get(buffer: NDArray[np.uint8], place: int, size: int) -> NDArray[Any]:
    """Take some bytes out of each row."""
    return np.ascontiguousarray(buffer[:, place : place + size])


def _put(buffer: NDArray[np.uint8], place: int, numbers: NDArray[Any]) -> None:
    """Put the numbers of a row into each row."""
    data = numbers.view(np.uint8).reshape(len(numbers), -1)
    buffer[:, place : place + data.shape[1]] = data
