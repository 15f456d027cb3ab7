"""An account gives back what a node said, and is a message that any subscriber can read."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from rclpy.serialization import deserialize_message

from forest_msgs_py.clock.step_batch import Account, read_account
from forest_msgs_py.clock.step_order import Said
from forest_msgs_py.interfaces import topics


def told():
    """The accounts of a node that speaks in steps 7 and 9, and is silent after."""
    sent = []
    publisher = SimpleNamespace(handle=SimpleNamespace(publish_raw=sent.append))
    node = SimpleNamespace(create_publisher=lambda *_: publisher, get_name=lambda: "controller")
    account = Account(node, depth=1)
    account.note(0, 7, b"seven")
    account.note(3, 9, b"")
    account.note(0, 9, b"nine")
    account.tell(9)
    account.tell(10)
    return sent


def test_an_account_tells_all_that_was_said_once():
    first, second = map(read_account, told())
    assert first[:3] == ("controller", 0, 9)
    assert list(first[3]) == [Said(0, 7, b"seven"), Said(3, 9, b""), Said(0, 9, b"nine")]
    assert second[:3] == ("controller", 9, 10)
    assert list(second[3]) == []


def test_an_account_is_a_message_of_its_type():
    (data, _) = told()
    message = deserialize_message(data, topics.message_class(topics.SAID))
    assert bytes(message.data).endswith(b"nine")
    assert len(message.layout.dim) == 0
