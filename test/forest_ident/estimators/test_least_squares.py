import numpy as np
import pytest

from forest_ident.estimators.least_squares import solve
from forest_ident.measurements.differentiator import derivative, inner, smooth, width


def test_coefficients_and_their_spread_are_found():
    generator = np.random.default_rng(2)
    x = generator.uniform(-1.0, 1.0, 20_000)
    found = []
    for _ in range(100):
        y = 3.0 * x + 0.5 + generator.normal(0.0, 0.2, len(x))
        line = solve([x, np.ones(len(x))], y)
        found.append((line.values[0], line.errors[0]))
    values, errors = np.array(found).T
    assert np.mean(values) == pytest.approx(3.0, abs=0.002)
    assert np.mean(errors) == pytest.approx(np.std(values), rel=0.2)


def test_the_standard_error_knows_that_residuals_hang_together():
    generator = np.random.default_rng(3)
    noise = np.repeat(generator.normal(0.0, 1.0, 200), 100)
    line = solve([np.ones(len(noise))], noise, block=100)
    assert line.errors[0] == pytest.approx(1.0 / np.sqrt(200.0), rel=0.15)


def test_columns_that_are_alike_raise_the_condition_number():
    x = np.linspace(0.0, 1.0, 100)
    assert solve([x, x + 1e-6 * x**2], x).condition > 1e5
    assert solve([x, 1.0 - x], x).condition < 3.0


def test_a_derivative_has_no_phase_and_the_stated_bandwidth():
    period, frequency = 0.005, 2.0
    time = period * np.arange(2000)
    wave = np.sin(2.0 * np.pi * frequency * time)
    rows = inner(len(time), 10.0, period)
    left = np.exp(-0.5 * (2.0 * np.pi * frequency * width(10.0, period) * period) ** 2)
    rate = 2.0 * np.pi * frequency * np.cos(2.0 * np.pi * frequency * time)
    assert derivative(wave, 10.0, period)[rows] == pytest.approx(left * rate[rows], abs=2e-3)
    edge = np.sin(2.0 * np.pi * 10.0 * time)
    assert np.max(smooth(edge, 10.0, period)[rows]) == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_a_bandwidth_beyond_the_samples_is_refused():
    with pytest.raises(ValueError, match="allowed: above 0 up to 25 Hz"):
        width(30.0, 0.005)
