"""Intervals from segments: they hold where residuals hang together, and do not trust a lonely segment."""

import numpy as np
import pytest

from forest_ident.everyday import clusters

ROWS, SEGMENTS = 50, 40


def normal(generator, together, sizes=(1.0,) * SEGMENTS):
    """Give what segments tell of the mean of their rows, whose errors hang together within each."""
    errors = [
        together * generator.standard_normal() + generator.standard_normal(ROWS) for _ in range(len(sizes))
    ]
    mean = np.average([np.mean(one) for one in errors], weights=np.square(sizes))
    information = np.array([[[ROWS * size**2]] for size in sizes])
    gradient = np.array(
        [[ROWS * size**2 * (mean - np.mean(one))] for one, size in zip(errors, sizes, strict=True)]
    )
    return mean, clusters.Normal(information, gradient)


@pytest.mark.parametrize("together", [0.0, 1.0])
def test_intervals_of_correlated_residuals_hold_the_truth(together):
    generator, held = np.random.default_rng(5), []
    for _ in range(300):
        mean, told = normal(generator, together)
        held.append(abs(mean) <= 1.96 * clusters.errors(told, np.zeros((1, 1)), np.zeros(1))[0])
    assert 0.92 < np.mean(held) < 0.98


def test_what_no_segment_tells_keeps_its_prior():
    told = clusters.Normal(np.full((8, 1, 1), 1e-9), np.zeros((8, 1)))
    errors = clusters.errors(told, np.array([[1.0 / 0.4**2]]), np.zeros(1))
    assert errors[0] == pytest.approx(0.4 * 1.21, rel=0.01)  # Student's of 7 degrees of freedom


def test_a_search_that_stopped_short_is_told():
    told = clusters.Normal(np.full((8, 1, 1), 100.0), np.full((8, 1), 100.0))
    errors = clusters.errors(told, np.zeros((1, 1)), np.zeros(1))
    assert errors[0] == pytest.approx(1.21, rel=0.01)  # 800/800 is the step that was not taken


def test_a_lonely_segment_is_not_believed():
    sizes = (10.0, *(0.1,) * 20)
    _, told = normal(np.random.default_rng(1), 1.0, sizes)
    alone = clusters.errors(told, np.zeros((1, 1)), np.zeros(1))[0]
    assert alone > 1.0  # the errors of one segment; white residuals would say 0.014
