"""Derivatives of sampled signals without phase error, and without more noise than a bandwidth lets through.

A signal is smoothed with a Gaussian g and differentiated by convolution with g' and g''. All
terms of an equation get the same Gaussian. Smoothing and differentiation commute: so the equation holds for
the smoothed signals exactly, and no phase lies between its terms.

| symbol | name | unit |
|---|---|---|
| f_b | bandwidth: there the smoothing leaves 1/sqrt(2) | Hz |
| s | width of the Gaussian, sqrt(ln 2)/(2 pi f_b) | s |
"""

import math

import numpy as np
import scipy

from forest_description.types import Floats

REACH = 6.0  # widths to either side at which the Gaussian is cut off


def width(bandwidth: float, period: float) -> float:
    """Return s in samples. Thesis section 4.3.6 differentiates resolver readings twice, it does not say how.

    Args:
        bandwidth: f_b [Hz].
        period: between samples [s].

    Raises:
        ValueError: f_b is above an eighth of the sampling rate, where the sampled Gaussian is none.
    """
    if not 0.0 < bandwidth <= 0.125 / period:
        raise ValueError(f"bandwidth {bandwidth:g} Hz; allowed: above 0 up to {0.125 / period:g} Hz")
    return math.sqrt(math.log(2.0)) / (2.0 * math.pi * bandwidth) / period


def smooth(signal: Floats, bandwidth: float, period: float) -> Floats:
    """Return the signal smoothed [its unit]; arguments as `derivative`."""
    return derivative(signal, bandwidth, period, 0)


def derivative(signal: Floats, bandwidth: float, period: float, order: int = 1) -> Floats:
    """Return the smoothed signal's derivative [unit/s^order].

    Args:
        signal: samples, N.
        bandwidth: f_b [Hz].
        period: between samples [s].
        order: 0, 1 or 2.
    """
    sigma = width(bandwidth, period)
    result = scipy.ndimage.gaussian_filter1d(signal, sigma, order=order, mode="nearest", truncate=REACH)
    return np.asarray(result / period**order, dtype=np.float64)


def inner(count: int, bandwidth: float, period: float) -> slice:
    """Return the rows that the ends of a record do not touch."""
    edge = math.ceil(REACH * width(bandwidth, period))
    return slice(edge, max(edge, count - edge))
