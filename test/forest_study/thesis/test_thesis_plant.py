"""Claims about the linear plant of the thesis' evaluation and its integration."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forest_control.operator.joystick_sources import thesis_tip_velocity
from forest_description.derived.limits import THESIS_START
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_study.thesis.thesis_plant import DRIVE, INSIDE, Control, State, at_rest, rate_change, simulate
from forest_study.thesis.thesis_schemes import SCHEMES, servo

W_N = 2.0 * math.pi * 2.0
ZERO = (0.0, 0.0, 0.0)
JUMPS = (0.0, 1.0, 2.5, 4.0, 5.5, 10.0)  # [s] of the thesis' wish


@pytest.fixture(scope="module")
def links():
    return load_machine("c180_thesis").manipulator.links


def test_plant_settles_at_its_gain_whose_error_is_that_of_its_natural_frequency():
    rates = (0.1, -0.2, 0.3)
    drive = tuple(DRIVE * v for v in rates)
    assert rate_change(rates, drive, DRIVE) == pytest.approx(ZERO, abs=1e-15)
    settled = tuple(v / 1.2 for v in rates)
    assert rate_change(settled, drive, 1.2 * DRIVE) == pytest.approx(ZERO, abs=1e-15)


def test_a_free_joint_coasts_with_its_natural_frequency(links):
    start = at_rest(THESIS_START, links)._replace(rates=(0.2, 0.0, 0.0))
    run = simulate(lambda *_: Control(ZERO, ZERO), W_N, start, links, 1.0, lambda _: ZERO)
    turned = np.arctan2(run.position[:, 1], run.position[:, 0])
    assert turned == pytest.approx(0.2 / W_N * (1.0 - np.exp(-W_N * run.time)), abs=1e-7)


def test_the_wish_is_integrated_exactly_over_its_jumps(links):
    gains = servo(W_N, 16.5)
    start = at_rest(THESIS_START, links)
    run = simulate(SCHEMES["c"](gains, links), W_N, start, links, 10.0)
    assert run.wished_position[-1, [0, 2]] - run.wished_position[0, [0, 2]] == pytest.approx([0.9, 0.75])
    w = 2.0 * math.pi * 1.18
    assert run.wished_position[:, 1] == pytest.approx(0.47 / w * (1.0 - np.cos(w * run.time)), abs=1e-6)
    assert run.wished_velocity[200, 0] == 0.30
    assert run.wished_velocity[199, 0] == 0.0


@pytest.mark.parametrize("name", ["a", "d"])
def test_integration_agrees_with_an_adaptive_one(name, links):
    scheme = SCHEMES[name](servo(W_N, 16.5), links)
    start = at_rest(THESIS_START, links)

    def slope(time, y):
        wished = thesis_tip_velocity(time)
        state = State(*(tuple(part) for part in y.reshape(6, 3).tolist()))
        control = scheme(state, wished)
        change = rate_change(state.rates, control.drive, 0.8 * W_N)
        parts = state.rates, change, control.reference_rates, wished, control.ramp, control.integral_rates
        return np.concatenate(parts)

    y = np.concatenate(start)
    run = simulate(scheme, 0.8 * W_N, start, links, 6.0)
    for begin, end in zip(JUMPS, (*JUMPS[1:-1], 6.0), strict=False):
        y = solve_ivp(slope, (begin + INSIDE, end - INSIDE), y, "DOP853", rtol=1e-9, atol=1e-11).y[:, -1]
        row = round(end / 0.005)
        assert run.position[row] == pytest.approx(tip_position(tuple(y[:3].tolist()), links), abs=1e-5)
