"""Claims about log times by /clock."""

import pytest

pytest.importorskip("rclpy")

from rosgraph_msgs.msg import Clock

from forest_bag.record.sim_time import SimTime
from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.introspection.graph_listener import ReceivedMessage
from forest_msgs_py.serialization.cdr import to_cdr


def heard(name, received, data=b""):
    return ReceivedMessage(received, name, data, received - 1, 0, 0)


def tick(received, time):
    return heard("/clock", received, to_cdr(Clock(clock=ns_to_stamp(time))))


@pytest.mark.parametrize("keeps_clock", [True, False])
def test_each_message_gets_the_last_time_on_clock_before_it(keeps_clock):
    times = SimTime(keeps_clock)
    times.keep("/map")
    assert times.stamped([heard("/a", 10), heard("/map", 11)]) == []
    first = times.stamped([heard("/a", 12), tick(13, 700), heard("/a", 14), heard("/b", 15), tick(16, 800)])
    second = times.stamped([heard("/a", 17)])
    told = [(m.name, m.received_ns, m.sent_ns) for m in first + second if m.name != "/clock"]
    assert told == [("/map", 700, 10), ("/a", 700, 13), ("/b", 700, 14), ("/a", 800, 16)]
    clock = [m.received_ns for m in first if m.name == "/clock"]
    assert clock == ([700, 800] if keeps_clock else [])
