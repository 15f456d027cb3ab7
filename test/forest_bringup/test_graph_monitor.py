"""Claims about the graph monitor, on a real ROS graph: whom it counts, what others publish, what it says."""

import os

import pytest

pytest.importorskip("rclpy")


from rclpy.exceptions import InvalidHandle

from forest_bringup.graph_lock import GraphError
from forest_bringup.graph_monitor import GraphMonitor
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import publisher


@pytest.fixture
def guard_in(domain_id):
    """Makes guards in the test's domain, which leave with the test."""
    made = []

    def make(namespace="/", may_publish=True):
        made.append(GraphMonitor(namespace, may_publish))
        return made[-1]

    yield make
    for guard in made:
        guard.close()


def test_nodes_are_counted_by_name_in_the_guards_own_namespace(guard_in, make_node, wait_until):
    guard = guard_in("/crane")
    for name, namespace in (("simulator", "/crane"), ("simulator", "/crane"), ("controller", "/crane")):
        make_node(name, namespace=namespace, start_parameter_services=False)
    make_node("simulator", namespace="/other", start_parameter_services=False)
    make_node("last", namespace="/crane", start_parameter_services=False)
    wait_until(lambda: guard.count("last") == 1)
    assert (guard.count("simulator"), guard.count("controller"), guard.count("simul")) == (2, 1, 0)


@pytest.mark.parametrize(("topic", "ours"), [(topics.VALVE_COMMANDS, 1), (topics.VALVE_VOLTAGES, 1)])
def test_one_more_than_our_own_is_a_rival(guard_in, make_node, wait_until, topic, ours):
    guard, node = guard_in(), make_node("driver", start_parameter_services=False)
    others = [publisher(node, topic) for _ in range(ours)]
    expected = ours + (topic is topics.VALVE_VOLTAGES)
    wait_until(lambda: guard._node.count_publishers(topic.name) == expected)
    assert guard.other_publisher() == ""
    others.append(publisher(node, topic))
    wait_until(guard.other_publisher)
    assert guard.other_publisher() == topic.name


def test_in_shadow_another_driver_is_no_rival_but_another_controller_is(guard_in, make_node, wait_until):
    guard, node = guard_in(may_publish=False), make_node("driver", start_parameter_services=False)
    drivers = [publisher(node, topics.VALVE_VOLTAGES) for _ in range(3)]
    wait_until(lambda: guard._node.count_publishers(topics.VALVE_VOLTAGES.name) == len(drivers))
    assert guard.other_publisher() == ""
    controllers = [publisher(node, topics.VALVE_COMMANDS) for _ in range(2)]
    wait_until(guard.other_publisher)
    assert guard.other_publisher() == topics.VALVE_COMMANDS.name
    assert controllers


def test_the_guard_says_zero_for_every_joint_with_a_stamp_in_its_namespace(guard_in, peer):
    guard = guard_in("/crane")
    heard = peer.hear(topics.VALVE_VOLTAGES, "/crane/valve_voltages")
    before = peer.node.get_clock().now().nanoseconds
    peer.until(lambda: guard.publish_zero() or heard)
    sec, nanosec, *volts = heard[0].data
    assert volts == [0.0, 0.0, 0.0]
    assert before <= sec * 1e9 + nanosec <= peer.node.get_clock().now().nanoseconds


def test_in_shadow_nothing_is_said(guard_in, make_node, wait_until):
    guard, seen = guard_in(may_publish=False), make_node("seen", start_parameter_services=False)
    guard.publish_zero()
    wait_until(lambda: guard.count("seen") == 1)
    assert seen.count_publishers("/valve_voltages") == 0


def test_a_guard_that_has_left_is_seen_no_more_and_may_leave_again(guard_in, make_node, wait_until):
    guard, seen = guard_in(), make_node("seen", start_parameter_services=False)
    wait_until(lambda: seen.count_publishers("/valve_voltages") == 1)
    guard.close()
    wait_until(lambda: seen.count_publishers("/valve_voltages") == 0)
    wait_until(lambda: [name for name in seen.get_node_names() if "supervisor" in name] == [])
    guard.close()


def test_a_guard_that_has_left_says_nothing_and_nothing_of_it_is_left(guard_in):
    guard = guard_in()
    node, context = guard._node, guard._context
    guard.close()
    guard.publish_zero()
    assert not context.ok()
    with pytest.raises(InvalidHandle), node.handle:
        pass


def test_a_guard_offers_no_service_that_nobody_answers_and_keeps_no_log(guard_in):
    node = guard_in()._node
    me = node.get_name(), node.get_namespace()
    services = {name.rpartition("/")[2] for name, _ in node.get_service_names_and_types_by_node(*me)}
    assert not services & {"list_parameters", "get_parameters", "set_parameters"}
    names = {name for name, _ in node.get_publisher_names_and_types_by_node(*me)}
    assert "/rosout" not in names
    assert "/valve_voltages" in names


def test_a_guard_stays_on_this_machine(guard_in, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    guard_in()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_what_ros_refuses_is_one_sentence_and_nothing_is_left(domain_id, monkeypatch):
    left = []
    monkeypatch.setattr(
        GraphMonitor, "close", lambda self, close=GraphMonitor.close: left.append(close(self))
    )
    with pytest.raises(GraphError, match=r"^ROS does not start: ") as refused:
        GraphMonitor("/1crane", may_publish=True)
    assert "\n" not in str(refused.value)
    assert left == [None]
