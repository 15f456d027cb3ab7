"""Claims about the stop along the path."""

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.operator.levers import REST as LEVERS_AT_REST
from forest_control.pipeline import control_state, controller, stop_profile
from forest_control.servo import coordinated_servo
from forest_description.geometry.kinematics import Links, is_singular, tip_velocity
from forest_description.machine import load_machine

LINKS = Links(0.41, 4.1, 2.9)
POSE, STRAIGHT = (0.3, 0.5, -1.4), (0.3, 0.5, 0.0)
CLOSED_LOOP, OPEN_LOOP = 0.24, 0.16  # [s] as docs/explanation/safety.md tells
TIMES = np.linspace(0.0, CLOSED_LOOP, 2001)


def left_over_time(of=stop_profile.velocity_left):
    begun = stop_profile.NO_STOP._replace(duration=CLOSED_LOOP)
    return np.array([of(begun._replace(elapsed=time)) for time in TIMES.tolist()])


def test_the_velocity_falls_to_nothing_on_the_way_that_is_told():
    left = left_over_time()
    assert (left[0], left[-1]) == (1.0, 0.0)
    assert np.all(np.diff(left) < 0.0)
    assert left.mean() == pytest.approx(4.0 / 9.0, abs=1e-3)


def test_the_deceleration_is_the_one_that_is_told_and_vanishes_at_both_ends():
    braking = -np.gradient(left_over_time(), TIMES) * CLOSED_LOOP
    assert braking.max() == pytest.approx(1.63, abs=5e-3)
    assert max(braking[0], braking[-1]) < 0.01


def test_the_reference_goes_by_what_was_commanded_a_lag_ago():
    lag = round(0.015 / (TIMES[1] - TIMES[0]))
    late = left_over_time(stop_profile.lagged_velocity_left)
    np.testing.assert_allclose(late[lag:], left_over_time()[:-lag], atol=2e-3)
    assert np.all(late[: lag - 1] == 1.0)


def test_a_joint_that_would_turn_round_is_not_commanded():
    assert stop_profile.onwards((0.1, -0.02, 1e-9), (0.05, 0.01, 0.0)) == (0.1, 0.0, 0.0)
    rng = np.random.default_rng(41)
    for _ in range(200):
        u, a = (tuple(x) for x in rng.normal(0.0, 0.1, (2, 3)).tolist())
        kept = stop_profile.onwards(u, a)
        assert kept == tuple(np.where(np.multiply(u, a) > 0.0, u, 0.0))


def stop_of(away):
    """The stop as the deadman is let go in motion, the joints off their reference by some [rad]."""
    p = controller_settings.parameters(load_machine("c180_hoses"), controller_settings.Settings())
    rates, wish = (0.05, 0.02, -0.03), (0.1, 0.2, -0.1)
    reference = tuple(angle + off for angle, off in zip(POSE, away, strict=True))
    memory = coordinated_servo.in_motion(wish, rates, coordinated_servo.MOST_SAMPLES)
    state = control_state.REST._replace(
        reference=reference, enabled=True, memory=memory, scheme=p.scheme, rates=rates
    )
    released = control_state.Inputs(POSE, rates, LEVERS_AT_REST, False)
    return controller.step(state, released, p, 0.005)[0].stop


@pytest.mark.parametrize(
    ("away", "lasts"),
    [
        ((0.0, 0.0, 0.0), CLOSED_LOOP),
        *(
            (tuple(0.0099 * sign * (i == k) for i in range(3)), CLOSED_LOOP)
            for k in range(3)
            for sign in (1, -1)
        ),
        *(
            (tuple(0.0101 * sign * (i == k) for i in range(3)), OPEN_LOOP)
            for k in range(3)
            for sign in (1, -1)
        ),
    ],
)
def test_a_joint_that_stalled_a_hundredth_of_a_radian_off_its_reference_is_not_pulled_there(away, lasts):
    stop = stop_of(away)
    assert stop.duration == lasts
    assert stop.elapsed == 0.005


@pytest.mark.parametrize("duration", [CLOSED_LOOP, OPEN_LOOP])
def test_a_stop_begins_with_all_of_the_velocity_and_is_over_in_its_time(duration):
    stop, steps = stop_profile.begin(duration, (0.1, 0.1, 0.1), (0.1, 0.2, 0.3), POSE, LINKS), 0
    assert stop_profile.velocity_left(stop) == stop_profile.lagged_velocity_left(stop) == 1.0
    while not stop_profile.is_over(stop):
        stop, steps = stop_profile.advanced(stop, duration / 32), steps + 1
    assert steps == 32
    assert stop_profile.velocity_left(stop) == 0.0
    assert stop_profile.is_over(stop._replace(elapsed=duration))
    assert not stop_profile.is_over(stop._replace(elapsed=0.999 * duration))


def begun_at(pose, u, part):
    """A stop of joint rates [rad/s] of which a part is over."""
    stop = stop_profile.begin(CLOSED_LOOP, u, (0.0, 0.0, 0.0), pose, LINKS)
    return stop_profile.advanced(stop, part * CLOSED_LOOP)


def test_the_tip_goes_on_straight_and_slower_though_the_joints_move_on():
    rng = np.random.default_rng(42)
    for _ in range(200):
        u = tuple(rng.normal(0.0, 0.2, 3).tolist())
        part = float(rng.uniform(0.1, 0.9))
        stop = begun_at(POSE, u, part)
        moved = tuple(angle + 0.1 * rate for angle, rate in zip(POSE, u, strict=True))
        rates, aimed = stop_profile.commanded(stop, moved, LINKS)
        x = 1.0 - part
        slower = np.multiply(x**2.5 * (3.5 - 2.5 * x), tip_velocity(POSE, u, LINKS))
        assert aimed == pytest.approx(slower, rel=1e-9)
        assert tip_velocity(moved, rates, LINKS) == pytest.approx(slower, rel=1e-9)


def test_where_the_tip_has_no_direction_left_each_joint_slows_down_by_itself():
    assert is_singular(STRAIGHT, LINKS)
    u = (0.1, -0.2, 0.3)
    stop = begun_at(STRAIGHT, u, 0.5)
    rates, aimed = stop_profile.commanded(stop, STRAIGHT, LINKS)
    left = stop_profile.velocity_left(stop)
    assert 0.3 < left < 0.5
    assert rates == pytest.approx(tuple(left * rate for rate in u))
    assert aimed == pytest.approx(np.multiply(left, tip_velocity(STRAIGHT, u, LINKS)))


def test_before_any_stop_none_is_under_way_and_nothing_is_commanded():
    assert stop_profile.is_over(stop_profile.NO_STOP)
    assert stop_profile.commanded(stop_profile.NO_STOP, POSE, LINKS) == ((0.0,) * 3, (0.0,) * 3)
