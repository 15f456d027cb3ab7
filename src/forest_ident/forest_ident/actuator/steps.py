"""The actuator of `model` through time: a step that is implicit in the pressures, and a whole run.

| symbol | name |
|---|---|
| h | length of a step [n] |
| A | slopes of the pressures' rates by the pressures themselves, negative, nothing else [1/n] |

Rosenbrock's W-method of second order, with gamma = 1 - 1/sqrt(2):

    (1 - gamma h A) k_1 = f(y),   (1 - gamma h A) k_2 = f(y + h k_1) - 2 k_1,   y + h (3 k_1 + k_2)/2

Its order does not depend on A, its stability does: an edge that opens wide on a small chamber would need
steps of a hundredth of a sample otherwise, and would settle at wrong pressures with longer ones.
Everything here, too, is in the subset that `forest_compile.frontend` turns into machine code.
"""

import math
from collections.abc import MutableSequence, Sequence

from forest_ident.actuator.model import (
    CHECK_CONDUCTANCE,
    SMOOTH_DROP,
    Parameters,
    State,
    at_rest,
    rate,
    sensed_pressure,
)

SUBSTEPS = 12  # to a sample
GAMMA = 1.0 - 1.0 / math.sqrt(2.0)  # of the integrator, for which it damps what is stiff
RUNAWAY = 500.0  # [P] pressure at which a simulation is given up


def moved(state: State, by: State, time: float) -> State:
    """Return state + time by."""
    return State(
        spool=state.spool + time * by.spool,
        supply=state.supply + time * by.supply,
        pressure_1=state.pressure_1 + time * by.pressure_1,
        pressure_2=state.pressure_2 + time * by.pressure_2,
        position=state.position + time * by.position,
        speed=state.speed + time * by.speed,
        arm_position=state.arm_position + time * by.arm_position,
        arm_speed=state.arm_speed + time * by.arm_speed,
        load_position=state.load_position + time * by.load_position,
        load_speed=state.load_speed + time * by.load_speed,
    )


def pressure_slopes(state: State, p: Parameters) -> tuple[float, float]:
    """Return about how fast each chamber's pressure would settle were nothing else to move [1/n].

    Only the implicit part of `step` sees this, and its order does not depend on it.
    """
    opening_1, opening_2 = state.spool - p.deadband_extend, -state.spool - p.deadband_retract
    slope_1, slope_2 = CHECK_CONDUCTANCE, CHECK_CONDUCTANCE
    if opening_1 > 0.0:
        slope_1 += edge_slope(p.meter_in_extend * opening_1, state.supply - state.pressure_1)
        slope_2 += edge_slope(p.meter_out_extend * opening_1, state.pressure_2)
    elif opening_2 > 0.0:
        slope_1 += edge_slope(p.meter_out_retract * opening_2, state.pressure_1)
        slope_2 += edge_slope(p.meter_in_retract * opening_2, state.supply - state.pressure_2)
    return slope_1 / p.capacitance_1, slope_2 / p.capacitance_2


def edge_slope(conductance: float, drop: float) -> float:
    """Return about dQ/dP of `edge` [X/(n P)]."""
    return conductance / math.sqrt(math.sqrt(drop * drop + SMOOTH_DROP * SMOOTH_DROP))


def settled(by: State, slopes: tuple[float, float], time: float) -> State:
    """Return (1 - time A)^-1 by, where A holds the pressures' slopes alone."""
    return by._replace(
        pressure_1=by.pressure_1 / (1.0 + time * slopes[0]),
        pressure_2=by.pressure_2 / (1.0 + time * slopes[1]),
    )


def step(state: State, before: float, after: float, h: float, p: Parameters) -> State:
    """Return the state a step h [n] later.

    Args:
        state: at the step's start.
        before: signal [V] there.
        after: at its end.
        h: length [n].
        p: the actuator.
    """
    slopes, implicit = pressure_slopes(state, p), GAMMA * h
    one = settled(rate(state, before, p), slopes, implicit)
    two = settled(moved(rate(moved(state, one, h), after, p), one, -2.0), slopes, implicit)
    return moved(moved(state, one, 1.5 * h), two, 0.5 * h)


def run(
    signal: Sequence[float],
    rows: int,
    substeps: int,
    p: Parameters,
    pressures: MutableSequence[float],
    positions: MutableSequence[float],
) -> int:
    """Simulate from rest; return how many rows were filled before the pressures ran away.

    Args:
        signal: u [V] at every substep, delayed already.
        rows: samples wanted.
        substeps: to a sample.
        p: the actuator.
        pressures: is given what the sensor reads [P].
        positions: is given x [X].
    """
    state, at, filled = at_rest(p), 0, 0
    for row in range(rows):
        pressures[row] = sensed_pressure(state, p)
        positions[row] = state.position
        for _ in range(substeps):
            state = step(state, signal[at], signal[at + 1], 1.0 / substeps, p)
            at += 1
        if not (abs(state.pressure_1) < RUNAWAY and abs(state.pressure_2) < RUNAWAY):
            break
        filled += 1
    return filled
