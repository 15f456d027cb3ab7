"""Law of the proportional spool valve: voltage to orifice resistance.

Symbols:
    V       voltage that the spool's position stands for [V]
    V_d     deadband voltage, to the edge of the overlap [V]
    V_r     rated voltage [V]
    C_R     orifice resistance in ΔP = C_R Q|Q| [Pa·s²/m⁶]; C_Rmin at the rated voltage
    u       opening 0..1, in proportion to the orifice area

Sign: V > 0 connects port 1 to the supply and port 2 to the tank; V < 0 the reverse. C_R is the same both
ways. Figure 4.4, which shows the measured curve, is lost; an area linear in the voltage beyond the overlap is
assumed.
"""

from __future__ import annotations

import math
from typing import NamedTuple


class ValveLaw(NamedTuple):
    """Constants of the law: deadband_voltage [V], rated_voltage [V], minimum_resistance [Pa·s²/m⁶]."""

    deadband_voltage: float
    rated_voltage: float
    minimum_resistance: float


def orifice_opening(spool_voltage: float, law: ValveLaw) -> float:
    """Return the opening u = (|V| − V_d) / (V_r − V_d) = sqrt(C_Rmin / C_R), clipped to 0..1.

    Thesis eq. 3.2 (C_R falls with the square of the area). A voltage that is not a number closes the valve.

    Args:
        spool_voltage: Voltage that the spool's position stands for, either sign [V].
        law: Constants of the valve.
    """
    magnitude = abs(spool_voltage)
    if not magnitude > law.deadband_voltage:  # written so that NaN, too, ends here
        return 0.0
    if magnitude >= law.rated_voltage:
        return 1.0
    return (magnitude - law.deadband_voltage) / (law.rated_voltage - law.deadband_voltage)


def orifice_resistance(spool_voltage: float, law: ValveLaw) -> float:
    """Return C_R(V) = C_Rmin / u² [Pa·s²/m⁶]; infinite in the overlap, where nothing flows.

    Thesis eq. 3.1, 3.2, 4.1, 4.2. Differs: the curve C_R(V) of fig. 4.4 is lost; this one is assumed.

    Args:
        spool_voltage: Voltage that the spool's position stands for, either sign [V].
        law: Constants of the valve.
    """
    opening = orifice_opening(spool_voltage, law)
    if opening == 0.0:
        return math.inf
    return law.minimum_resistance / (opening * opening)


def voltage_for_opening(opening: float, law: ValveLaw) -> float:
    """Return the voltage V = sgn(u) (V_d + |u| (V_r − V_d)) that gives the opening [V].

    The inverse of ``orifice_opening`` with a direction. No opening is 0 V, the middle of the overlap.

    Args:
        opening: Wished opening, −1..1 (beyond is clipped); its sign is the direction.
        law: Constants of the valve.
    """
    magnitude = min(abs(opening), 1.0)
    if not magnitude > 0.0:
        return 0.0
    voltage = law.deadband_voltage + magnitude * (law.rated_voltage - law.deadband_voltage)
    return math.copysign(voltage, opening)
