"""What the controller takes from the valve driver's reports, and when it finds that nobody obeys."""

import math

import pytest

pytest.importorskip("rclpy")

from pace_by_hand import Pace

from forest_control.valve_reach import FULL
from forest_control.valve_reports import (
    DEAF,
    HEARD,
    LEARNT,
    SILENT,
    STATUS_TIMEOUT,
    VOLTAGE_TIMEOUT,
    ValveReports,
)
from forest_description.machine import load_machine
from forest_msgs_py import topics
from forest_msgs_py.messages import float_array

C180 = load_machine("c180")
DEADBAND = C180.valve_of(0).law.forward.deadband_voltage
COMMAND, SHUT = (0.0, 2.0, 0.0), (0.0, 0.0, 0.0)


@pytest.fixture
def pace():
    return Pace()


@pytest.fixture
def reports(pace):
    return ValveReports(pace, C180)


def put_status(pace, **learnt):
    """A status as the driver's; what is not told is as the machine's file says."""
    labels = topics.VALVE_DRIVER_STATUS.labels
    as_filed = {label: DEADBAND if label.endswith("deadband") else 1.0 for label in LEARNT}
    told = {**dict.fromkeys(labels, 0.0), **as_filed, **learnt}
    assert len(told) == len(labels)
    pace.put(topics.VALVE_DRIVER_STATUS, float_array(topics.VALVE_DRIVER_STATUS, 0, list(told.values())))


def put_voltages(pace, volts):
    pace.put(topics.VALVE_VOLTAGES, float_array(topics.VALVE_VOLTAGES, 0, volts))


def objections(pace, reports, seconds, command, volts):
    """What is objected in each of some seconds' steps; no volts: the driver is silent."""
    said = []
    for _ in range(round(seconds / 0.005)):
        pace.time += 0.005
        if volts is not None:
            put_voltages(pace, volts)
        reports.read()
        said.append(reports.objection(command))
    return said


def test_before_anybody_has_spoken_the_valves_are_as_filed_and_shut(reports):
    assert reports.read() == (FULL, SHUT)


def test_what_the_driver_has_learnt_lowers_the_reach_of_that_valve_and_way(pace, reports):
    put_status(pace, stick_backward_gain=0.6, swing_forward_deadband=DEADBAND + 0.5)
    reach, _ = reports.read()
    assert reach.backward == pytest.approx((1.0, 1.0, 0.6))
    assert reach.forward[0] < 1.0
    assert reach.forward[1:] == (1.0, 1.0)


def test_what_was_learnt_is_forgotten_when_the_driver_says_it_no_more(pace, reports):
    put_status(pace, boom_forward_gain=0.5)
    assert reports.read()[0].forward[1] == pytest.approx(0.5)
    pace.time = STATUS_TIMEOUT
    assert reports.read()[0].forward[1] == pytest.approx(0.5)
    pace.time = STATUS_TIMEOUT + 0.01
    assert reports.read()[0] == FULL


def test_voltages_count_for_a_tenth_of_a_second(pace, reports):
    put_voltages(pace, (1.0, -10.0, 3.0))
    assert reports.read()[1] == (1.0, -10.0, 3.0)
    pace.time = VOLTAGE_TIMEOUT
    assert reports.read()[1] == (1.0, -10.0, 3.0)
    pace.time = VOLTAGE_TIMEOUT + 0.01
    assert reports.read()[1] == SHUT


def test_a_bad_report_says_nothing(pace, reports):
    put_status(pace, boom_forward_gain=math.nan)
    put_voltages(pace, (math.inf, 0.0, 0.0))
    assert reports.read() == (FULL, SHUT)
    assert reports.objection(COMMAND) == ""


def test_of_a_driver_that_never_spoke_nothing_is_expected(pace, reports):
    assert set(objections(pace, reports, 1.0, COMMAND, None)) == {""}


def test_a_driver_that_falls_silent_is_missed_after_the_timeout_until_it_speaks(pace, reports):
    objections(pace, reports, 0.5, COMMAND, (0.0, 3.0, 0.0))
    said = objections(pace, reports, 0.5, COMMAND, None)
    assert said.index("valve driver: no voltages") * 0.005 == pytest.approx(SILENT, abs=0.006)
    assert said[-1] == "valve driver: no voltages"
    assert objections(pace, reports, 0.005, SHUT, SHUT) == [""]


def test_a_driver_that_keeps_the_valves_shut_is_found_after_a_while(pace, reports):
    """Its commands do not arrive, or somebody else stops it."""
    objections(pace, reports, 0.5, SHUT, SHUT)
    said = objections(pace, reports, 2.0, COMMAND, SHUT)
    assert said.index("valve driver: keeps the valves shut") * 0.005 == pytest.approx(DEAF, abs=0.006)
    assert objections(pace, reports, 0.5, SHUT, SHUT)[-1] == ""


def test_a_command_that_may_be_noise_need_not_open_a_valve(pace, reports):
    assert set(objections(pace, reports, 2.0, (HEARD, 0.0, -HEARD), SHUT)) == {""}
