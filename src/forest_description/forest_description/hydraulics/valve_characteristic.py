"""Law of the proportional spool valve: spool position to the resistances of its four edges.

Symbols:
    V       voltage that the spool's position stands for [V]
    V_d     voltage at the edge of the overlap [V]; 0: critical centre, negative: underlap
    V_r     rated voltage [V]
    C_R     orifice resistance in ΔP = C_R Q|Q| [Pa·s²/m⁶]; C_Rmin at the rated voltage
    G, r    conductance of an edge's laminar leakage; that at the overlap's edge over that at the centre
    s       stroke of the spool beyond the overlap, (V − V_d)/(V_r − V_d), clipped to 0..1
    u       opening 0..1, in proportion to the orifice area: u = sqrt(C_Rmin / C_R)

Sign: V > V_d connects port 1 to the supply and port 2 to the tank; V < −V_d the reverse. Each
direction has its own overlap and gain. Figure 4.4, which shows the measured curve C_R(V), is lost;
an area linear in the voltage beyond the overlap, u = s, is assumed unless the machine gives a
polynomial or a table.

Oil leaks through the clearance of an edge: G = pi D c^3/(12 mu L) of a spool of diameter D with the
clearance c and the sealing length L (Merritt, Hydraulic Control Systems, 1967, section 3.2). L is
what is left of the overlap, V_d - V, and the rounding of the edges, which is V_d/(r - 1). An open
edge keeps r G_0 beside its orifice, so that the flow has no step.
"""

import math
from typing import NamedTuple

LINEAR, POLYNOMIAL, TABLE = 0, 1, 2
"""Sorts of curve u(s)."""


class Direction(NamedTuple):
    """One direction of the spool: V_d [V], V_r [V], C_Rmin of port 1's edge and of port 2's [Pa·s²/m⁶]."""

    deadband_voltage: float
    rated_voltage: float
    resistance_1: float
    resistance_2: float


Knots = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
"""As many as every curve has, so that all valves share one compiled kernel."""


class Curve(NamedTuple):
    """u(s): linear; C_R/C_Rmin a polynomial of s; or a table, straight in between.

    A table has its s in ``knots`` and its u in ``values``; a polynomial its coefficients in
    ``values``, lowest power first. Unused places repeat a table's end and are zero in a polynomial.
    """

    sort: int
    knots: Knots
    values: Knots


class ValveLaw(NamedTuple):
    """A valve: both directions, the curve of both, what leaks past the edges, and its load check."""

    forward: Direction
    backward: Direction
    curve: Curve
    leakage: float  # G_0 [m³/(s Pa)] past each of the edges, with the spool in its centre
    load_check: int = 0  # not 0: a check valve lets no oil back to the supply
    edge_ratio: float = 1.0  # r of the leakage; 1: the same at any position


class Leakage(NamedTuple):
    """What leaks past port 1's two edges [m³/(s Pa)]; past port 2's with the other sign of ``skew``."""

    mean: float
    skew: float  # half of what the supply's edge leaks more than the tank's


class Edges(NamedTuple):
    """Orifice resistances of the spool's four edges [Pa·s²/m⁶]; infinite when shut."""

    supply_1: float
    tank_1: float
    supply_2: float
    tank_2: float


SHUT = 1e-7
"""Opening below which an edge is shut: with the whole pump pressure across it, 2 mL an hour."""

CURVE_SIZE = 12
_UNUSED: Knots = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
LINEAR_AREA = Curve(LINEAR, _UNUSED, _UNUSED)


def symmetric_valve(deadband_voltage: float, rated_voltage: float, minimum_resistance: float) -> ValveLaw:
    """Return the thesis' valve: both directions and both ports alike, area linear, no leakage.

    Args:
        deadband_voltage: V_d [V].
        rated_voltage: V_r [V].
        minimum_resistance: C_Rmin [Pa·s²/m⁶].
    """
    direction = Direction(deadband_voltage, rated_voltage, minimum_resistance, minimum_resistance)
    return ValveLaw(direction, direction, LINEAR_AREA, 0.0)


def stroke(voltage: float, direction: Direction) -> float:
    """Return s = (V − V_d)/(V_r − V_d), clipped to 0..1. A voltage that is not a number closes the valve.

    Args:
        voltage: Spool position, counted along the direction [V].
        direction: The direction.
    """
    if not voltage > direction.deadband_voltage:  # written so that NaN, too, ends here
        return 0.0
    if voltage >= direction.rated_voltage:
        return 1.0
    return (voltage - direction.deadband_voltage) / (direction.rated_voltage - direction.deadband_voltage)


def opening_at(s: float, curve: Curve) -> float:
    """Return the opening u(s), 0 at s = 0. Thesis eq. 3.2, 4.2 (C_R falls with the square of the area).

    Args:
        s: Stroke beyond the overlap, 0..1.
        curve: The curve.
    """
    if s <= 0.0 or curve.sort == LINEAR:
        return s
    return curved_opening(s, curve)


def curved_opening(s: float, curve: Curve) -> float:
    """Return the opening u(s), 0 < s <= 1, of a polynomial or a table."""
    if curve.sort == POLYNOMIAL:
        ratio = 0.0
        for k in range(CURVE_SIZE - 1, -1, -1):
            ratio = ratio * s + curve.values[k]
        return 1.0 / math.sqrt(ratio)
    k = 1
    while curve.knots[k] < s:
        k += 1
    share = (s - curve.knots[k - 1]) / (curve.knots[k] - curve.knots[k - 1])
    return curve.values[k - 1] + share * (curve.values[k] - curve.values[k - 1])


def resistance_at(opening: float, minimum_resistance: float) -> float:
    """Return C_R = C_Rmin / u² [Pa·s²/m⁶]; infinite when shut. Thesis eq. 3.1, 3.2, 4.1, 4.2.

    An opening below ``SHUT`` is shut. A lagging spool that is centred without overlap comes ever
    nearer to shut and never there: u² would vanish in rounding, and C_R Q|Q| be made of what is
    left of a flow.
    """
    if opening < SHUT:
        return math.inf
    return minimum_resistance / (opening * opening)


def edges(spool_voltage: float, law: ValveLaw) -> Edges:
    """Return the four orifices at a spool position; all shut inside the overlap.

    Thesis eq. 3.1, 3.2, 4.1, 4.2, fig. 2.5. Differs: the curve C_R(V) of fig. 4.4 is lost; this one
    is assumed.

    Args:
        spool_voltage: Voltage that the spool's position stands for, either sign [V].
        law: The valve.
    """
    forward = opening_at(stroke(spool_voltage, law.forward), law.curve)
    backward = opening_at(stroke(-spool_voltage, law.backward), law.curve)
    return Edges(
        supply_1=resistance_at(forward, law.forward.resistance_1),
        tank_1=resistance_at(backward, law.backward.resistance_1),
        supply_2=resistance_at(backward, law.backward.resistance_2),
        tank_2=resistance_at(forward, law.forward.resistance_2),
    )


def leakage_at(spool_voltage: float, law: ValveLaw) -> Leakage:
    """Return what leaks past the edges at a spool position; arguments as ``edges``."""
    if law.edge_ratio == 1.0:
        return Leakage(law.leakage, 0.0)
    return overlap_leakage(spool_voltage, law)


def overlap_leakage(spool_voltage: float, law: ValveLaw) -> Leakage:
    """Return what ``leakage_at`` does where it follows the overlap; not inlined."""
    forward = law.leakage * leakage_share(spool_voltage, law.forward.deadband_voltage, law.edge_ratio)
    backward = law.leakage * leakage_share(-spool_voltage, law.backward.deadband_voltage, law.edge_ratio)
    return Leakage(0.5 * (forward + backward), 0.5 * (forward - backward))


def leakage_share(voltage: float, deadband_voltage: float, edge_ratio: float) -> float:
    """Return G/G_0 of an edge, 1 at the centre, r at the overlap's edge and beyond.

    Args:
        voltage: Spool position, counted along the direction that opens the edge [V].
        deadband_voltage: V_d of this direction, above 0 [V].
        edge_ratio: r.
    """
    return edge_ratio / (1.0 + (edge_ratio - 1.0) * max(0.0, 1.0 - voltage / deadband_voltage))


def voltage_for_opening(opening: float, law: ValveLaw) -> float:
    """Return the spool voltage that gives an opening with a direction [V].

    No opening is 0 V, the middle of the overlap. On an underlapped valve, where both directions are
    open at the centre, an opening is what one direction has more than the other.

    Args:
        opening: Wished opening, −1..1 (beyond is clipped); its sign is the direction.
        law: The valve.
    """
    magnitude = min(abs(opening), 1.0)
    if not magnitude > 0.0:
        return 0.0
    direction = law.forward if opening > 0.0 else law.backward
    if law.forward.deadband_voltage + law.backward.deadband_voltage < 0.0:
        return _underlapped_voltage(math.copysign(magnitude, opening), law)
    s = _stroke_for(magnitude, law.curve)
    return math.copysign(1.0, opening) * (
        direction.deadband_voltage + s * (direction.rated_voltage - direction.deadband_voltage)
    )


def _underlapped_voltage(opening: float, law: ValveLaw) -> float:
    """Return the voltage at which one direction is open by so much more than the other; it grows with it."""
    low, high = -law.backward.rated_voltage, law.forward.rated_voltage
    for _ in range(60):
        middle = 0.5 * (low + high)
        forward = opening_at(stroke(middle, law.forward), law.curve)
        if forward - opening_at(stroke(-middle, law.backward), law.curve) < opening:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _stroke_for(opening: float, curve: Curve) -> float:
    """Return the s in 0..1 with u(s) nearest to the opening; u grows with s."""
    if curve.sort == LINEAR:
        return opening
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if opening_at(middle, curve) < opening:
            low = middle
        else:
            high = middle
    return high
