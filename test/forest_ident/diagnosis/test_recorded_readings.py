"""A bag gives the monitor at each state what it would have had live."""

import math
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_bag.read.timeseries import Series, bag_of
from forest_description.types import AXES
from forest_ident.diagnosis import recorded_readings
from forest_ident.measurements.session import SessionError
from forest_msgs_py.interfaces import topics

START = 10**9  # [ns]
PERIOD = 0.005  # [s]
SUPPLY_LABELS = ("pressure", "flow", "saturation")


def series(times, rows, labels):
    stamps = np.array([START + round(1e9 * t) for t in times], dtype=np.int64)
    return Series(stamps, stamps, np.asarray(rows, dtype=np.float64), labels, ("1",) * len(labels), 0)


def states(times):
    rows = [(0.1, 0.4, -1.4, 0.0, 0.0, 0.0)] * len(times)
    kinds = [f"{axis}.{what}" for what in ("position", "velocity") for axis in AXES]
    return topics.JOINT_STATES, series(times, rows, tuple(kinds))


def voltages(times, boom):
    return topics.VALVE_VOLTAGES, series(times, [(0.0, volts, 0.0) for volts in boom], AXES)


@pytest.fixture
def read(monkeypatch):
    """The samples of a bag made of topics and their series."""

    def samples(*parts):
        monkeypatch.setattr(recorded_readings, "read_bag", lambda _: bag_of(dict(parts)))
        return list(recorded_readings.samples(Path("bag")))

    return samples


def steps(count):
    return [PERIOD * k for k in range(count)]


def test_a_topic_that_begins_later_than_the_states_is_not_there_until_then_and_goes_when_it_is_old(read):
    supply = topics.SUPPLY, series([0.02, 0.025], [(1e7, 0.0, 0.0), (2e7, 0.0, 0.0)], SUPPLY_LABELS)
    found = [one.readings.supply for one in read(states(steps(40)), voltages([0.0], [0.0]), supply)]
    expected = [math.nan] * 4 + [1e7] + [2e7] * 21 + [math.nan] * 14  # 0.1 s after 0.025 s it is lost
    assert found == pytest.approx(expected, nan_ok=True)


def test_what_the_driver_has_learnt_comes_seldom_and_lasts_half_a_second(read):
    status = topics.VALVE_DRIVER_STATUS, series([0.01], [[1.2]], ("boom_forward_deadband",))
    found = read(states(steps(110)), voltages([0.0], [0.0]), status)
    known = [k for k, one in enumerate(found) if one.readings.valves[1].forward.deadband == 1.2]
    assert known == list(range(2, 103))
    assert all(math.isnan(one.readings.valves[1].forward.gain) for one in found)  # a label that is not there


def test_a_voltage_acts_from_the_next_state_on_and_a_silent_driver_opens_nothing(read):
    found = read(states(steps(30)), voltages([0.01], [4.0]))
    assert [one.readings.voltages[1] for one in found] == [0.0] * 3 + [4.0] * 20 + [0.0] * 7


def test_only_stamps_that_rise_are_states_and_a_gap_is_no_longer_than_a_tenth_of_a_second(read):
    found = read(states([0.0, 0.005, 0.005, 0.002, 0.004, 0.01, 0.51]), voltages([0.0], [0.0]))
    assert [one.time for one in found] == pytest.approx([0.0, 0.005, 0.01, 0.51])
    assert [one.dt for one in found] == pytest.approx([0.1, 0.005, 0.005, 0.1])


@pytest.mark.parametrize("there", [states(steps(3)), voltages([0.0], [0.0])], ids=["states", "voltages"])
def test_without_angles_or_voltages_there_is_nothing_to_watch(read, there):
    with pytest.raises(SessionError, match=r"bag: no topic .*; the monitor needs angles and voltages"):
        read(there)
