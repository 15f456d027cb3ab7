"""Claims about the emergency stop: anybody stops, only a reset on purpose ends it, no restart forgets."""

import time

import pytest

pytest.importorskip("rclpy")

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import EMERGENCY_STOP, EMERGENCY_STOPPED, message_class
from forest_msgs_py.safety import emergency_stop
from forest_msgs_py.safety.emergency_stop import EmergencyStop

LIVE = 2  # subscriptions of a node by which it hears a command live: reliable, and best-effort


class Stoppable:
    """A node with an emergency stop."""

    def __init__(self, peer, name, prefix=""):
        self.node = Node(name, context=peer.node.context, enable_rosout=False, start_parameter_services=False)
        peer.executor.add_node(self.node)
        self.objection, self.acted, self.refused, self.peer = "", 0, 0, peer
        self.stop = EmergencyStop(self.node, prefix, self.object, self.act)

    def object(self):
        self.refused += bool(self.objection)
        return self.objection

    def act(self):
        self.acted += 1

    def vanish(self):
        if self.node is None:
            return
        self.peer.executor.remove_node(self.node)
        self.node.destroy_node()
        self.node = None


@pytest.fixture
def start(peer):
    """Starts nodes, and ends them: what one has latched would reach the next test."""
    started = []

    def make(name, prefix=""):
        started.append(Stoppable(peer, name, prefix))
        return started[-1]

    yield make
    for node in started:
        node.vanish()


@pytest.fixture
def controller(start):
    return start("controller")


@pytest.fixture
def driver(start):
    return start("valve_driver", "~/")


def call(peer, name):
    client = peer.node.create_client(Trigger, name)
    peer.until(client.service_is_ready)
    future = client.call_async(Trigger.Request())
    peer.until(future.done)
    return future.result()


def say(sender, pressed):
    sender.publish(message_class(EMERGENCY_STOP)(data=pressed))


@pytest.mark.parametrize("latched", [True, False], ids=["latched", "typed by hand"])
def test_a_true_from_anybody_stops_every_node_at_once(peer, controller, driver, latched, monkeypatch):
    monkeypatch.setattr(emergency_stop, "AGAIN", 0.0)
    kind = message_class(EMERGENCY_STOP)
    if latched:
        sender = peer.node.create_publisher(kind, EMERGENCY_STOP.name, qos(EMERGENCY_STOPPED))
    else:
        sender = peer.node.create_publisher(kind, EMERGENCY_STOP.name, QoSProfile(depth=1))
    peer.until(lambda: sender.get_subscription_count() >= 2 * (3 if latched else LIVE))
    say(sender, True)
    peer.until(lambda: controller.stop.pressed and driver.stop.pressed)
    assert (controller.acted, driver.acted) == (1, 1)
    controller.objection = "the deadman is held"
    say(sender, False)
    peer.until(lambda: controller.refused and driver.stop.pressed)
    assert controller.stop.pressed
    controller.objection = ""
    peer.until(lambda: say(sender, False) or not (controller.stop.pressed or driver.stop.pressed))


def test_who_says_false_again_and_again_resets_nothing_and_a_reset_on_purpose_does(peer, controller, driver):
    """A panel that tells its state ten times a second would undo a stop that somebody else pressed."""
    panel = peer.speak(EMERGENCY_STOP)
    peer.until(lambda: panel.get_subscription_count() == 2 * LIVE)

    def heard(count):
        say(panel, False)
        return min(len(controller.stop._heard), len(driver.stop._heard)) >= count

    peer.until(lambda: heard(3))
    assert call(peer, "/valve_driver/emergency_stop").success
    peer.until(lambda: controller.stop.pressed)
    peer.until(lambda: heard(20))
    assert controller.stop.pressed
    assert driver.stop.pressed
    assert call(peer, "/reset_emergency_stop").success
    peer.until(lambda: not driver.stop.pressed)
    assert not controller.stop.pressed


def test_either_nodes_service_stops_both_and_a_reset_is_refused_with_its_reason(peer, controller, driver):
    assert call(peer, "/valve_driver/emergency_stop").success
    peer.until(lambda: controller.stop.pressed)
    controller.objection = "the deadman is held"
    answer = call(peer, "/reset_emergency_stop")
    assert (answer.success, answer.message) == (False, "refused: the deadman is held")
    assert controller.stop.pressed
    assert driver.stop.pressed
    controller.objection = ""
    assert call(peer, "/reset_emergency_stop").success
    peer.until(lambda: not controller.stop.pressed and not driver.stop.pressed)
    assert call(peer, "/emergency_stop").success
    peer.until(lambda: driver.stop.pressed)


def test_a_node_that_starts_later_hears_of_the_stop_from_the_one_that_stayed(peer, start, controller, driver):
    assert call(peer, "/emergency_stop").success
    peer.until(lambda: driver.stop.pressed)
    controller.vanish()
    again = start("controller")
    peer.until(lambda: again.stop.pressed)
    driver.vanish()
    other = start("valve_driver", "~/")
    peer.until(lambda: other.stop.pressed)


def test_a_stop_that_a_panel_latched_before_any_node_started_stops_it(peer, start):
    kind = message_class(EMERGENCY_STOP)
    panel = peer.node.create_publisher(kind, EMERGENCY_STOP.name, qos(EMERGENCY_STOPPED))
    say(panel, True)
    late = start("controller")
    peer.until(lambda: late.stop.pressed)
    peer.until(lambda: panel.get_subscription_count() == LIVE + 1)
    say(panel, False)
    peer.until(lambda: not late.stop.pressed)


def test_a_node_that_starts_after_the_reset_is_not_stopped(peer, start, controller):
    assert call(peer, "/emergency_stop").success
    assert call(peer, "/reset_emergency_stop").success
    late = start("valve_driver", "~/")
    heard = peer.hear(EMERGENCY_STOPPED)  # latched: comes late, as it does to the node
    peer.until(lambda: late.stop._state.get_subscription_count() >= 3)
    peer.until(lambda: heard)
    assert not heard[-1].data
    assert not late.stop.pressed


def test_a_false_from_before_the_stop_does_not_reset_it(peer, controller):
    before = {"source_timestamp": 1}
    controller.stop.press()
    controller.stop._on_command(message_class(EMERGENCY_STOP)(data=False), before)
    assert controller.stop.pressed


def test_a_stop_that_is_said_best_effort_is_obeyed_once(peer, controller):
    lossy = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    panel = peer.node.create_publisher(message_class(EMERGENCY_STOP), EMERGENCY_STOP.name, lossy)
    peer.until(lambda: panel.get_subscription_count() == 1)
    peer.until(lambda: say(panel, True) or controller.stop.pressed)
    assert controller.acted == 1


def test_a_command_that_comes_by_two_subscriptions_counts_once(peer, controller):
    """Else the later copy of a true would undo the reset that followed it."""
    stamped = {"source_timestamp": 2**62}
    controller.stop._on_command(message_class(EMERGENCY_STOP)(data=True), stamped)
    controller.stop.reset()
    controller.stop._on_command(message_class(EMERGENCY_STOP)(data=True), stamped)
    assert not controller.stop.pressed


def test_a_panel_that_joins_before_any_stop_hears_from_each_node_that_it_is_not_stopped(
    peer, controller, driver
):
    latched = QoSProfile(depth=10, durability=qos(EMERGENCY_STOPPED).durability)
    kind, joined = message_class(EMERGENCY_STOPPED), []
    peer.node.create_subscription(kind, EMERGENCY_STOPPED.name, joined.append, latched)
    peer.until(lambda: len(joined) == 2)
    assert not any(message.data for message in joined)


def test_a_node_that_starts_resets_nobody_and_is_stopped_itself(peer, start, controller):
    assert call(peer, "/emergency_stop").success
    late = start("valve_driver", "~/")
    peer.until(lambda: late.stop.pressed)
    peer.until(lambda: late.stop._state.get_subscription_count() == 2)
    again = start("valve_driver", "~/")  # its first word reaches the controller live, newer than the stop
    peer.until(lambda: again.stop.pressed)
    assert controller.stop.pressed
    assert controller.acted == 1


def test_whoever_publishes_the_state_so_that_it_is_not_heard_is_named(peer, controller):
    peer.node.create_publisher(message_class(EMERGENCY_STOPPED), EMERGENCY_STOPPED.name, QoSProfile(depth=1))
    peer.until(controller.stop.unheard)
    assert controller.stop.unheard().startswith("/emergency_stopped of /peer is not heard: ")


def test_a_reset_that_follows_at_once_is_no_older_than_a_nodes_own_word_that_it_is_stopped(peer, controller):
    controller.stop.press()
    said = time.time_ns()
    asked = {"source_timestamp": time.time_ns()}
    controller.stop._on_state(message_class(EMERGENCY_STOPPED)(data=True), {"source_timestamp": said})
    controller.stop._on_command(message_class(EMERGENCY_STOP)(data=False), asked)
    assert not controller.stop.pressed


def test_a_reset_by_service_is_said_to_all_and_a_refused_one_is_not(peer, controller):
    heard = peer.hear(EMERGENCY_STOP)

    def reset():
        return call(peer, "/emergency_stop").success and call(peer, "/reset_emergency_stop").success

    peer.until(lambda: reset() and heard)
    before = len(heard)
    controller.objection = "the deadman is held"
    assert not reset()
    controller.objection = ""
    assert reset()
    peer.until(lambda: len(heard) > before)
    assert [message.data for message in heard[before:]] == [False]
