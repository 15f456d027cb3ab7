"""A joint that goes by itself under a shut valve is named; one that rocks, leaks or is driven is not."""

import math

import pytest

from forest_control.config import controller_settings
from forest_control.safety.runaway import Runaway, objection, runs_away, updated_runaway
from forest_description.machine import load_machine
from forest_description.types import AXES, ZERO
from forest_msgs_py.types import PERIOD

C180 = load_machine("c180_hoses")
P = controller_settings.parameters(C180, controller_settings.Settings())
EDGE = 1.0  # [V] of its overlap


def after(seconds, rates, voltages=ZERO, before=None):
    runaway = before or Runaway()
    for k in range(round(seconds / PERIOD)):
        runaway = updated_runaway(runaway, rates(k * PERIOD), voltages, P, PERIOD)
    return runaway


def sets_off(rate, i=0):
    """A joint that stood, and goes."""

    def rates(time):
        return tuple((rate if time > 0.0 else math.copysign(0.05, rate)) if k == i else 0.0 for k in range(3))

    return rates


@pytest.mark.parametrize("joint", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_sets_off_under_a_shut_valve_is_named_after_0_55_s(joint, side):
    assert not runs_away(after(0.45, sets_off(0.2 * side, joint)))
    found = after(0.55, sets_off(0.2 * side, joint))
    assert runs_away(found)
    told = objection(found)
    assert told.startswith(f"machine: {AXES[joint]} goes by itself, 6 degrees though its valve is shut")
    assert "shut off the hydraulics" in told
    assert objection(Runaway()) == ""


def test_a_fast_one_is_not_named_within_0_4_s():
    assert not runs_away(after(0.4 - PERIOD, sets_off(1.0)))
    assert runs_away(after(0.4 + 2.0 * PERIOD, sets_off(1.0)))


def test_a_joint_that_goes_on_as_fast_as_before_the_valve_shut_is_named_after_1_25_s():
    assert not runs_away(after(1.2, lambda _t: (0.2, 0.0, 0.0)))
    assert runs_away(after(1.3, lambda _t: (0.2, 0.0, 0.0)))


def test_one_that_brakes_from_full_speed_is_not_named():
    assert not runs_away(after(5.0, lambda t: (0.5 * math.exp(-t), 0.0, 0.0)))


def test_within_the_overlap_a_valve_is_shut_and_beyond_it_open():
    goes = sets_off(0.2, 1)
    for volts, named in ((EDGE, True), (-EDGE, True), (EDGE + 0.01, False), (-EDGE - 0.01, False)):
        assert runs_away(after(1.0, goes, (0.0, volts, 0.0))) == named
    stopped = after(PERIOD, goes, (0.0, 2.0, 0.0), after(0.3, goes))
    assert not runs_away(after(0.3, goes, before=stopped))


def test_what_rocks_on_its_oil_or_leaks_is_not_named():
    assert not runs_away(after(5.0, lambda t: (0.4 * math.sin(2.0 * math.pi * 1.4 * t), 0.0, 0.0)))
    assert not runs_away(after(60.0, lambda _t: (0.049, 0.0, 0.0)))
    assert runs_away(after(60.0, lambda _t: (0.05, 0.0, 0.0)))


def test_a_joint_that_turns_round_begins_anew():
    there = after(1.1, lambda _t: (0.3, 0.0, 0.0))
    back = updated_runaway(there, (-0.3, 0.0, 0.0), ZERO, P, PERIOD)
    assert back.ways[0] == pytest.approx(-0.3 * PERIOD)
    assert (back.times[0], back.firsts[0]) == (PERIOD, 0.3)
    assert not runs_away(after(1.1, lambda _t: (-0.3, 0.0, 0.0), before=back))
    assert runs_away(after(1.2, lambda _t: (-0.3, 0.0, 0.0), before=back))


@pytest.mark.parametrize("rates", [(0.0499, 0.0, 0.0), ZERO])
def test_a_joint_that_stands_or_creeps_begins_anew(rates):
    assert updated_runaway(after(0.39, lambda _t: (0.3, 0.0, 0.0)), rates, ZERO, P, PERIOD) == Runaway()


def test_each_side_of_a_valve_has_its_own_overlap():
    axes = P.speed_limits.axes
    law = axes[0].valve
    wide = law._replace(backward=law.backward._replace(deadband_voltage=2.0))
    uneven = axes[0]._replace(valve=wide)
    p = P._replace(speed_limits=P.speed_limits._replace(axes=(uneven, *axes[1:])))
    for volts, shut in ((EDGE, True), (EDGE + 0.5, False), (-EDGE - 0.5, True), (-2.1, False)):
        gone = updated_runaway(Runaway(), (0.3, 0.0, 0.0), (volts, 0.0, 0.0), p, PERIOD)
        assert (gone != Runaway()) == shut


def test_zero_volts_are_shut_whatever_the_edges_are():
    """A spool without overlap has edges on the wrong side of zero."""
    axes = P.speed_limits.axes
    law = axes[0].valve
    direction = law.forward._replace(deadband_voltage=-0.1)
    under = axes[0]._replace(valve=law._replace(forward=direction, backward=direction))
    p = P._replace(speed_limits=P.speed_limits._replace(axes=(under, *axes[1:])))
    runaway = Runaway()
    for _ in range(240):
        runaway = updated_runaway(runaway, (0.3, 0.0, 0.0), ZERO, p, PERIOD)
    assert runs_away(runaway)
