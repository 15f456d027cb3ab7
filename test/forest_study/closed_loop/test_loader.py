"""The loader crane in closed loop: what was built for the C-180 drives it as well."""

import math

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.operator.joystick_sources import thesis_levers
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits, pose_at, start_tip
from forest_description.machine import load_machine
from forest_study.closed_loop.closed_loop import Operator
from forest_study.closed_loop.compiled_loop import by_heart as run

LOADER = load_machine("loader")
START = pose_at(start_tip(LOADER), LOADER)
TIP_SPEED = controller_settings.Settings().tip_speed
RADIUS, TURN = 0.4, 0.6  # [m], [rad/s]: 0.24 m/s
TIP_SCHEMES = pytest.mark.parametrize("scheme", [Scheme.JACOBIAN_VELOCITY, Scheme.JACOBIAN_POSITION])


def session(operator, duration, scheme, drive=valve_driver_parameters.Settings()):  # noqa: B008 (immutable)
    return run(LOADER, operator, duration, START, controller_settings.Settings(scheme=scheme), drive)


def circle(across):
    """Return levers that lead the tip round a circle, upright or level, from its inner side, begun gently."""

    def operator(time):
        speed = RADIUS * TURN * min(1.0, time / 2.0)
        out, side = speed * math.sin(TURN * time), speed * math.cos(TURN * time)
        wish = (out, side, 0.0) if across else (out, 0.0, side)
        return Operator(levers_for_tip_velocity(wish, TIP_SPEED))

    return operator


def rms_mm(trajectory):
    return 1e3 * np.sqrt(np.mean(np.sum(trajectory.tip_error() ** 2, axis=1)))


def margins(trajectory):
    low, high = np.array(joint_limits(LOADER)).T
    return np.minimum(trajectory.angles.min(axis=0) - low, high - trajectory.angles.max(axis=0))


# Scheme (d) lags by the wish over K_p (5 1/s, the swing 2.5 1/s); (c) has no lag to speak of.
ROUND = [
    (Scheme.JACOBIAN_VELOCITY, False, 10.0),
    (Scheme.JACOBIAN_VELOCITY, True, 12.0),
    (Scheme.JACOBIAN_POSITION, False, 55.0),
    (Scheme.JACOBIAN_POSITION, True, 85.0),
]


@pytest.mark.parametrize(("scheme", "across", "bound"), ROUND)
def test_the_tip_follows_a_gentle_circle(scheme, across, bound):
    moved = session(circle(across), 20.0, scheme)
    assert np.ptp(moved.tip[:, 1 if across else 2]) > 1.5 * RADIUS  # m: it went round
    assert rms_mm(moved) < bound
    assert np.linalg.norm(moved.tip_error()[-1]) < 1.2e-3 * bound


@TIP_SCHEMES
def test_it_tracks_the_thesis_input_as_the_c180_does(scheme):
    levers = session(lambda time: Operator(thesis_levers(time, TIP_SPEED)), 10.0, scheme)
    assert rms_mm(levers) < 90.0


def test_joint_levers_give_the_joint_rates_that_they_ask_for():
    asked = controller_settings.Settings().joint_rates
    for axis in range(3):
        for sign in (1.0, -1.0):
            levers = Levers(*(0.5 * sign if i == axis else 0.0 for i in range(3)))
            moved = session(lambda _, levers=levers: Operator(levers), 2.0, Scheme.JOINT)
            rate = (moved.angles[-1] - moved.angles[200]) / (0.005 * (len(moved.angles) - 201))
            expected = np.zeros(3)
            expected[axis] = 0.5 * sign * asked[axis]
            np.testing.assert_allclose(rate, expected, atol=0.12 * abs(expected[axis]))


@pytest.mark.parametrize("scheme", list(Scheme))
def test_no_lever_motion_takes_a_joint_over_its_limit(scheme):
    rng = np.random.default_rng(4)
    times = np.cumsum(rng.uniform(0.05, 4.0, 40))
    values = np.clip(rng.normal(0.0, 1.2, (41, 3)), -1.0, 1.0) * (rng.random((41, 1)) > 0.2)
    wild = session(
        lambda time: Operator(Levers(*values[np.searchsorted(times, time)].tolist())), 40.0, scheme
    )
    assert np.all(margins(wild) > 0.0)


@pytest.mark.parametrize("scheme", list(Scheme))
def test_releasing_the_deadman_shuts_the_valves_and_stops_the_tip(scheme):
    moved = session(lambda time: Operator(Levers(1.0, 0.5, -0.5), enabled=time < 1.5), 6.0, scheme)
    assert not moved.voltages[300 + 50 :].any()  # a quarter of a second later
    assert np.ptp(moved.tip[-100:], axis=0).max() < 0.01
