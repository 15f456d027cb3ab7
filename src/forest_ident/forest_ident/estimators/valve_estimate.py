"""The valve's characteristic C_R(V) from voltage, pressures and flow at rest. Thesis section 4.3.2.

| symbol | name | unit |
|---|---|---|
| V | voltage | V |
| V_d, V_r | edge of the overlap, rated voltage | V |
| C_R | orifice resistance, C_Rmin at V_r | Pa s^2/m^6 |
| u | opening, sqrt(C_Rmin/C_R) | 1 |
| dP_1, dP_2 | pressure drop over the edge of port 1, of port 2 | Pa |
| Q | flow through both, from port 1 to port 2 positive | m^3/s |

Sign: V > 0 connects port 1 to the supply: dP_1 = P_s - p_1, dP_2 = p_2. V < 0 the reverse: dP_2 = P_s - p_2,
dP_1 = p_1.
"""

import dataclasses
import math
from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from forest_description.hydraulics.valve_parameters import BackwardValve, Valve
from forest_description.types import Floats
from forest_ident.measurements.readings import openings
from forest_ident.measurements.session import Session
from forest_ident.output_error import fit_problem, output_error

SETTLED = 0.3  # [s] after a change of voltage
KEYS = (
    "deadband_voltage",
    "minimum_resistance",
    "backward.deadband_voltage",
    "backward.minimum_resistance",
    "port_2_area",
)


class Points(NamedTuple):
    """The valve at rest at some voltages, each the mean over a hold."""

    voltage: Floats  # [n] V
    flow: Floats  # [n] m^3/s
    drop_1: Floats  # [n] Pa
    drop_2: Floats  # [n] Pa
    samples: Floats  # [n] in each mean


def holds(voltage: Floats, period: float, settled: float = SETTLED) -> list[slice]:
    """Return the rows of every hold of a voltage, without its first ``settled`` seconds."""
    edges = [0, *(np.flatnonzero(np.diff(voltage) != 0.0) + 1).tolist(), len(voltage)]
    skip = round(settled / period)
    pairs = pairwise(edges)
    return [slice(first + skip, last) for first, last in pairs if last - first > skip + 2]


def points(session: Session, highest: float = math.inf) -> Points:
    """Return the means over every hold of a session on the valve's rig. Thesis section 4.3.2.2.

    Args:
        session: on the rig.
        highest: of the meter [m^3/s]; a hold in which it reads that is left out.
    """
    voltage = session.voltages[:, 0]
    supply = session.column("supply_pressure")
    one, two = session.pressures("swing", "valve")
    flow, rows = session.column("swing_flow"), []
    for hold in holds(voltage, session.period):
        level = float(voltage[hold.start])
        if level == 0.0 or float(np.max(np.abs(flow[hold]))) >= highest:
            continue
        p_s, p_1, p_2, q = (float(np.mean(column[hold])) for column in (supply, one, two, flow))
        drops = (p_s - p_1, p_2) if level > 0.0 else (p_1, p_s - p_2)
        rows.append((level, q, *drops, float(hold.stop - hold.start)))
    table = np.array(rows).reshape(-1, 5)
    return Points(*table.T)


def resistance(point: Points, floor: float) -> Floats:
    """Return C_R = dP/(Q|Q|) [Pa s^2/m^6] of port 1's edge; NaN where the meter reads its floor.

    Thesis eq. 4.2a.
    """
    seen = np.abs(point.flow) > 1.02 * floor
    found = np.full(len(point.flow), math.nan)
    found[seen] = point.drop_1[seen] / point.flow[seen] ** 2
    return found


def polynomial(voltage: Floats, c_r: Floats, degree: int = 5) -> Floats:
    """Return the coefficients of C_R over |V|, lowest power first, fitted with relative weights.

    Thesis section 4.3.2.2. Differs: C_R spans four decades over the voltage; unweighted, as a curve-fitting
    routine takes it, only the voltages next to the overlap would count.
    """
    seen = np.isfinite(c_r)
    x, y = np.abs(voltage[seen]), c_r[seen]
    if len(x) <= degree:
        return np.full(degree + 1, math.nan)
    return np.asarray(np.polynomial.polynomial.polyfit(x, y, degree, w=1.0 / y), dtype=np.float64)


def flows(valve: Valve, point: Points) -> tuple[Floats, Floats]:
    """Return Q = sgn(V) u sqrt(dP/C_Rmin) [m^3/s] as the edges of port 1 and of port 2 have it.

    Thesis eq. 4.1, 4.2.
    """
    law, sign = valve.law, np.sign(point.voltage)
    u = np.where(
        sign > 0.0,
        openings(point.voltage, law.forward, law.curve),
        openings(-point.voltage, law.backward, law.curve),
    )
    c_1 = np.where(sign > 0.0, law.forward.resistance_1, law.backward.resistance_1)
    c_2 = np.where(sign > 0.0, law.forward.resistance_2, law.backward.resistance_2)
    one, two = (np.sqrt(np.maximum(drop, 0.0)) for drop in (point.drop_1, point.drop_2))
    return sign * u * one / np.sqrt(c_1), sign * u * two / np.sqrt(c_2)


def with_law(valve: Valve, values: Mapping[str, float]) -> Valve:
    """Return the valve with the law's numbers, by the names of `KEYS`."""
    return dataclasses.replace(
        valve,
        deadband_voltage=values["deadband_voltage"],
        minimum_resistance=values["minimum_resistance"],
        port_2_area=values["port_2_area"],
        backward=BackwardValve(values["backward.deadband_voltage"], values["backward.minimum_resistance"]),
    )


def law(point: Points, start: Valve, floor: float, noise: float) -> fit_problem.Fit:
    """Return overlap and C_Rmin of both directions and the ratio of the ports' areas.

    A maximum-likelihood fit of `flows` to the flow read. A reading at the meter's floor is censored: it only
    shows that the flow is below (Tobit). So neither the floor is taken for the overlap, nor the reverse.

    Thesis section 4.3.2.4. Differs: the thesis draws the floor as flow.

    Args:
        point: the valve at rest.
        start: whose rated voltage and curve hold, and where the search starts.
        floor: of the meter [m^3/s].
        noise: of one mean [m^3/s].
    """
    back = start.backward or BackwardValve(start.deadband_voltage, start.minimum_resistance)
    gain = _gain(point, start)
    starts = (start.deadband_voltage, gain, back.deadband_voltage, gain, start.port_2_area)
    unknowns = [
        fit_problem.Unknown(key, value, positive=not key.endswith("voltage"))
        for key, value in zip(KEYS, starts, strict=True)
    ]
    channels = [fit_problem.Channel(name, noise, floor=floor) for name in ("port 1", "port 2")]

    def model(values: Mapping[str, float]) -> dict[str, Floats]:
        one, two = flows(with_law(start, values), point)
        return {"port 1": one, "port 2": two}

    return output_error.fit(model, {"port 1": point.flow, "port 2": point.flow}, channels, unknowns, block=4)


def _gain(point: Points, start: Valve) -> float:
    """Return C_Rmin as the greatest openings have it, to start from."""
    far = np.abs(point.voltage) > 0.8 * start.rated_voltage
    if not far.any():
        return start.minimum_resistance
    return float(np.median(point.drop_1[far] / point.flow[far] ** 2))
