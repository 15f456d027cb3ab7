"""CasADi's CVODES on the symbolic equations, exact Jacobian, both compiled by gcc.

One call does all the work: the waves are CasADi's piecewise constant controls, at whose changes it restarts.
"""

import time
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from peers import Run
from peers.equations import (
    SCALE,
    SHUT_OPENING,
    SHUT_RATE,
    deadband,
    make_rates,
    per_volt,
    resistance,
    supply,
)
from work import SAMPLE, Floats, Work


def _valve(v: Any, p_1: Any, p_2: Any, q_1: Any, q_2: Any, push_1: float, push_2: float) -> tuple[Any, Any]:
    """`equations.valve` without branches."""
    opening = ca.fmin(1.0, (ca.fabs(v) - deadband) * per_volt)
    shut = opening < SHUT_OPENING
    drop = resistance / ca.fmax(opening, SHUT_OPENING) ** 2
    p_1, p_2 = ca.if_else(v > 0.0, supply, 0.0) - p_1, p_2 - ca.if_else(v > 0.0, 0.0, supply)
    return (
        ca.if_else(shut, -SHUT_RATE * q_1, push_1 * (p_1 - drop * q_1 * ca.fabs(q_1))),
        ca.if_else(shut, -SHUT_RATE * q_2, push_2 * (p_2 - drop * q_2 * ca.fabs(q_2))),
    )


def _equations() -> dict[str, Any]:
    t, x, u = ca.SX.sym("t"), ca.SX.sym("x", 18), ca.SX.sym("u", 12)
    v = [u[k] + u[k + 1] * ca.sin(u[k + 2] * t + u[k + 3]) for k in (0, 4, 8)]
    rates = make_rates(ca.sin, ca.cos, ca.sqrt, ca.fabs, _valve)
    return {"t": t, "x": x, "u": u, "ode": ca.vertcat(*rates(*ca.vertsplit(x), *v))}


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""
    options = {
        "reltol": tolerance,
        "abstol": tolerance,
        "max_num_steps": 10_000_000,
        "jit": True,
        "compiler": "shell",
        "jit_options": {"compiler": "gcc", "flags": ["-O3", "-march=native"]},
    }
    times = list(np.arange(1, work.samples + 1) * SAMPLE)
    plant = ca.integrator("plant", "cvodes", _equations(), 0.0, times, options)
    controls = np.empty((12, work.samples))
    for segment in work.segments:
        controls[:, segment.first : segment.last] = segment.wave[:, None]
    y = start / SCALE

    def integrate() -> Run:
        began = time.process_time()
        result = plant(x0=y, u=controls)["xf"]
        cpu = time.process_time() - began
        return Run(np.vstack([y, result.full().T]) * SCALE, cpu)

    return integrate
