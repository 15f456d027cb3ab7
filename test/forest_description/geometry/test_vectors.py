"""The arithmetic of triples is numpy's, for any triples."""

import numpy as np
from hypothesis import given
from properties import between, vectors

from forest_description.geometry.vectors import dot, minus, norm, plus, scaled


@given(a=vectors(-1e3, 1e3), b=vectors(-1e3, 1e3), factor=between(-10.0, 10.0))
def test_sum_difference_multiple_product_and_length_are_those_of_numpy(a, b, factor):
    x, y = np.array(a), np.array(b)
    assert plus(a, b) == tuple(x + y)
    assert minus(a, b) == tuple(x - y)
    assert scaled(a, factor) == tuple(factor * x)
    np.testing.assert_allclose(dot(a, b), x @ y, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(norm(a), np.linalg.norm(x), rtol=1e-12)
