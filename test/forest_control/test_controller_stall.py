"""The controller's process stalls: the state of the machine that ends the stall comes before the watchdog."""

import pytest

rclpy = pytest.importorskip("rclpy")

from clock_by_hand import HandClock

from forest_control import compiled, controller_node
from forest_control.operator.levers import BUTTON_COUNT, LEFT_SHOULDER, Levers, axes_from_levers
from forest_control.pipeline import controller, controller_topics
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import joint_state, ns_to_stamp
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.types import NS_PER_S, PERIOD

START = pose_at(start_tip(load_machine("c180_hoses")), load_machine("c180_hoses"))
STALL = 0.3  # [s] beyond the state's timeout


class Publisher:
    """Remembers what is published."""

    def __init__(self):
        self.said = []

    def publish(self, *said):
        self.said.append(said)

    def get_subscription_count(self):
        return 1


class NodeClock(HandClock):
    """A node's clock by hand; subscriptions that call back are called by the test."""

    lockstep, run = False, None

    def __init__(self):
        super().__init__()
        self.time, self.publishers = 100.0, {}

    def stamp(self):
        return round(self.time * NS_PER_S)

    def publisher(self, topic):
        return self.publishers.setdefault(topic.name, Publisher())

    def on(self, topic, _call):
        return self.polled_subscription(topic)

    def every(self, _period, _call):
        pass


class Joystick:
    """Waiting samples of a joystick."""

    def __init__(self):
        self.waiting = []

    def arrivals(self):
        taken, self.waiting = self.waiting, []
        return taken


class Stalling:
    """A controller's node that drives the crane, its time and its inputs in the test's hands."""

    def __init__(self, monkeypatch):
        self.clock, self.joystick, self.count = NodeClock(), Joystick(), 0
        monkeypatch.setattr(controller_node, "node_clock", lambda _node: self.clock)
        monkeypatch.setattr(
            controller_topics, "number_publisher", lambda clock, topic, *_, **__: clock.publisher(topic)
        )
        monkeypatch.setattr(compiled, "controller_step", lambda: controller.step_with_telemetry)
        monkeypatch.setattr(controller_topics, "InputStatus", lambda *_: Quiet())
        self.node = controller_node.ControllerNode()
        self.node._inputs.joy = self.joystick

    def joy(self, levers):
        self.count += 1
        kind = topics.message_class(topics.JOY)
        message = kind(axes=axes_from_levers(levers), buttons=[0] * BUTTON_COUNT)
        message.buttons[LEFT_SHOULDER] = 1
        message.header.stamp = ns_to_stamp(self.clock.stamp())
        message.header.frame_id = f"heartbeat:{self.count}"
        self.joystick.waiting.append((to_cdr(message), self.clock.time))

    def state(self, stamp):
        message = joint_state(topics.JOINTS, stamp, START, ZERO, ZERO)
        self.node._on_joint_states(to_cdr(message), self.clock.time)

    def drive(self, periods):
        for k in range(periods):
            self.clock.time += PERIOD
            self.joy(Levers(0.0, 0.6, 0.0) if k > 5 else Levers(0.0, 0.0, 0.0))
            self.state(self.clock.stamp())

    @property
    def commands(self):
        return [values for _, values in self.clock.publisher(topics.VALVE_COMMANDS).said]

    def complaints(self):
        said = self.clock.publisher(topics.DIAGNOSTICS).said
        return [status.message for (message,) in said for status in message.status]


class Quiet:
    """The status of an input that nobody asks for."""

    def __getattr__(self, _name):
        return lambda *_: ""


@pytest.fixture
def stalling(monkeypatch, domain_id):
    rclpy.init(domain_id=domain_id)
    made = Stalling(monkeypatch)
    yield made
    made.node.destroy_node()
    rclpy.shutdown()


@pytest.mark.parametrize("since_last", [1_000, -1_000_000, 0], ids=["too soon", "of the past", "again"])
def test_a_state_that_ends_a_stall_and_counts_for_nothing_is_answered_by_zero_and_the_cause(
    stalling, since_last
):
    stalling.drive(20)
    last = stalling.clock.stamp()
    assert any(stalling.commands[-1])
    said = len(stalling.commands)
    stalling.clock.time += STALL
    stalling.state(last + since_last)
    assert stalling.commands[said:] == [ZERO]
    assert any("no state of the machine" in complaint for complaint in stalling.complaints())
    assert not stalling.node._guard.permission.joystick.armed


def test_a_stop_publishes_zero_whatever_the_controller_commands_meanwhile(stalling):
    stalling.drive(20)
    stalling.node._controller.stop = lambda: None  # in lockstep the loop may command between stop and zero
    stalling.node._stand_still()
    assert stalling.commands[-1] == ZERO
