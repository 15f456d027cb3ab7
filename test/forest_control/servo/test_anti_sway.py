"""Anti-sway: what hangs from a tip that moves as the filter says is left at rest."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forest_control.config import controller_settings
from forest_control.operator.levers import REST
from forest_control.pipeline.control_state import Inputs, State
from forest_control.pipeline.motion_command import tip_velocity_command
from forest_control.servo.anti_sway import (
    NO_SWAY,
    Sway,
    SwayParameters,
    begun,
    filtered,
    sway_parameters,
)
from forest_control.servo.schemes import Scheme
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_description.mechanics.load import Pendulum
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

HEAD = SwayParameters(frequency=4.0, damping=0.1)
SPEED = 0.8


def passed_on(wishes, s=HEAD, dt=PERIOD):
    """The filter's answers to wishes along x, one a period [m/s]."""
    sway, answers = Sway(wish=(wishes[0], 0.0, 0.0)), []
    for u in wishes:
        sway, (x, _, _) = filtered(sway, (u, 0.0, 0.0), s, dt)
        answers.append(x)
    return np.array(answers)


def pulse(seconds=6.0, dt=PERIOD):
    """A wish that rises in 0.2 s, stands, and falls after 2 s."""
    time = np.arange(0.0, seconds, dt)
    return np.clip(np.minimum(time, 2.0 - time) / 0.2, 0.0, 1.0) * SPEED


def left_over(velocity, w, zeta=0.1, dt=PERIOD):
    """The greatest swing [m] of a pendulum in the last two seconds, its hook moving at a velocity [m/s]."""
    acceleration = np.gradient(velocity, dt)
    time = dt * np.arange(len(velocity))

    def rates(t, x):
        return x[1], -2.0 * zeta * w * x[1] - w * w * x[0] - np.interp(t, time, acceleration)

    swing = solve_ivp(rates, (0.0, time[-1]), (0.0, 0.0), t_eval=time, max_step=0.01, rtol=1e-8).y[0]
    return np.abs(swing[-round(2.0 / dt) :]).max()


def test_the_head_is_left_at_rest_and_the_tip_ends_where_it_would():
    wish = pulse()
    answer = passed_on(wish)
    assert left_over(answer, 4.0) < 0.02 * left_over(wish, 4.0)
    assert answer.sum() == pytest.approx(wish.sum(), rel=2e-3)


@pytest.mark.parametrize("seconds", [0.2, 0.3, 0.5, 0.8])
def test_a_short_stroke_goes_its_way_and_leaves_the_head_at_rest(seconds):
    time = np.arange(0.0, 8.0, PERIOD)
    wish = np.clip(np.minimum(time, seconds - time) / 0.1, 0.0, 1.0) * SPEED
    answer = passed_on(wish)
    assert answer.sum() * PERIOD == pytest.approx(wish.sum() * PERIOD, abs=1.5e-3)
    assert left_over(answer, 4.0) < 0.03 * left_over(wish, 4.0)


@pytest.mark.parametrize("share", [0.8, 1.2])
def test_a_head_that_swings_a_fifth_slower_or_faster_sways_by_60_percent_less_all_the_same(share):
    wish = pulse()
    assert left_over(passed_on(wish), share * 4.0) < 0.4 * left_over(wish, share * 4.0)


def test_the_lag_is_as_it_is_told():
    ramp = np.arange(0.0, 8.0, PERIOD)
    assert (ramp - passed_on(ramp))[-1] == pytest.approx(2.0 * (1.0 - 0.1) / 4.0, rel=0.02)


def test_the_answer_does_not_depend_on_the_period():
    coarse, fine = np.repeat([0.3, -0.2, 0.5, 0.1], 4), np.repeat([0.3, -0.2, 0.5, 0.1], 40)
    assert passed_on(coarse, dt=0.02)[-1] == pytest.approx(passed_on(fine, dt=0.002)[-1], abs=1e-12)


def test_a_velocity_that_was_passed_on_for_long_goes_on():
    sway, answer = filtered(begun((0.3, -0.1, 0.2), HEAD), (0.3, -0.1, 0.2), HEAD, PERIOD)
    assert answer == pytest.approx((0.3, -0.1, 0.2), abs=1e-12)
    assert sway.q == pytest.approx(ZERO, abs=1e-12)


def test_the_tip_comes_to_rest_for_good():
    sway = begun((0.3, 0.0, 0.0), HEAD)
    answers = []
    while sway != NO_SWAY:
        sway, answer = filtered(sway, ZERO, HEAD, PERIOD)
        answers.append(abs(answer[0]))
    assert answers[-1] == 0.0
    assert 1.5e-3 < answers[-2] < 3e-3  # [m/s] with a millimetre of way left
    assert len(answers) * PERIOD < 2.5


def test_the_pendulum_is_that_of_the_machine():
    loader = load_machine("loader")
    crane = loader.manipulator
    swings = dataclasses.replace(
        loader,
        manipulator=dataclasses.replace(crane, pendulum=Pendulum(length=1.0, inertia=0.0, damping=0.0)),
    )
    assert sway_parameters(swings) == pytest.approx((math.sqrt(crane.gravity), 0.0))
    hangs = dataclasses.replace(
        loader,
        manipulator=dataclasses.replace(crane, pendulum=Pendulum(length=1.0, inertia=0.0, damping=30.0)),
    )
    ratio = 30.0 / (2.0 * crane.head_mass * math.sqrt(crane.gravity))
    assert sway_parameters(hangs).damping == pytest.approx(ratio)
    assert sway_parameters(load_machine("c180_hoses")) == SwayParameters()


@pytest.mark.parametrize("scheme", [Scheme.JOINT, Scheme.IK_VELOCITY])
def test_a_scheme_without_the_filter_forgets_what_was_wished_before(scheme):
    """Or the crane would go on with it, sticks centred, once the scheme is chosen again."""
    forwarder = load_machine("forwarder")
    p = controller_settings.parameters(forwarder, controller_settings.Settings(scheme=scheme, anti_sway=True))
    pose = pose_at(start_tip(forwarder), forwarder)
    moving = State(pose, True, sway=begun((0.5, 0.0, 0.0), p.sway))
    after, _ = tip_velocity_command(moving, pose, Inputs(pose, ZERO, REST, True), p, PERIOD)
    assert after.sway == NO_SWAY
