"""The rule for the gains: what it heeds, and that a person's own gains overrule it."""

from dataclasses import replace

import pytest

from forest_control.config.controller_settings import Settings, parameters, with_rules
from forest_control.servo.gain_rule import HIGHEST_GAIN, gains_by_rule, integral
from forest_description.machine import load_machine

C180 = load_machine("c180_hoses")


def test_stiff_oil_and_quick_spools_bear_the_highest_gain_and_soft_or_slow_ones_less():
    assert gains_by_rule(C180).feedback == HIGHEST_GAIN
    soft = replace(C180, hose=replace(C180.hose, capacitance=20.0 * C180.hose.capacitance))
    slow = replace(C180, valve=replace(C180.valve, spool_bandwidth=2.0, dead_time=0.02))
    for worse in (soft, slow):
        assert all(
            less < most for less, most in zip(gains_by_rule(worse).feedback, HIGHEST_GAIN, strict=True)
        )


def test_a_swing_whose_valve_is_too_slow_is_not_damped_by_its_rate():
    assert gains_by_rule(C180).rate == (0.4, 0.0, 0.0)
    assert gains_by_rule(load_machine("loader")).rate == (0.0, 0.0, 0.0)


def test_gains_that_a_person_sets_overrule_the_rule_joint_by_joint():
    rule = gains_by_rule(C180)
    told = with_rules(C180, Settings(feedback_gain=(-1.0, 2.0, 0.0), integral_gain=(1.0, -1.0, -1.0)))
    assert told.feedback_gain == (rule.feedback[0], 2.0, 0.0)
    assert told.integral_gain == (1.0, pytest.approx(integral(2.0, 1)), 0.0)
    assert told.rate_gain == rule.rate
    assert parameters(C180, told).coordinated.integral == told.integral_gain


def test_settings_without_anything_to_find_stay():
    told = Settings(
        tip_acceleration=4.0, feedback_gain=(1.0, 1.0, 1.0), integral_gain=(0.0,) * 3, rate_gain=(0.0,) * 3
    )
    assert with_rules(C180, told) is told
