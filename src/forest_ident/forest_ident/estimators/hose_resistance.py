"""The hose's resistance from steady flows. Thesis section 4.3.3.

| symbol | name | unit |
|---|---|---|
| dP | pressure at the entrance less that at the exit | Pa |
| Q | flow | m^3/s |
| R | resistance of dP = R Q|Q| (turbulent), dP = R Q (laminar) | Pa s^2/m^6, Pa s/m^3 |
"""

import math

import numpy as np

from forest_description.machine import MeasuredHose
from forest_description.types import Floats
from forest_ident.estimators.least_squares import LinearFit, solve
from forest_ident.estimators.valve_characteristic import holds
from forest_ident.measurements.session import Session

STEADY = 0.8  # [s] after which flow dynamics have died out


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


def scaled(hose: MeasuredHose, length: float, bore: float) -> MeasuredHose:
    """Return another piece of the same oil's hose: what Thesis eq. 4.3 and 4.5b make of length and bore.

    Turbulent R goes with L D^-4.75, laminar R with L D^-4, I with L D^-2, C with L D^2 (the same stiffness of
    wall and oil). Thesis eq. 4.3, 4.5b. Differs: 4.5b's A is the bore's area.

    Args:
        hose: as measured.
        length: L [m].
        bore: D [m].
    """
    long, wide = length / hose.length, bore / hose.bore
    return MeasuredHose(
        length=length,
        bore=bore,
        turbulent_resistance=hose.turbulent_resistance * long * wide**-4.75,
        laminar_resistance=hose.laminar_resistance * long * wide**-4.0,
        inertance=hose.inertance * long * wide**-2.0,
        capacitance=hose.capacitance * long * wide**2.0,
    )
