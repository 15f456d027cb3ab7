"""A joint that goes by itself under a shut valve is named; one that rocks, leaks or is driven is not."""

import math

import pytest

from forest_control.config import controller_settings
from forest_control.safety.runaway import Runaway, objection, runs_away, watched
from forest_description.machine import load_machine
from forest_description.types import AXES, ZERO
from forest_msgs_py.types import PERIOD

C180 = load_machine("c180_hoses")
P = controller_settings.parameters(C180, controller_settings.Settings())
EDGE = 1.0  # [V] of its overlap


def after(seconds, rates, voltages=ZERO, before=None):
    runaway = before or Runaway()
    for k in range(round(seconds / PERIOD)):
        runaway = watched(runaway, rates(k * PERIOD), voltages, P, PERIOD)
    return runaway


@pytest.mark.parametrize("joint", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_goes_under_a_shut_valve_is_named_after_0_4_s(joint, side):
    def goes(_time):
        return tuple(0.2 * side if i == joint else 0.0 for i in range(3))

    assert not runs_away(after(0.4 - PERIOD, goes))
    found = after(0.4 + 2.0 * PERIOD, goes)
    assert runs_away(found)
    told = objection(found)
    assert told.startswith(f"machine: {AXES[joint]} goes by itself, 5 degrees though its valve is shut")
    assert "shut off the hydraulics" in told
    assert objection(Runaway()) == ""


def test_a_slow_one_is_named_once_it_has_gone_50_mrad():
    assert not runs_away(after(0.8, lambda _t: (0.06, 0.0, 0.0)))
    assert runs_away(after(0.85, lambda _t: (0.06, 0.0, 0.0)))


def test_within_the_overlap_a_valve_is_shut_and_beyond_it_open():
    def goes(_time):
        return 0.0, 0.2, 0.0

    for volts, named in ((EDGE, True), (-EDGE, True), (EDGE + 0.01, False), (-EDGE - 0.01, False)):
        assert runs_away(after(1.0, goes, (0.0, volts, 0.0))) == named
    stopped = after(PERIOD, goes, (0.0, 2.0, 0.0), after(0.3, goes))
    assert not runs_away(after(0.3, goes, before=stopped))


def test_what_rocks_on_its_oil_or_leaks_is_not_named():
    assert not runs_away(after(5.0, lambda t: (0.4 * math.sin(2.0 * math.pi * 1.4 * t), 0.0, 0.0)))
    assert not runs_away(after(60.0, lambda _t: (0.049, 0.0, 0.0)))
    assert runs_away(after(60.0, lambda _t: (0.05, 0.0, 0.0)))


def test_a_joint_that_turns_round_begins_anew():
    there = after(0.39, lambda _t: (0.3, 0.0, 0.0))
    back = watched(there, (-0.3, 0.0, 0.0), ZERO, P, PERIOD)
    assert back.ways[0] == pytest.approx(-0.3 * PERIOD)
    assert back.times[0] == PERIOD
    assert not runs_away(after(0.38, lambda _t: (-0.3, 0.0, 0.0), before=back))
    assert runs_away(after(0.41, lambda _t: (-0.3, 0.0, 0.0), before=back))


@pytest.mark.parametrize("rates", [(0.0499, 0.0, 0.0), ZERO])
def test_a_joint_that_stands_or_creeps_begins_anew(rates):
    assert watched(after(0.39, lambda _t: (0.3, 0.0, 0.0)), rates, ZERO, P, PERIOD) == Runaway()


def test_each_side_of_a_valve_has_its_own_overlap():
    axes = P.speed_limits.axes
    law = axes[0].valve
    wide = law._replace(backward=law.backward._replace(deadband_voltage=2.0))
    uneven = axes[0]._replace(valve=wide)
    p = P._replace(speed_limits=P.speed_limits._replace(axes=(uneven, *axes[1:])))
    for volts, shut in ((EDGE, True), (EDGE + 0.5, False), (-EDGE - 0.5, True), (-2.1, False)):
        gone = watched(Runaway(), (0.3, 0.0, 0.0), (volts, 0.0, 0.0), p, PERIOD)
        assert (gone != Runaway()) == shut


def test_zero_volts_are_shut_whatever_the_edges_are():
    """A spool without overlap has edges on the wrong side of zero."""
    axes = P.speed_limits.axes
    law = axes[0].valve
    direction = law.forward._replace(deadband_voltage=-0.1)
    under = axes[0]._replace(valve=law._replace(forward=direction, backward=direction))
    p = P._replace(speed_limits=P.speed_limits._replace(axes=(under, *axes[1:])))
    runaway = Runaway()
    for _ in range(100):
        runaway = watched(runaway, (0.3, 0.0, 0.0), ZERO, p, PERIOD)
    assert runs_away(runaway)
