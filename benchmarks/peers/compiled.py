"""The peers' right-hand side and its Jacobian, compiled by Numba.

The numbers of `equations` become constants of the compiled code, and Numba's cache would not notice that they
have changed: whoever imports this module sets NUMBA_CACHE_DIR to a folder of its own (`plant.py` does).
"""

import math

import numba
import numpy as np

from peers import equations
from work import Floats

_valve = numba.njit(inline="always")(equations.valve)
_rates = numba.njit(equations.make_rates(math.sin, math.cos, math.sqrt, abs, _valve))
STATES = 18
DIFFERENCE = 1e-7


@numba.njit(cache=True, error_model="numpy")
def fill(t: float, y: Floats, wave: Floats, out: Floats) -> None:
    """Write dy/dt to `out`; `wave` is `work.Segment.wave`."""
    v1 = wave[0] + wave[1] * math.sin(wave[2] * t + wave[3])
    v2 = wave[4] + wave[5] * math.sin(wave[6] * t + wave[7])
    v3 = wave[8] + wave[9] * math.sin(wave[10] * t + wave[11])
    d = _rates(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], y[8], y[9], y[10], y[11],
        y[12], y[13], y[14], y[15], y[16], y[17], v1, v2, v3,
    )  # fmt: skip
    for k in range(STATES):
        out[k] = d[k]


@numba.njit(cache=True)
def right_hand_side(t: float, y: Floats, wave: Floats) -> Floats:
    """Return dy/dt."""
    out = np.empty(STATES)
    fill(t, y, wave, out)
    return out


@numba.njit(cache=True)
def jacobian(t: float, y: Floats, wave: Floats) -> Floats:
    """Return d(dy/dt)/dy, shape (18, 18), by forward differences."""
    matrix, shifted = np.empty((STATES, STATES)), y.copy()
    start, moved = np.empty(STATES), np.empty(STATES)
    fill(t, y, wave, start)
    for k in range(STATES):
        step = DIFFERENCE * max(1e-3, abs(y[k]))
        shifted[k] = y[k] + step
        fill(t, shifted, wave, moved)
        for i in range(STATES):
            matrix[i, k] = (moved[i] - start[i]) / step
        shifted[k] = y[k]
    return matrix
