"""Claims about what axes and levers mean."""

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.levers import (
    AXIS_COUNT,
    BUTTON_COUNT,
    LEFT_SHOULDER,
    LEFT_X,
    LEFT_Y,
    REST,
    RIGHT_Y,
    Levers,
    axes_from_levers,
    levers_for_tip_velocity,
    levers_from_axes,
    rate_mode_rates,
)
from forest_control.operator.operator_profile import rate_mode_velocity
from forest_description.machine import load_machine
from forest_msgs_py.interfaces.topics import JOY_AXES, JOY_BUTTONS

MACHINE = load_machine("c180_hoses")


def wish(levers, speed):
    """The tip velocity that levers wish at a full deflection's speed."""
    return rate_mode_velocity(
        levers, (0.0, 0.4, -1.5), parameters(MACHINE, Settings(tip_speed=speed)).profile
    )


def random_levers(count=200):
    return [Levers(*row) for row in np.random.default_rng(1).uniform(-1.0, 1.0, (count, 3)).tolist()]


def test_levers_come_back_from_axes():
    for levers in random_levers():
        assert levers_from_axes(axes_from_levers(levers)) == levers


def test_each_lever_has_its_axis_and_the_other_axes_rest():
    assert axes_from_levers(Levers(0.1, 0.2, -0.3)) == (0.1, -0.3, 0.0, 0.2, 0.0, 0.0)
    assert rate_mode_rates(Levers(0.5, -0.2, 0.25), (0.8, 0.3, 0.4)) == pytest.approx((0.4, -0.06, 0.1))


def test_levers_come_back_from_the_tip_velocity_that_they_wish():
    for levers in random_levers():
        again = levers_for_tip_velocity(wish(levers, 0.7), 0.7)
        assert again == pytest.approx(levers, abs=1e-15)


@pytest.mark.parametrize(
    ("axis", "joint", "direction"), [(LEFT_X, 0, 1), (RIGHT_Y, 1, 2), (LEFT_Y, 2, 0)], ids=["x", "ry", "ly"]
)
def test_each_axis_moves_one_joint_or_one_direction_of_the_tip(axis, joint, direction):
    axes = [0.0] * AXIS_COUNT
    axes[axis] = 1.0
    levers = levers_from_axes(tuple(axes))
    assert rate_mode_rates(levers, (0.8, 0.3, 0.2)) == tuple(
        rate if i == joint else 0.0 for i, rate in enumerate((0.8, 0.3, 0.2))
    )
    assert wish(levers, 0.5) == tuple(0.5 if i == direction else 0.0 for i in range(3))


def test_deflections_beyond_one_count_as_one():
    assert levers_from_axes((1.5, -2.0, 0.3, 1.0001)) == Levers(1.0, 1.0, -1.0)


def test_levers_at_rest_wish_no_motion():
    assert REST == (0.0, 0.0, 0.0)
    assert rate_mode_rates(REST, (0.8, 0.3, 0.2)) == wish(REST, 0.5) == (0.0, 0.0, 0.0)


def test_axes_and_buttons_are_those_of_the_topic_table():
    assert (len(JOY_AXES), len(JOY_BUTTONS)) == (AXIS_COUNT, BUTTON_COUNT)
    assert [JOY_AXES[i] for i in (LEFT_X, LEFT_Y, RIGHT_Y)] == ["left_x", "left_y", "right_y"]
    assert JOY_BUTTONS[LEFT_SHOULDER] == "left_shoulder"
