"""The course of an experiment in a pure core: it begins, drives, reports progress and the reason to stop."""

import math

import pytest

from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_ident.driving.safety_monitor import Readings
from forest_ident.driving.scripted_operator import START_LIMIT, ScriptedOperator
from forest_ident.experiments import experiment_plan

C180 = load_machine("c180_hoses")
PERIOD_NS = 5_000_000
PLAN = experiment_plan.plan("damping_boom", C180, longest=5.0)
WELL = Readings(PLAN.angles, (5e6, 3e6), 20.7e6, 313.0)


def begun(plan=PLAN):
    operator = ScriptedOperator(plan, timeout=0.1, now=100.0)
    operator.begin()
    return operator


def drive(operator, readings, seconds, crane=None, since=0.0):
    """Step on good samples; return the voltages and the first reason to stop."""
    volts = []
    for k in range(round(since / 0.005), round((since + seconds) / 0.005)):
        assert operator.accepts((k + 1) * PERIOD_NS, 100.0 + 0.005 * k, "")
        voltages, reason = operator.step(readings, crane)
        volts.append(voltages)
        if reason:
            return volts, reason
    return volts, ""


def test_it_drives_the_planned_axis_alone_and_is_finished_at_the_end_of_the_programme():
    operator = begun()
    volts, reason = drive(operator, WELL, 4.9)
    assert not reason
    assert not operator.finished
    assert any(v[1] != 0.0 for v in volts)
    assert all(v[0] == v[2] == 0.0 for v in volts)
    drive(operator, WELL, 0.2, since=4.9)
    assert operator.finished


def test_progress_is_said_once_a_second():
    operator, lines = begun(), []
    for k in range(420):
        operator.accepts((k + 1) * PERIOD_NS, 100.0, "")
        operator.step(WELL)
        lines.append(operator.progress())
    assert [line for line in lines if line] == [f"operator at {second} of 5 s" for second in range(3)]


def test_a_reading_beyond_its_bound_gives_the_reason_and_zero():
    high = WELL._replace(angles=(PLAN.angles[0], math.radians(80.0), PLAN.angles[2]))
    volts, reason = drive(begun(), high, 1.0)
    assert "the boom stands at 80.0 deg" in reason
    assert volts == [ZERO]


@pytest.mark.parametrize(("away", "stops"), [(0.019, False), (-0.021, True)])
def test_a_crane_that_moves_while_its_valve_is_on_the_rig_stops_the_experiment(away, stops):
    plan = experiment_plan.plan("valve", C180)
    operator = begun(plan)
    rig = Readings(ZERO, (5e6, 3e6), 20.7e6, 313.0)
    assert not drive(operator, rig, 0.005, crane=(0.0, 0.5, -1.5))[1]
    reason = operator.step(rig, (0.0, 0.5 + away, -1.5))[1]
    assert bool(reason) is stops
    assert not stops or "the boom moves" in reason


def test_a_bad_sample_or_one_out_of_order_is_not_accepted():
    operator = begun()
    assert operator.accepts(2 * PERIOD_NS, 100.0, "")
    assert not operator.accepts(3 * PERIOD_NS, 100.005, "position: not finite")
    assert not operator.accepts(PERIOD_NS, 100.01, "")
    assert operator.accepts(4 * PERIOD_NS, 100.015, "")


def test_it_is_overdue_when_nothing_begins_and_when_no_good_sample_comes():
    waiting = ScriptedOperator(PLAN, timeout=0.1, now=100.0)
    assert not waiting.overdue(100.0 + START_LIMIT, "a driver")
    assert (
        waiting.overdue(100.1 + START_LIMIT, "a driver") == "not everything was there within 15 s: a driver"
    )
    operator = begun()
    operator.accepts(PERIOD_NS, 100.0, "")
    operator.accepts(2 * PERIOD_NS, 100.09, "position: not finite")
    assert not operator.overdue(100.09, "")
    assert operator.overdue(100.11, "") == "nothing good of the machine's state for 0.1 s"


def test_live_the_swing_goes_about_where_it_stands():
    plan = experiment_plan.plan("motor_external", C180)
    operator = ScriptedOperator(plan, timeout=0.1, now=100.0)
    operator.begin_around(2.0)
    assert operator.begun
    readings = Readings((2.0, *plan.angles[1:]), (5e6, 3e6), 20.7e6, 313.0)
    volts, reason = drive(operator, readings, 2.0)
    assert not reason
    assert any(v[0] != 0.0 for v in volts)
