"""The swing motor's leakage. Thesis section 4.3.5.

| symbol | name | unit |
|---|---|---|
| P_1, P_2 | pressure at the motor's ports | Pa |
| R_in, R_ex | resistance between the ports; of each port to the case drain | Pa s/m^3 |
| Q_ex | flow of the case drain | m^3/s |
| D | N D_m, oil per swing angle | m^3/rad |
| w | swing speed | rad/s |
| f | leakage at the oil's temperature over that at the reference temperature | 1 |

On the tilted platform with the valve shut, what the motor displaces passes from its loaded chamber to the
other one and to the drain:

    D |w| = (P_h - P_l)/R_in + P_h/R_ex

Thesis section 4.3.5.2 has no external leakage there. Differs: the loaded chamber does leak to the drain, a
quarter of what passes inside; left out, R_in would come out a sixth too low.
"""

import numpy as np

from forest_description.derived.temperature import at_temperature
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.estimators.least_squares import LinearFit, solve
from forest_ident.measurements.differentiator import derivative, inner, smooth
from forest_ident.measurements.session import Session

BANDWIDTH = 0.5  # [Hz]: creep is slow
SETTLED = 5.0  # [s] until the creep is steady


def viscosity_factor(machine: Machine, session: Session) -> Floats:
    """Return f along a session; 1 for a machine without oil data."""
    measured = session.temperature()
    if machine.oil is None or measured is None:
        return np.ones(len(session.time))
    knots = np.linspace(measured.min() - 0.1, measured.max() + 0.1, 12)
    cold = machine.swing.external_leakage_resistance
    share = [cold / at_temperature(machine, float(t)).swing.external_leakage_resistance for t in knots]
    return np.interp(measured, knots, share)


def external(machine: Machine, session: Session) -> LinearFit:
    """Return 1/R_ex [m^3/(s Pa)]: Q_ex = f (P_1 + P_2)/R_ex, from the drain's meter or its vessel.

    Thesis eq. 4.8, section 4.3.5.2. The vessel gives one number; its standard error is then not known here.

    Raises:
        SessionError: the drain was not measured.
    """
    one, two = session.pressures("swing", "actuator")
    driving = (one + two) * viscosity_factor(machine, session)
    if session.has("case_drain"):
        return solve([driving], session.column("case_drain"))
    volume = session.metadata.get("case_drain_volume", float("nan"))
    share = volume / float(np.sum(driving) * session.period)
    error = 0.01 * share
    return LinearFit(np.array([share]), np.array([error]), 1.0, np.zeros(0), np.array([[error**2]]))


def internal(machine: Machine, session: Session, external_conductance: float) -> LinearFit:
    """Return 1/R_in [m^3/(s Pa)] from the creep on the tilted platform.

    Where the unloaded chamber's transducer reads zero, its pressure need not be zero. The drain's flow gives
    it: P_1 + P_2 = Q_ex R_ex. Thesis eq. 4.7, 4.9, section 4.3.5.2.

    Args:
        machine: whose D counts.
        session: of the creep.
        external_conductance: 1/R_ex [m^3/(s Pa)].
    """
    period, f = session.period, viscosity_factor(machine, session)
    displacement = machine.swing.gear_ratio * machine.swing.motor_displacement
    speed = derivative(session.column("swing_resolver"), BANDWIDTH, period)
    one, two = (smooth(column, BANDWIDTH, period) for column in session.pressures("swing", "actuator"))
    high, low = np.maximum(one, two), np.minimum(one, two)
    noise = machine.sensors.pressure.noise or 0.0 if machine.sensors.pressure else 0.0
    at_zero = low <= max(noise, 10.0)
    drained = _drained(session, external_conductance, f, period)
    if drained is not None:
        low = np.where(at_zero, drained - high, low)
    passed = displacement * np.abs(speed) - external_conductance * f * high
    rows = inner(len(speed), BANDWIDTH, period)
    rows = slice(rows.start + round(SETTLED / period), rows.stop)
    return solve([(f * (high - low))[rows]], passed[rows])


def _drained(session: Session, conductance: float, f: Floats, period: float) -> Floats | None:
    """Return P_1 + P_2 [Pa] as the case drain has it; None if it was not measured."""
    if session.has("case_drain"):
        return smooth(session.column("case_drain"), BANDWIDTH, period) / (conductance * f)
    volume = session.metadata.get("case_drain_volume")
    if volume is None:
        return None
    mean = volume / (len(f) * period)
    return mean / (conductance * f)
