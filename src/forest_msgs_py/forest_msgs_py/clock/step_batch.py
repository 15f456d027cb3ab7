"""What a node in lockstep published, sent to the recorder: one message for many steps.

A recorder that subscribed to every topic would wake up for each message, some twenty times in a step.
Each time costs more, at either end, than the message. So each node keeps the bytes that it publishes, and
sends them on `lockstep/said`. A lost batch shows in the next one, which does not begin where the one
before it ended.

===============  ===========================================================================================
part             bytes, little-endian
===============  ===========================================================================================
head             step after which the batch begins [4], last step that it covers [4], length of the node's
                 name [4], the name
each message     place of its topic in the announcement [4], step [4], size [4], the message
===============  ===========================================================================================
"""

import struct
from collections.abc import Iterator

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from forest_msgs_py.clock.step_order import BatchMessage
from forest_msgs_py.interfaces.topics import STEP_BATCH, message_class
from forest_msgs_py.runtime.node import raw_publish
from forest_msgs_py.serialization.cdr import ENCAPSULATION

_ARRAY = struct.Struct("<4sIII")  # encapsulation, no dimensions, no offset, size
_HEAD = struct.Struct("<III")
_EACH = struct.Struct("<III")


class StepBatch:
    """Keeps what a node says.

    Args:
        node: that speaks.
        depth: batches that are kept for a recorder that comes late.
    """

    def __init__(self, node: Node, depth: int) -> None:
        profile = QoSProfile(
            depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        self._publisher = node.create_publisher(message_class(STEP_BATCH), STEP_BATCH.name, profile)
        self._publish = raw_publish(self._publisher)
        self._name = node.get_name().encode()
        self._parts: list[bytes] = []
        self._told = 0  # last step of the batch before

    def note(self, place: int, step: int, data: bytes) -> None:
        """Keep a message."""
        self._parts += (_EACH.pack(place, step, len(data)), data)

    def tell(self, step: int) -> None:
        """Tell everything up to a step."""
        head = _HEAD.pack(self._told, step, len(self._name))
        body = b"".join((head, self._name, *self._parts))
        self._parts.clear()
        self._told = step
        self._publish(_ARRAY.pack(ENCAPSULATION, 0, 0, len(body)) + body)


def read_batch(data: bytes) -> tuple[str, int, int, Iterator[BatchMessage]]:
    """A node's name, the step after which and the one until which it tells everything, and what it said."""
    since, step, length = _HEAD.unpack_from(data, _ARRAY.size)
    begin = _ARRAY.size + _HEAD.size
    name = data[begin : begin + length].decode()
    *_, size = _ARRAY.unpack_from(data)
    return name, since, step, _messages(data, begin + length, _ARRAY.size + size)


def _messages(data: bytes, place: int, end: int) -> Iterator[BatchMessage]:
    while place < end:
        topic, step, size = _EACH.unpack_from(data, place)
        place += _EACH.size + size
        yield BatchMessage(topic, step, data[place - size : place])
