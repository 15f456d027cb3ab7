"""Claims about stick curves and axis frames."""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.levers import Levers
from forest_control.operator.operator_profile import Frame, curve, rate_mode_velocity, shaped
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
DEFLECTIONS = np.linspace(-1.0, 1.0, 4001)
CURVES = [(0.0, 0.0), (0.1, 0.0), (0.0, 1.0), (0.3, 0.7), (0.5, 1.0)]


def hand(**settings):
    return parameters(MACHINE, Settings(**settings)).profile


@pytest.mark.parametrize(("deadzone", "expo"), CURVES)
def test_a_stick_curve_is_continuous_monotone_odd_and_has_exact_ends(deadzone, expo):
    values = np.array([curve(d, deadzone, expo) for d in DEFLECTIONS.tolist()])
    assert (values[0], values[-1], curve(0.0, deadzone, expo)) == (-1.0, 1.0, 0.0)
    assert curve(deadzone, deadzone, expo) == 0.0
    steps = np.diff(values)
    assert steps.min() >= 0.0
    steepest = (1.0 + 2.0 * expo) / (1.0 - deadzone)
    assert steps.max() <= 1.001 * steepest * (DEFLECTIONS[1] - DEFLECTIONS[0])
    assert values == pytest.approx(-values[::-1], abs=1e-12)


def test_a_straight_curve_passes_deflections_exactly():
    assert [curve(d, 0.0, 0.0) for d in DEFLECTIONS.tolist()] == DEFLECTIONS.tolist()


def test_deflections_beyond_one_count_as_one():
    assert curve(1.7, 0.2, 0.5) == 1.0
    assert curve(-1.7, 0.2, 0.5) == -1.0


def test_each_lever_has_its_own_curve_and_speed():
    h = hand(deadzone=(0.2, 0.0, 0.0), expo=(0.0, 1.0, 0.0), axis_speed=(0.1, 0.2, 3.0), tip_speed=0.4)
    assert shaped(Levers(0.1, 0.5, 0.5), h) == Levers(0.0, 0.125, 0.5)
    assert rate_mode_velocity(Levers(1.0, 1.0, 1.0), (0.0, 0.4, -1.5), h) == pytest.approx((0.4, 0.1, 0.2))


@pytest.mark.parametrize("swing", [0.0, 0.7, -2.5])
def test_in_the_cylindrical_frame_the_stick_lever_reaches_and_the_swing_lever_circles(swing):
    h, pose = hand(axis_frame=Frame.CYLINDRICAL, tip_speed=0.5), (swing, 0.4, -1.5)
    outwards = np.array([math.cos(swing), math.sin(swing), 0.0])
    left = np.array([-math.sin(swing), math.cos(swing), 0.0])
    assert rate_mode_velocity(Levers(0.0, 0.0, 1.0), pose, h) == pytest.approx(0.5 * outwards)
    assert rate_mode_velocity(Levers(1.0, 0.0, 0.0), pose, h) == pytest.approx(0.5 * left)
    assert rate_mode_velocity(Levers(0.0, 1.0, 0.0), pose, h) == pytest.approx([0.0, 0.0, 0.5])
