"""A valve's metering curve as its rig's record has it: measured points, and a monotone fit through them.

    u ~ |Q| / sqrt(dP_1),  s = (|V| - V_d)/(V_r - V_d)

| symbol | name | unit |
|---|---|---|
| V, V_d, V_r | voltage held, edge of the overlap, rated voltage | V |
| Q, dP_1 | flow, drop over port 1's edge, means over a hold | m^3/s, Pa |
| s, u | stroke, opening | 1 |

The overlaps are those that were told: a straight law would take a notch for overlap. Both directions are of
one shape, as in the machine file. The fit is isotonic least squares: the opening never
falls. Between the file's knots it is straight. Flows at the meter's floor are left out.
"""

from collections.abc import Sequence

import numpy as np
import scipy

from forest_description.hydraulics.valve_parameters import FlowCurve, Valve
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.estimators import valve_estimate
from forest_ident.measurements import sample_mask
from forest_ident.measurements.parameter_path import part_of, with_part
from forest_ident.measurements.session import Session
from forest_ident.refinement import linear_estimates

KNOTS = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)  # of the stroke: closer where notches bend the most
RISE = 1e-4  # of the full opening, by which one knot is above the last at least
FEWEST = 6  # points that make a curve
FLOW = 1e-3  # [m^3/s] at full opening: of a curve only its shape counts


def with_measured_curves(machine: Machine, sessions: Sequence[Session]) -> Machine:
    """Return a machine whose curves are those of the valve rigs' records; without a record they stay.

    Args:
        machine: whose valves have curves already, of any shape, and overlaps as stated.
        sessions: any.
    """
    for session in sessions:
        section = f"{session.own_axis}.valve" if session.own_axis else "valve"
        valve = part_of(machine, section)
        if session.kind == "valve" and valve is not None:
            stroke, opening = _points(machine, valve, session)
            if len(stroke) >= FEWEST:
                machine = with_part(machine, f"{section}.curve", _curve(valve, stroke, opening))
    return machine


def _points(machine: Machine, valve: Valve, session: Session) -> tuple[Floats, Floats]:
    """Return strokes, rising, and openings of the holds whose flow is above the meter's floor."""
    read = valve_estimate.points(session, linear_estimates.highest(machine, session))
    least = sample_mask.AT_FLOOR * linear_estimates.floor(machine, session)
    seen = (np.abs(read.flow) > least) & (read.drop_1 > 0.0)
    opening = np.abs(read.flow) / np.sqrt(np.where(seen, read.drop_1, 1.0))
    found = []
    for way, sign in ((valve.law.forward, 1.0), (valve.law.backward, -1.0)):
        stroke = (sign * read.voltage - way.deadband_voltage) / (way.rated_voltage - way.deadband_voltage)
        rows = np.flatnonzero(seen & (stroke > 0.0))
        rows = rows[np.argsort(stroke[rows])]
        if len(rows):
            found.append((stroke[rows], opening[rows]))
    if len(found) == 2:  # one direction may open wider: its curve is scaled to the other's
        (one, first), (two, second) = found
        found[1] = two, second * float(np.median(np.interp(two, one, first) / second))
    strokes, openings = (
        np.concatenate([np.zeros(0), *columns])
        for columns in zip(*(found or [(np.zeros(0), np.zeros(0))]), strict=True)
    )
    order = np.argsort(strokes)
    return strokes[order], openings[order]


def _curve(valve: Valve, stroke: Floats, opening: Floats) -> FlowCurve:
    rising = scipy.optimize.isotonic_regression(opening).x
    at = np.interp(KNOTS, np.append(0.0, stroke), np.append(0.0, rising))
    at = np.maximum.accumulate(at / at[-1] + RISE * np.arange(1, len(at) + 1))
    law = valve.law
    edge = max(law.forward.deadband_voltage, law.backward.deadband_voltage)
    volts = [edge + s * (valve.rated_voltage - edge) for s in KNOTS[:-1]]
    return FlowCurve((*volts, valve.rated_voltage), tuple((FLOW * at / at[-1]).tolist()))
