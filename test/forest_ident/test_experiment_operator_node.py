"""The scripted operator beside a machine and a driver that the test plays: it ends at zero, all put back."""

import re

import pytest

pytest.importorskip("rclpy")

from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state, read_float_array

C180 = load_machine("c180_hoses")
START = pose_at(start_tip(C180), C180)
BEYOND = (START[0], 1.25, START[2])  # [rad] the boom, near its cylinder's end
ZERO = (0.0, 0.0, 0.0)  # [V]


class Crane:
    """A crane that stands still, with a valve driver of which there are but the parameters."""

    def __init__(self, peer, make_node, start_node, experiment):
        self.peer, self.angles = peer, START
        self.driver = make_node("valve_driver")
        self.driver.declare_parameter("compensate", True)
        peer.executor.add_node(self.driver)
        self.commands = peer.hear(topics.VALVE_COMMANDS)
        told = ("-p", f"experiment:={experiment}", "-p", "timeout:=1.0")
        self.operator = start_node("experiment_operator_node", *told)
        self.timers = [
            peer.repeat(topics.PRESSURES, self.pressures, 200.0),
            peer.repeat(topics.JOINT_STATES, self.joints, 200.0),
        ]
        self.stop = peer.speak(topics.EMERGENCY_STOP)

    def joints(self, now):
        return joint_state(topics.JOINTS, now, self.angles, (0.0, 0.0, 0.0))

    def pressures(self, now):
        return float_array(topics.PRESSURES, now, (5e6,) * 12)

    def compensates(self):
        return self.driver.get_parameter("compensate").value

    def last(self):
        return read_float_array(topics.VALVE_COMMANDS, self.commands[-1], 0).values if self.commands else ()

    def is_driven(self):
        return self.last() not in ((), ZERO)


def silence(crane):
    crane.timers[1].cancel()


def go_beyond(crane):
    crane.angles = BEYOND


def press(crane):
    crane.stop.publish(topics.message_class(topics.EMERGENCY_STOP)(data=True))


@pytest.mark.parametrize(
    ("experiment", "trouble", "sentence"),
    [
        # State and pressures fall silent within milliseconds: either may be missed first.
        ("damping_boom", silence, r"nothing good (of the machine's state|on hydraulics/pressures) for 1 s"),
        ("damping_boom", go_beyond, "the boom stands at 71.6 deg; allowed in this experiment"),
        ("damping_boom", press, "emergency stop pressed"),
        ("valve", go_beyond, "the boom moves: valve or hose are still on the crane"),
    ],
)
def test_in_trouble_it_ends_at_zero_and_the_driver_compensates_again(
    peer, make_node, start_node, experiment, trouble, sentence
):
    crane = Crane(peer, make_node, start_node, experiment)
    peer.until(lambda: crane.is_driven() or crane.operator.poll() is not None)
    assert crane.operator.poll() is None, crane.operator.text()
    assert not crane.compensates()
    trouble(crane)
    peer.until(lambda: crane.operator.poll() is not None)
    assert crane.operator.returncode == 1
    assert re.search(sentence, crane.operator.text().splitlines()[-1])
    assert crane.compensates()
    peer.until(lambda: crane.last() == ZERO)
