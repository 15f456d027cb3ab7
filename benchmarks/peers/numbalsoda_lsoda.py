"""numbalsoda: LSODA in C++ on a right-hand side compiled by Numba, the loop over segments compiled, too.

It takes no Jacobian; its own differences give one.
"""

import time
from collections.abc import Callable

import numba
import numpy as np
from numbalsoda import lsoda, lsoda_sig

from peers import Run
from peers.compiled import STATES, fill
from peers.equations import SCALE, SHUT_OPENING, deadband, per_volt
from work import SAMPLE, Floats, Work


@numba.cfunc(lsoda_sig, cache=True)
def _right_hand_side(t, y, out, wave):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    fill(t, numba.carray(y, (STATES,)), numba.carray(wave, (12,)), numba.carray(out, (STATES,)))


@numba.njit
def _integrate(address, ends, waves, states, tolerance):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Fill `states`, of which the first row is given; return whether all went well."""
    good = True
    for s in range(len(waves)):
        first, last, wave = ends[s, 0], ends[s, 1], waves[s]
        y = states[first].copy()
        for axis in range(3):
            mean, amplitude, omega, phase = wave[4 * axis : 4 * axis + 4]
            voltage = mean + amplitude * np.sin(omega * first * SAMPLE + phase)
            if (abs(voltage) - deadband) * per_volt < SHUT_OPENING:
                y[6 * axis + 4] = y[6 * axis + 5] = 0.0
        times = np.arange(first, last + 1) * SAMPLE
        result, success = lsoda(address, y, times, wave, tolerance, tolerance, 100_000)
        states[first + 1 : last + 1] = result[1:]
        good = good and success
    return good


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""
    ends = np.array([(s.first, s.last) for s in work.segments])
    waves = np.array([s.wave for s in work.segments])

    def integrate() -> Run:
        states = np.empty((work.samples + 1, STATES))
        states[0] = start / SCALE
        began = time.process_time()
        good = _integrate(_right_hand_side.address, ends, waves, states, tolerance)
        cpu = time.process_time() - began
        if not good:
            raise RuntimeError("numbalsoda gave up")
        return Run(states * SCALE, cpu)

    return integrate
