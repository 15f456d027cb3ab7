"""A batch gives back what a node said, and is a message that any subscriber can read."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from rclpy.serialization import deserialize_message

from forest_msgs_py.clock.step_batch import StepBatch, read_batch
from forest_msgs_py.clock.step_order import BatchMessage
from forest_msgs_py.interfaces import topics


def told():
    """The batches of a node that publishes in steps 7 and 9, and nothing after."""
    sent = []
    publisher = SimpleNamespace(handle=SimpleNamespace(publish_raw=sent.append))
    node = SimpleNamespace(create_publisher=lambda *_: publisher, get_name=lambda: "controller")
    batch = StepBatch(node, depth=1)
    batch.note(0, 7, b"seven")
    batch.note(3, 9, b"")
    batch.note(0, 9, b"nine")
    batch.tell(9)
    batch.tell(10)
    return sent


def test_an_account_tells_all_that_was_said_once():
    first, second = map(read_batch, told())
    assert first[:3] == ("controller", 0, 9)
    assert list(first[3]) == [
        BatchMessage(0, 7, b"seven"),
        BatchMessage(3, 9, b""),
        BatchMessage(0, 9, b"nine"),
    ]
    assert second[:3] == ("controller", 9, 10)
    assert list(second[3]) == []


def test_an_account_is_a_message_of_its_type():
    (data, _) = told()
    message = deserialize_message(data, topics.message_class(topics.STEP_BATCH))
    assert bytes(message.data).endswith(b"nine")
    assert len(message.layout.dim) == 0
