"""What the valve driver's node takes from topics: each actuator by itself, each only for a while."""

import math

import pytest

pytest.importorskip("rclpy")

from clock_by_hand import HandClock

from forest_control.valve import valve_driver
from forest_control.valve.load_estimate import STILL, UNSEEN, Pressures
from forest_control.valve.valve_driver import REST
from forest_control.valve.valve_driver_topics import Measurements, of_pressures
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state

TIMEOUT = 0.1


@pytest.fixture
def clock():
    return HandClock()


def put_all(clock, names=topics.ACTUATORS):
    clock.put(topics.PRESSURES, float_array(topics.PRESSURES, 0, [6e6] * len(topics.PRESSURES.labels)))
    clock.put(topics.SUPPLY, float_array(topics.SUPPLY, 0, (20e6, 1e-3, 0.2)))
    places = [1.0 + topics.ACTUATORS.index(name) for name in names]
    clock.put(topics.ACTUATOR_STATES, joint_state(names, 0, places))


def test_it_learns_of_the_actuators_that_are_measured(clock):
    measured = Measurements(clock, TIMEOUT, 19e6)
    put_all(clock, topics.ACTUATORS[:1])
    assert measured.read(learning=True) == ""
    swing, *cylinders = measured.motion().positions
    assert swing == 1.0
    assert all(map(math.isnan, cylinders))


def test_a_position_is_kept_until_it_is_too_old(clock):
    measured = Measurements(clock, TIMEOUT, 19e6)
    put_all(clock)
    measured.read(learning=True)
    clock.time = 0.5 * TIMEOUT
    put_all(clock, topics.ACTUATORS[1:])
    measured.read(learning=True)
    assert measured.motion().positions == (1.0, 2.0, 3.0)
    clock.time = 1.2 * TIMEOUT
    swing, *cylinders = measured.motion().positions
    assert math.isnan(swing)
    assert cylinders == [2.0, 3.0]


def test_without_pressures_there_is_nothing_to_learn_from(clock):
    measured = Measurements(clock, TIMEOUT, 19e6)
    put_all(clock)
    measured.read(learning=True)
    clock.time = 1.2 * TIMEOUT
    assert measured.motion() is STILL
    assert measured.pressures() is UNSEEN


def test_the_newest_pressures_tell_how_far_the_machine_is_when_a_command_comes_late(clock):
    measured = Measurements(clock, TIMEOUT, 18e6)
    assert measured.machine_time(1_000_000_000) == 1_000_000_000  # nothing is known
    told = {1_015_000_000: 1_015_000_000, 995_000_000: 1_000_000_000, 2_000_000_000: 1_000_000_000}
    for newest, machine in told.items():  # ahead, behind, by another clock
        clock.put(topics.PRESSURES, float_array(topics.PRESSURES, newest, [6e6] * 12))
        measured.read(learning=False)
        assert measured.machine_time(1_000_000_000) == machine


def test_pressures_that_the_driver_does_not_believe_are_told():
    read, believed = (
        Pressures((1e6,) * 3, (1e6,) * 3, 20e6),
        REST._replace(load=REST.load._replace(primed=True)),
    )
    assert of_pressures("", read, believed) == of_pressures("", UNSEEN, REST) == ""
    assert of_pressures("not finite", UNSEEN, REST) == "not finite; the nominal load is taken"
    told = of_pressures("", read, REST)
    assert told.startswith("a pressure is out of its range, or both ends of a swing's hose differ")
    assert told.endswith("; the nominal load is taken")
    unfed = REST._replace(unfed=valve_driver.UNFED)
    assert of_pressures("", read, unfed).startswith("the supply is under 2 MPa, or half of its idle")


def test_a_supply_of_zero_is_read(clock):
    measured = Measurements(clock, TIMEOUT, 19e6)
    put_all(clock)
    clock.put(topics.SUPPLY, float_array(topics.SUPPLY, 0, (0.0, 0.0, 0.0)))
    assert measured.read(learning=False) == ""
    assert measured.pressures().supply == 0.0
