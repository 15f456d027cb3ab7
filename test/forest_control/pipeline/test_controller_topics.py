"""What the controller hears: one machine, whichever of its topics another node publishes, too."""

import pytest

pytest.importorskip("rclpy")

from clock_by_hand import HandClock, to_cdr

from forest_control.operator.levers import BUTTON_COUNT
from forest_control.pipeline.controller_topics import ControllerInputs
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import joint_state

MINE, STRANGER = (7, 8, 9), (1, 2, 3)  # numbers that the middleware gives to messages
STATE = to_cdr(joint_state(topics.JOINTS, 1, (0.1, 0.5, -1.0), (0.0, 0.0, 0.0)))


@pytest.fixture
def inputs():
    clock = HandClock()
    clock.lockstep = False
    return ControllerInputs(clock, load_machine("c180_hoses"), BUTTON_COUNT - 1), clock


@pytest.mark.parametrize(
    "topic", [topics.ACTUATOR_STATES, topics.PRESSURES, topics.SUPPLY], ids=lambda t: t.name
)
def test_a_second_machine_on_any_topic_is_named(inputs, topic):
    controller, clock = inputs
    hear = clock.boxes[topic.name].heard
    for number in MINE:
        hear({"publication_sequence_number": number})
    state, problem = controller.machine_state(STATE, 0.0)
    assert (state.readable, problem) == (True, "")
    for number in (STRANGER[0], MINE[-1] + 1, STRANGER[1]):
        hear({"publication_sequence_number": number})
    state, problem = controller.machine_state(STATE, 0.0)
    assert not state.readable
    assert problem == f"{topic.name}: more than one node publishes it; allowed: one machine"
