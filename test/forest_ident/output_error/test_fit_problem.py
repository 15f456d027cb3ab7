"""A channel's noise is that of the readings which a bound of the sensor does not hide."""

import numpy as np
import pytest

from forest_ident.output_error.fit_problem import Channel, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import EMPTY

NOISE = 0.01


def noise(channel, reading, residual):
    problem = Problem({"q": np.array(reading) + residual}, [channel], [], 200, EMPTY)
    problem.update_noise(np.zeros(problem.count), {"q": np.array(reading)})
    return problem.sigma["q"]


def test_next_to_a_floor_either_way_and_next_to_zero_readings_do_not_count():
    """Next to it is within four times the sensor's own noise."""
    far, near = [1.0, -1.0] * 50, [0.539, -0.539] * 50
    residual = np.r_[np.full(100, 0.1), np.full(100, 0.4)] * np.sign(far + near)
    assert noise(Channel("q", NOISE, floor=0.5), far + near, residual) == pytest.approx(0.1)
    over = [1.0, -1.0] * 50 + [0.541, -0.541] * 50
    both = np.sqrt((0.1**2 + 0.4**2) / 2.0)
    assert noise(Channel("q", NOISE, floor=0.5), over, residual) == pytest.approx(both)
    up, low = np.r_[np.full(100, 0.1), np.full(100, 0.4)], [1.0] * 100
    assert noise(Channel("q", NOISE, zero=True), low + [0.039] * 100, up) == pytest.approx(0.1)
    assert noise(Channel("q", NOISE, zero=True), low + [0.041] * 100, up) == pytest.approx(both)
    assert noise(Channel("q", NOISE), low + [0.0] * 100, up) == pytest.approx(both)


def test_noise_is_never_less_than_the_sensors_and_of_too_few_rows_it_stays():
    assert noise(Channel("q", NOISE), np.ones(100), np.full(100, 0.001)) == NOISE
    assert noise(Channel("q", NOISE, zero=True), np.r_[np.ones(2), np.zeros(198)], np.full(200, 0.1)) == NOISE
    seen = np.r_[np.ones(3), np.zeros(197)]
    assert noise(Channel("q", NOISE, zero=True), seen, np.full(200, 0.1)) == pytest.approx(0.1)
    assert noise(Channel("q", NOISE, high=0.5), np.ones(100), np.full(100, 0.1)) == NOISE


def test_a_static_error_is_added_to_what_is_predicted_within_its_accuracy():
    channels = [Channel("p", 1.0, offset=5.0, run="valve"), Channel("q", 1.0, gain=0.1), Channel("r", 1.0)]
    y = {name: np.zeros(3) for name in "pqr"}
    unknowns = [Unknown("a", 2.0, 0.5, True), Unknown("b", -3.0, np.inf, False)]
    problem = Problem(y, channels, unknowns, 200, EMPTY)
    assert problem.names == ("a", "b", "p.b.valve", "q.g")
    assert [*problem.lasting] == [True, True, False, True]
    assert problem.mean == pytest.approx([np.log(2.0), -3.0, 0.0, 0.0])
    assert np.diag(problem.known) == pytest.approx([4.0, 0.0, 0.04, 100.0])
    assert [*problem.reach] == [0.5, *[np.inf] * 3]
    theta = np.array([np.log(7.0), 8.0, 0.25, 0.5])
    assert problem.values(theta) == pytest.approx({"a": 7.0, "b": 8.0})
    read = [problem.reading(theta, name, np.array([2.0]))[0] for name in "pqr"]
    assert read == pytest.approx([2.25, 3.0, 2.0])
