"""Claims about a late link: from a round trip of 0.2 s on the levers are slower, and nothing else slows."""

import math

import pytest

from forest_control.config import controller_settings
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator.late_link import IN_TIME, LateLink, round_trip, speed_scale, updated_link
from forest_control.operator.levers import Levers
from forest_control.pipeline.control_state import REST, Inputs
from forest_control.pipeline.controller import step
from forest_control.servo.schemes import Scheme
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD, PERIOD_NS

C180 = load_machine("c180_hoses")
ANGLES = (0.0, 0.5, -1.4)
BEGIN = 10**18  # [ns] of a clock that has run for long


def behind(age, seconds=5.0, every=2, link=IN_TIME):
    """The link after a joystick's samples, each so old as it comes [s]."""
    for k in range(round(seconds / PERIOD)):
        now = BEGIN + k * PERIOD_NS
        sent = BEGIN + (k - k % every) * PERIOD_NS
        link = updated_link(link, sent - round(1e9 * age), now, PERIOD)
    return link


@pytest.mark.parametrize("every", [1, 4, 10])
@pytest.mark.parametrize(("age", "scale"), [(0.0, 1.0), (0.099, 1.0), (0.15, 2.0 / 3.0), (0.4, 0.25)])
def test_the_speed_falls_as_the_round_trip_grows_at_any_rate_of_the_joystick(age, scale, every):
    link = behind(age, every=every)
    assert round_trip(link) == pytest.approx(2.0 * age, abs=1e-3)
    assert speed_scale(link) == pytest.approx(scale, abs=2e-3)


def test_one_late_sample_is_no_late_link_and_half_a_second_of_them_is():
    link = behind(0.02)
    assert speed_scale(updated_link(link, BEGIN - 10**9, BEGIN, PERIOD)) == 1.0
    assert speed_scale(behind(0.4, 0.5, link=link)) < 0.5
    assert behind(0.4, 0.5).age == pytest.approx(0.4 * (1.0 - math.exp(-0.5 / 0.5)), rel=0.02)
    assert speed_scale(behind(0.02, 3.0, link=behind(0.4))) == 1.0


@pytest.mark.parametrize("age", [-0.3, 2.1, 1e6])
def test_another_clock_tells_nothing(age):
    assert behind(age) == behind(0.0)._replace(stamp=behind(age).stamp)


def test_a_link_of_nearly_two_seconds_is_late():
    assert behind(1.9).age == pytest.approx(1.9, rel=1e-3)


def test_the_first_sample_has_no_more_weight_than_any_other():
    assert updated_link(IN_TIME, BEGIN - 10**9, BEGIN, PERIOD).age == pytest.approx(PERIOD / 0.5, rel=0.01)
    assert round_trip(IN_TIME) == 0.0


def test_without_a_stamp_nothing_is_known():
    assert speed_scale(updated_link(IN_TIME, 0, BEGIN, 1.0)) == 1.0
    assert speed_scale(updated_link(IN_TIME, BEGIN, 0, 1.0)) == 1.0
    assert updated_link(LateLink(stamp=5), 0, 10**9, 1.0).age == 0.0  # simulated time has just begun


@pytest.mark.parametrize("scheme", [Scheme.COORDINATED, Scheme.JACOBIAN_VELOCITY, Scheme.JOINT])
def test_the_levers_move_the_crane_at_their_share_which_is_named(scheme):
    p, said = controller_settings.parameters(C180, controller_settings.Settings(scheme=scheme)), {}
    for scale in (1.0, 0.4):
        state, inputs = REST, Inputs(ANGLES, ZERO, Levers(0.0, 0.0, 0.0), True, speed_scale=scale)
        for k in range(200):
            levers = Levers(0.2, 0.1, -0.1) if k > 60 else inputs.levers
            state, said[scale] = step(state, inputs._replace(levers=levers), p, PERIOD)
    assert said[0.4].scaling == (pytest.approx(0.4), Limit.LATE)
    assert said[1.0].scaling.limit == Limit.NONE
    told = "command" if scheme == Scheme.JOINT else "tip_velocity_reference"
    whole = getattr(said[1.0], told)
    assert getattr(said[0.4], told) == pytest.approx([0.4 * x for x in whole], rel=0.02)
