"""Claims about a valve driver whose voltages come late: it knows, and does not throw the valves open."""

import math

import pytest

from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.load_estimate import STILL, UNSEEN
from forest_control.valve.valve_driver import REST
from forest_control.valve.valve_driver_parameters import Settings
from forest_description.machine import load_machine

PERIOD = 0.005
P = valve_driver_parameters.parameters(load_machine("c180_hoses"), Settings())
LAG = P.axes[0].spool.lag
EDGE = P.axes[0].valve.forward.deadband_voltage
MORE, BACK = (0.3, 0.0, 0.0), (-0.3, 0.0, 0.0)


def spool(before, volts, seconds):
    """Where the machine's spool is."""
    return volts + math.exp(-seconds / LAG) * (before - volts)


def turned(held):
    """State, voltage and the machine's spool [V] as a valve turns, the voltage before held for some [s]."""
    state, volts, place = REST, (0.0, 0.0, 0.0), 0.0
    for _ in range(100):
        state, volts = valve_driver.step(state, MORE, UNSEEN, STILL, P, PERIOD)
        place = spool(place, volts[0], PERIOD)
    place = spool(place, volts[0], held - PERIOD)
    return *valve_driver.step(state, BACK, UNSEEN, STILL, P, held), place


def test_the_driver_knows_where_a_voltage_that_was_in_force_for_long_has_brought_the_spool():
    state, volts, place = turned(PERIOD)
    place = spool(place, volts[0], 4.0 * PERIOD)
    state, _ = valve_driver.step(state, BACK, UNSEEN, STILL, P, 4.0 * PERIOD)
    assert place < -3.0 * EDGE  # across the overlap in one period, and far beyond it in four
    assert state.spools[0] == pytest.approx(place, abs=1e-9)


def test_a_turn_in_time_crosses_the_overlap_in_one_period():
    state, volts, place = turned(PERIOD)
    assert volts[0] < -3.0 * EDGE
    assert spool(place, volts[0], PERIOD) == pytest.approx(-place, rel=0.01)  # the swing's valve is symmetric
    assert state.ahead == PERIOD


@pytest.mark.parametrize("periods", [2, 3, 6])
def test_after_a_late_voltage_the_next_turn_may_stay_in_force_as_long_without_harm(periods):
    _, volts, place = turned(periods * PERIOD)
    assert spool(place, volts[0], periods * PERIOD) == pytest.approx(-place, rel=0.01)


def test_that_caution_fades():
    state, _, _ = turned(6.0 * PERIOD)
    for _ in range(1000):
        state, _ = valve_driver.step(state, BACK, UNSEEN, STILL, P, PERIOD)
    assert state.ahead == pytest.approx(PERIOD, rel=0.05)


def test_of_commands_that_come_at_once_the_last_is_obeyed_as_if_it_had_come_alone():
    p = valve_driver_parameters.parameters(load_machine("c180_hoses"), Settings(adapt=True))
    before, _, _ = turned(PERIOD)
    alone, volts = valve_driver.step(before, MORE, UNSEEN, STILL, p, 3.0 * PERIOD)
    crowd = before
    for command, dt in ((BACK, 3.0 * PERIOD), ((0.1, 0.0, 0.0), 0.0), (MORE, 0.0)):
        crowd, last = valve_driver.step(crowd, command, UNSEEN, STILL, p, dt)
    assert crowd.spools == alone.spools
    assert last == volts


@pytest.mark.parametrize("before", [REST, valve_driver.at_rest(REST)])
def test_a_first_command_close_behind_another_fails_nothing(before):
    state, volts = valve_driver.step(before, MORE, UNSEEN, STILL, P, 0.0)
    assert math.isfinite(volts[0])
    assert valve_driver.step(state, BACK, UNSEEN, STILL, P, PERIOD)[1][0] < -EDGE


def test_a_driver_that_centred_its_valves_stays_cautious():
    late, _, _ = turned(6.0 * PERIOD)
    assert valve_driver.at_rest(late).ahead == late.ahead
