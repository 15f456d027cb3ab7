"""Recursive least squares with forgetting: running estimates while the machine works.

The on-line column of Thesis table 4.1: little memory, an approximate answer at any time. The off-line fit on
the same record is the better one; this one shows in the cab that something changes.

| symbol | name |
|---|---|
| x, y | regressor and measured value of one sample, y = x theta + e |
| theta, P | estimate; its covariance over the noise's variance |
| lambda | forgetting: what a sample counts one time constant T later is 1/e, lambda = exp(-dt/T) |
| s2 | variance of e, by the same forgetting |

    k = P x/(lambda + x P x),  theta += k (y - x theta),  P = (P - k x P)/lambda

P is kept below a bound, because without motion forgetting would let it grow for ever.

What is estimated of an axis, from its own pressures and speed, as (4.11) and (3.1) have it:

    drive:  A_1 p_1 - A_2 p_2 - G(q)/J = B v + c                       damping B
    valve:  v A/sqrt(dp) = k V - k V_d (V > V_d + margin)              gain k, overlap V_d by direction
"""

import math
from typing import NamedTuple

from forest_description.types import Vec3

Pair = tuple[float, float]

GREATEST = 1e8  # of P's diagonal


class Estimator(NamedTuple):
    """A running fit of two coefficients."""

    theta: Pair
    covariance: Vec3  # P_11, P_12, P_22
    variance: float  # s2
    weight: float  # of the samples until now, after forgetting


def start(theta: Pair, spread: Pair) -> Estimator:
    """Return an estimator that knows its coefficients within a spread, in units of the noise."""
    return Estimator(theta, (spread[0] ** 2, 0.0, spread[1] ** 2), 0.0, 0.0)


def step(e: Estimator, x: Pair, y: float, dt: float, memory: float) -> Estimator:
    """Return the estimator after a sample; one that is not finite leaves it as it is.

    Args:
        e: until now.
        x: regressor.
        y: measured.
        dt: since the last sample that counted [s].
        memory: T [s].
    """
    if not (math.isfinite(x[0]) and math.isfinite(x[1]) and math.isfinite(y)):
        return e
    forgetting = math.exp(-dt / memory)
    p_11, p_12, p_22 = e.covariance
    u, v = p_11 * x[0] + p_12 * x[1], p_12 * x[0] + p_22 * x[1]
    denominator = forgetting + x[0] * u + x[1] * v
    k_1, k_2 = u / denominator, v / denominator
    error = y - x[0] * e.theta[0] - x[1] * e.theta[1]
    theta = (e.theta[0] + k_1 * error, e.theta[1] + k_2 * error)
    after = (p_11 - k_1 * u) / forgetting, (p_12 - k_1 * v) / forgetting, (p_22 - k_2 * v) / forgetting
    weight = forgetting * e.weight + 1.0
    # A priori and a posteriori error together: unbiased for white noise.
    variance = e.variance + (error * error * forgetting / denominator - e.variance) / weight
    return Estimator(theta, _bounded(after), variance, weight)


def spread(e: Estimator) -> Pair:
    """Return the standard errors of both coefficients."""
    p_11, _, p_22 = e.covariance
    return math.sqrt(max(e.variance * p_11, 0.0)), math.sqrt(max(e.variance * p_22, 0.0))


def _bounded(p: Vec3) -> Vec3:
    largest = max(p[0], p[2])
    if largest <= GREATEST:
        return p
    scale = GREATEST / largest
    return p[0] * scale, p[1] * scale, p[2] * scale
