"""Claims about a measured state: what cannot be true is refused and named, what end stops give is not."""

import math

import pytest
from hypothesis import given
from properties import near

from forest_control.config import controller_settings
from forest_control.safety.state_checks import FASTEST, ROUGH, implausible, jump, jumps, plausible
from forest_description.derived.limits import joint_limits
from forest_description.machine import load_machine
from forest_description.types import AXES

MACHINE = load_machine("c180_hoses")
P = controller_settings.parameters(MACHINE, controller_settings.Settings(joint_margin=0.0))
MIDDLE, ZERO = (0.2, 0.4, -1.4), (0.0, 0.0, 0.0)
every_joint = pytest.mark.parametrize("joint", range(3), ids=AXES)


def but(values, joint, value):
    return (*values[:joint], value, *values[joint + 1 :])


def said(angles, rates):
    """What is said of a state, by those who name it and by those who only tell."""
    problem = implausible(angles, rates, P)
    assert plausible(angles, rates, P) == (problem == "")
    return problem


def test_a_crane_at_rest_in_the_middle_is_believed():
    assert said(MIDDLE, ZERO) == ""


@every_joint
@pytest.mark.parametrize("end", [0, 1], ids=["lower", "upper"])
def test_a_joint_may_be_a_tenth_of_a_radian_beyond_either_limit_and_no_further(joint, end):
    limit, outward = joint_limits(MACHINE)[joint][end], (-1.0, 1.0)[end]
    assert said(but(MIDDLE, joint, limit + outward * 0.1), ZERO) == ""
    assert f"{AXES[joint]} is" in said(but(MIDDLE, joint, limit + outward * 0.1001), ZERO)


@every_joint
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_joint_may_move_at_five_radians_a_second_either_way_and_no_faster(joint, sign):
    assert said(MIDDLE, but(ZERO, joint, sign * 5.0)) == ""
    assert f"{AXES[joint]} moves at" in said(MIDDLE, but(ZERO, joint, sign * 5.001))


@every_joint
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e308])
def test_what_is_no_number_is_refused(joint, bad):
    assert AXES[joint] in said(but(MIDDLE, joint, bad), ZERO)
    assert AXES[joint] in said(MIDDLE, but(ZERO, joint, bad))


def test_degrees_are_named():
    assert "swing is 11.4592 rad; allowed" in said(tuple(map(math.degrees, MIDDLE)), ZERO)


@given(near(-0.9, 0.9), near(-5.5, 5.5))
def test_of_any_state_those_who_name_it_and_those_who_only_tell_agree_and_it_is_finite(ways, rates):
    angles = tuple(middle + way for middle, way in zip(MIDDLE, ways, strict=True))
    if said(angles, rates) == "":
        assert all(map(math.isfinite, (*angles, *rates)))


@every_joint
@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("way", "named"), [(0.0299, False), (0.0301, True), (0.5, True)])
def test_an_angle_may_go_as_far_as_the_fastest_joint_in_its_time_and_no_further(joint, sign, way, named):
    """5 rad/s for 5 ms, and 5 mrad of noise."""
    assert (FASTEST, ROUGH) == (5.0, 0.005)
    there = but(MIDDLE, joint, MIDDLE[joint] + sign * way)
    assert jumps(MIDDLE, there, 0.005) == named
    told = f"joint state: {AXES[joint]} jumps by {way:.3f} rad in 0.005 s; allowed: up to 5 rad/s"
    assert jump(MIDDLE, there, 0.005) == (told if named else "")
    assert not jumps(MIDDLE, there, 0.2)
    assert jump(MIDDLE, there, 0.2) == ""
