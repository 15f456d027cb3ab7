"""The rule for the tip's acceleration: no shorter ramp than the oil's spring bears."""

from dataclasses import replace

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.servo.acceleration_rule import (
    FREQUENCY,
    HIGHEST_ACCELERATION,
    LONGEST,
    TIP_SPEED,
    acceleration_by_rule,
    overshoot,
    ramp_time,
)
from forest_control.servo.joint_response import poses, rate_response, response_model
from forest_description.machine import load_machine

C180 = load_machine("c180")
PLACE, DAMPING = 2.0, 0.02  # [Hz] of an oscillator, and its damping ratio
X = FREQUENCY / PLACE
OSCILLATOR = 1.0 / (1.0 + 2j * DAMPING * X - X * X)


@pytest.mark.parametrize("turns", [0.25, 0.5, 1.5])
def test_a_ramp_over_a_part_of_a_period_leaves_an_oscillator_rocking_as_in_closed_form(turns: float):
    # The first peak after the ramp's middle, half a period or so later: the share that is left, damped.
    left = abs(np.sinc(turns)) * np.exp(-np.pi * DAMPING * (1.0 + turns) / 2.0)
    assert overshoot(OSCILLATOR[None, :], turns / PLACE) == pytest.approx(left, abs=0.05)


def test_a_ramp_over_a_whole_period_leaves_it_at_rest():
    assert overshoot(OSCILLATOR[None, :], 1.0 / PLACE) < 0.06


def test_stiff_oil_bears_the_highest_acceleration_and_soft_oil_less():
    assert ramp_time(load_machine("c180_hoses")) == TIP_SPEED / HIGHEST_ACCELERATION
    soft = replace(C180, hose=replace(C180.hose, capacitance=4.0 * C180.hose.capacitance))
    assert 0.2 < ramp_time(C180) < ramp_time(soft) <= LONGEST


def test_a_faster_tip_has_as_long_a_ramp_and_a_slower_one_as_steep_a_one():
    half = acceleration_by_rule(C180, TIP_SPEED)
    assert half == TIP_SPEED / ramp_time(C180)
    assert acceleration_by_rule(C180, 0.1) == half
    assert acceleration_by_rule(C180, 1.2 * TIP_SPEED) == pytest.approx(1.2 * half)
    assert acceleration_by_rule(C180, 10.0) == HIGHEST_ACCELERATION


def test_behind_compensators_the_inlets_oil_alone_is_a_spring_after_a_rest():
    forwarder, s = load_machine("forwarder"), 2j * np.pi * np.array([0.5])
    for machine, fewer in ((forwarder, True), (C180, False)):
        q, model = poses(machine)[4], response_model(machine)
        for rate in (0.1, -0.1):
            full, emptied = (rate_response(model, q, 0, rate, s, emptied=e) for e in (False, True))
            assert bool(abs(emptied[0] - 1.0) > abs(full[0] - 1.0)) == fewer
    # Head and rod of a cylinder are unlike springs: which of them is the inlet goes with the direction.
    model = response_model(forwarder)
    lifted, lowered = (rate_response(model, q, 1, rate, s, emptied=True) for rate in (0.1, -0.1))
    assert lifted[0] != lowered[0]


def test_an_acceleration_that_a_person_sets_overrules_the_rule():
    assert parameters(C180, Settings(tip_acceleration=3.0)).coordinated.acceleration == 3.0
    for left in (0.0, -1.0):
        by_rule = parameters(C180, Settings(tip_acceleration=left)).coordinated.acceleration
        assert by_rule == acceleration_by_rule(C180, Settings().tip_speed)
