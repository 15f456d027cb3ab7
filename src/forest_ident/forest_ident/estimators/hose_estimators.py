"""Estimate a hose: resistance from steady flows, inertance and capacitance from changing ones.

Thesis section 4.3.3, 4.3.4.

| symbol | name | unit |
|---|---|---|
| dP | pressure at the entrance less that at the exit | Pa |
| Q | steady flow | m^3/s |
| R | resistance of dP = R Q|Q| (turbulent), dP = R Q (laminar) | Pa s^2/m^6, Pa s/m^3 |
| P_in, P_out | pressure at the entrance, at the exit | Pa |
| P_c | pressure in the capacitance, P_out + R Q_2|Q_2| (laminar: + R Q_2) | Pa |
| Q_1, Q_2 | flow at the entrance, at the exit | m^3/s |
| I, C | inertance; capacitance | Pa s^2/m^3; m^3/Pa |

    P_in - P_c = I dQ_1/dt,  Q_1 - Q_2 = C dP_c/dt

The meters lag, the transducers do not: left as it is, that phase makes negative values (Thesis section
4.3.4.4). Here the pressures are sent through the meters' lag first, so that both sides have it.

P_in bends at once when the spool sets off, which it does at a sample. A smoothing sum over samples of spacing
h misses h^2/12 times the jump of the slope there; at 200 Hz that made I 3 to 9 % too low. So the jump is read
off the samples to either side and put right (Euler and Maclaurin's formula).
"""

import math

import numpy as np

from forest_description.types import Floats
from forest_ident.estimators.least_squares import LinearFit, solve
from forest_ident.estimators.valve_estimate import holds
from forest_ident.measurements.differentiator import derivative, inner, smooth
from forest_ident.measurements.readings import lagged
from forest_ident.measurements.session import Session

STEADY = 0.8  # [s] after which flow dynamics have died out
BANDWIDTH = 16.0  # [Hz] of the smoothing
RATES = 0.08  # of the sampling rate: the greatest bandwidth in a record that is sampled slower than at 200 Hz
GROUPS = 4


def steady(session: Session, floor: float, highest: float = math.inf) -> tuple[Floats, Floats]:
    """Return (Q, dP) of every hold of a session on the hose's rig, means, within the meter's range.

    Thesis section 4.3.3.2: no data while inertance and capacitance are at work.
    """
    entrance, leaving = (session.column(f"swing_pressure_1_{place}") for place in ("valve", "actuator"))
    flow, found = session.column("swing_flow"), []
    for rows in holds(session.voltages[:, 0], session.period, STEADY):
        q = float(np.mean(flow[rows]))
        if abs(q) > 1.02 * floor and float(np.max(np.abs(flow[rows]))) < highest:
            found.append((q, float(np.mean(entrance[rows] - leaving[rows]))))
    table = np.array(found).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def resistance(flow: Floats, drop: Floats, laminar: bool) -> LinearFit:
    """Return R and the transducers' difference at rest [Pa]: dP = R Q|Q| + e (laminar: R Q + e).

    Thesis eq. 4.4. Differs: two transducers that are off by e would put e into R.
    """
    return solve([flow if laminar else flow * np.abs(flow), np.ones(len(flow))], drop, block=1)


def four_group_means(session: Session, resistance: float, laminar: bool) -> tuple[Floats, Floats]:
    """Return I and C of four groups of data, each the mean of the quotients of its samples.

    I = (P_in - P_c)/(dQ_1/dt), C = (Q_1 - Q_2)/(dP_c/dt), over the samples where the divisor is more than a
    fifth of its greatest. The phase between meters and transducers is in them, as it is in the thesis'.

    Thesis eq. 4.5a, 4.6, section 4.3.4.4.
    """
    drop, flow_rate, difference, pressure_rate, rows = terms(session, resistance, laminar, lag=0.0)
    groups = np.array_split(np.arange(len(session.time))[rows], GROUPS)
    inertances = [_mean_quotient(drop[g], flow_rate[g]) for g in groups]
    capacitances = [_mean_quotient(difference[g], pressure_rate[g]) for g in groups]
    return np.array(inertances), np.array(capacitances)


def joint(
    session: Session,
    resistance: float,
    laminar: bool,
    lag: float,
    floor: float,
    highest: float = math.inf,
) -> tuple[LinearFit, LinearFit]:
    """Return I and C by least squares, with all terms in phase. Thesis eq. 4.5a, 4.6.

    Differs: the thesis averages quotients that the phase biases.

    Args:
        session: on the hose's rig.
        resistance: R of the hose.
        laminar: which law it is of.
        lag: time constant of the meters [s].
        floor: of the meters [m^3/s]; what reads as the floor, and a quarter second around it, is left out.
        highest: of the meters [m^3/s]; likewise.
    """
    drop, flow_rate, difference, pressure_rate, rows = terms(session, resistance, laminar, lag)
    seen = np.zeros(len(drop), dtype=bool)
    seen[rows] = True
    sizes = [np.abs(session.column(name)) for name in ("swing_flow", "stick_flow")]
    low = np.any([(size <= 1.02 * floor) | (size >= highest) for size in sizes], axis=0)
    around = max(1, round(0.25 / session.period))
    seen &= np.convolve(low, np.ones(2 * around + 1), mode="same") < 0.5
    ones = np.ones(int(seen.sum()))
    return (
        solve([flow_rate[seen], ones], drop[seen]),
        solve([pressure_rate[seen], ones], difference[seen]),
    )


def terms(
    session: Session, resistance: float, laminar: bool, lag: float
) -> tuple[Floats, Floats, Floats, Floats, slice]:
    """Return smoothed P_in - P_c, dQ_1/dt, Q_1 - Q_2, dP_c/dt, and the rows that hold."""
    period = session.period
    entrance, leaving = (session.column(f"swing_pressure_1_{place}") for place in ("valve", "actuator"))
    p_in = lagged(unbent(entrance, session.voltages[:, 0]), lag, period)
    p_out = lagged(leaving, lag, period)
    q_1, q_2 = session.column("swing_flow"), session.column("stick_flow")
    p_c = p_out + resistance * (q_2 if laminar else q_2 * np.abs(q_2))
    bandwidth = min(BANDWIDTH, RATES / period)
    return (
        smooth(p_in - p_c, bandwidth, period),
        derivative(q_1, bandwidth, period),
        smooth(q_1 - q_2, bandwidth, period),
        derivative(p_c, bandwidth, period),
        inner(len(q_1), bandwidth, period),
    )


def unbent(column: Floats, voltage: Floats) -> Floats:
    """Return a column whose samples at changes of the voltage make up for its bends there.

    A sample gets h/12 (f'_after - f'_before), by differences to the three samples on either side.

    Args:
        column: sampled with spacing h.
        voltage: held from each row on.
    """
    found, bends = column.copy(), np.flatnonzero(np.diff(voltage)) + 1
    n = bends[(bends >= 3) & (bends < len(column) - 3)]
    after, before = (
        -11.0 * column[n] + 18.0 * column[n + way] - 9.0 * column[n + 2 * way] + 2.0 * column[n + 3 * way]
        for way in (1, -1)
    )
    found[n] += (after + before) / 72.0
    return found


def _mean_quotient(dividend: Floats, divisor: Floats) -> float:
    large = np.abs(divisor) > 0.2 * np.max(np.abs(divisor))
    return float(np.mean(dividend[large] / divisor[large])) if large.any() else float("nan")
