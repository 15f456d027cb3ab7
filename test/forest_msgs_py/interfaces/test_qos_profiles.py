"""QoS from bags of every age."""

import pytest

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.qos_profiles import Qos, for_replay, offered
from forest_msgs_py.interfaces.topic_qos import STREAM_DEPTH, offered_qos

NEVER = {"sec": 9223372036, "nsec": 854775807}


def test_numbers_and_words_mean_the_same():
    numbers = "- history: 1\n  depth: 5\n  reliability: 2\n  durability: 1\n  liveliness: 1\n"
    words = [
        {"history": "keep_last", "depth": 5, "reliability": "best_effort", "durability": "transient_local"}
    ]
    assert offered(numbers) == offered(words) == [Qos(5, reliable=False, transient_local=True)]


def test_what_our_publishers_offer_is_read_back():
    assert offered([offered_qos(topics.ROBOT_DESCRIPTION)]) == [Qos(1, transient_local=True)]
    assert offered([offered_qos(topics.JOY)]) == [Qos(STREAM_DEPTH)]


@pytest.mark.parametrize("told", ["", "[]", ": not yaml: [", None, 7, "text", "- 3"])
def test_a_bag_that_tells_nothing_gets_the_default(told):
    assert for_replay(offered(told)) == Qos()


def test_an_unknown_history_and_durations_of_zero_are_no_limits():
    foxy = "- {history: 3, depth: 0, reliability: 1, durability: 2, deadline: {sec: 0, nsec: 0}}"
    assert offered(foxy) == [Qos()]
    assert offered([{"deadline": NEVER, "lifespan": {"sec": 10, "nsec": 5}}]) == [
        Qos(lifespan_ns=10_000_000_005)
    ]


def test_one_publisher_stands_for_all_that_were_recorded():
    several = [Qos(1, transient_local=True, lifespan_ns=5), Qos(1, reliable=False, transient_local=True)]
    assert for_replay(several) == Qos(2, reliable=True, transient_local=True)
    assert for_replay([Qos(1, transient_local=True, lifespan_ns=5)] * 2) == Qos(
        2, transient_local=True, lifespan_ns=5
    )
