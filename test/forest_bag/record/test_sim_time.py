"""Claims about log times by /clock."""

import pytest

pytest.importorskip("rclpy")

from rosgraph_msgs.msg import Clock

from forest_bag.record.sim_time import SimTimeListener
from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import ROBOT_DESCRIPTION
from forest_msgs_py.introspection.graph_listener import DiscoveredTopic, ReceivedMessage
from forest_msgs_py.serialization.cdr import to_cdr


def heard(name, received, data=b""):
    return ReceivedMessage(received, name, data, received - 1, 0, 0)


def tick(received, time):
    return heard("/clock", received, to_cdr(Clock(clock=ns_to_stamp(time))))


class Hearing:
    """Stands for what hears the graph; gives what the test puts in."""

    pause = 0.01

    def __init__(self):
        self.waiting = []

    def made(self, wanted, offered):
        self.wanted, self.offered = wanted, offered
        return self

    def look(self):
        pass

    def context_ns(self):
        return 5

    def take(self):
        taken, self.waiting = self.waiting, []
        return taken


@pytest.mark.parametrize("keeps_clock", [True, False])
def test_each_message_gets_the_last_time_on_clock_before_it(keeps_clock):
    hearing, offers = Hearing(), []

    def wanted(name, _types):
        return keeps_clock or name != "/clock"

    listener = SimTimeListener(hearing.made, wanted, offers.append)
    assert hearing.wanted("/clock", ())  # it is heard in any case
    described = [offered_qos(ROBOT_DESCRIPTION)]
    topics = [
        DiscoveredTopic("/clock", "", [], ""),
        DiscoveredTopic("/map", "", described, ""),
    ]
    for topic in topics:
        hearing.offered(topic)
    assert offers == topics[not keeps_clock :]
    hearing.waiting = [heard("/a", 10), heard("/map", 11)]
    assert listener.take() == []
    hearing.waiting = [heard("/a", 12), tick(13, 700), heard("/a", 14), heard("/b", 15), tick(16, 800)]
    first = listener.take()
    hearing.waiting = [heard("/a", 17)]
    second = listener.take()
    told = [(m.name, m.received_ns, m.sent_ns) for m in first + second if m.name != "/clock"]
    assert told == [("/map", 700, 10), ("/a", 700, 13), ("/b", 700, 14), ("/a", 800, 16)]
    clock = [m.received_ns for m in first if m.name == "/clock"]
    assert clock == ([700, 800] if keeps_clock else [])
    assert (listener.pause, listener.context_ns()) == (0.01, 5)
