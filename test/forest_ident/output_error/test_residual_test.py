"""Residuals are tested at the rate of their sensor."""

import numpy as np
import pytest

from forest_ident.output_error.residual_test import autocorrelation


def coloured(count=4000, share=0.7):
    """Return noise whose neighbours are correlated."""
    white, noise = np.random.default_rng(3).normal(size=count), np.zeros(count)
    for k in range(1, count):
        noise[k] = share * noise[k - 1] + white[k]
    return noise


@pytest.mark.parametrize("every", [1, 2, 5])
def test_a_slow_sensor_shows_its_correlation_at_lag_1(every):
    residual = np.full(every * 4000, np.nan)
    residual[::every] = coloured()
    found = autocorrelation(residual)
    assert found[0] == pytest.approx(0.7, abs=0.04)
    assert found[1] == pytest.approx(0.49, abs=0.05)


def test_white_residuals_show_none():
    assert np.max(np.abs(autocorrelation(np.random.default_rng(1).normal(size=4000)))) < 0.06


def test_too_few_rows_are_no_test():
    assert autocorrelation(np.full(4000, np.nan)) is None
