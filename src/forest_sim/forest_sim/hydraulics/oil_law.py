"""Oil under pressure: what room it takes with the air that bubbles in it.

Oil that a tank has stirred holds free air. Pressed, the bubbles shrink and dissolve; under tank
pressure they grow, and as the pressure nears that of the oil's vapour they fill any room. No
volume that holds oil comes below. A volume that owes oil, since what flowed out of it ran on when
it was empty, is a few pascals below, on the law's tangent there, made ten times as steep.

| symbol | name | unit |
|---|---|---|
| P | pressure above the tank's | Pa |
| p_a, p_v | absolute pressure of the tank; of the oil's vapour | Pa |
| alpha | free air at tank pressure, as a share of the oil's volume | 1 |
| P_c | pressure above which all air is dissolved | Pa |
| theta | share of the air that is free: (1 - s)^2 (1 + 2 s), s = P/P_c within 0 .. 1 | 1 |
| v | room that oil and air take over what they take at tank pressure | 1 |
| nu | density over that at tank pressure, 1/v | 1 |
| h | enthalpy, the integral of v dP: what a flow brings with it | J/m^3 |

    v = (1/(1 + P/beta) + alpha theta (p_a - p_v)/(p_a - p_v + P))/(1 + alpha)

The bubbles are isothermal; the vapour in them adds its pressure to the air's (Dalton). theta is that
of Simscape's isothermal liquid (MathWorks, "Isothermal Liquid Properties", air dissolution on).
Dissolving takes no time here. The bulk modulus is -v/(dv/dP): beta + P without air, 21 MPa at tank
pressure with half a percent of it.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.oil import Oil


class OilLaw(NamedTuple):
    """Constants of the law."""

    compliance: float  # 1/beta [1/Pa]
    air: float  # alpha
    above_vapour: float  # p_a - p_v [Pa], the tank's; inf without air: no floor
    dissolving: float  # P_c [Pa]


class Density(NamedTuple):
    """How dense the oil is at a pressure, over tank pressure."""

    ratio: float  # nu
    slope: float  # dnu/dP [1/Pa]


CURVED = 100.0  # [Pa] by which a pressure along a tangent may be off
EMPTY = 1.0  # [Pa] above the vapour's pressure: nearer to it the law is as good as straight
OWING = 10.0  # times as steep is the law of a volume that owes oil
INCOMPRESSIBLE = OilLaw(0.0, 0.0, math.inf, 1.0)


def oil_law(oil: Oil) -> OilLaw:
    """Return the law of a machine's oil."""
    air = oil.air
    if air is None:
        return OilLaw(1.0 / oil.bulk_modulus, 0.0, math.inf, 1.0)
    above_vapour = air.tank_pressure - air.vapour_pressure
    return OilLaw(1.0 / oil.bulk_modulus, air.share, above_vapour, air.dissolving_pressure)


def density(pressure: float, o: OilLaw) -> Density:
    """Return nu and its slope at a pressure [Pa]: of l/(1 + g l), g the bubbles."""
    liquid, whole = 1.0 + o.compliance * pressure, 1.0 + o.air
    if o.air == 0.0 or pressure >= o.dissolving:
        return Density(whole * liquid, whole * o.compliance)
    if pressure + o.above_vapour <= 0.0:
        slope = OWING * whole / (o.air * o.above_vapour)
        return Density(slope * (pressure + o.above_vapour), slope)
    per_above, free, dissolved = 1.0 / (pressure + o.above_vapour), 1.0, 0.0
    if pressure > 0.0:
        s = pressure / o.dissolving
        free, dissolved = (1.0 - s) * (1.0 - s) * (1.0 + 2.0 * s), 6.0 * s * (1.0 - s) / o.dissolving
    bubbles = o.air * o.above_vapour * per_above
    shrinking = bubbles * (dissolved + free * per_above)
    share = 1.0 / (1.0 + bubbles * free * liquid)
    return Density(
        whole * liquid * share, whole * (o.compliance + shrinking * liquid * liquid) * share * share
    )


def enthalpy(pressure: float, o: OilLaw) -> float:
    """Return h [J/m^3] at a pressure [Pa], a little less than P where the oil is pressed."""
    h = math.log(1.0 + o.compliance * pressure) / o.compliance
    if o.air > 0.0:
        h += o.air * o.above_vapour * _of_bubbles(max(pressure, EMPTY - o.above_vapour), o)
    return h / (1.0 + o.air)


def _of_bubbles(pressure: float, o: OilLaw) -> float:
    """Return the integral of theta dP/(p_a - p_v + P) from tank pressure on."""
    if pressure <= 0.0:
        return math.log((pressure + o.above_vapour) / o.above_vapour)
    s, b = min(1.0, pressure / o.dissolving), o.above_vapour / o.dissolving
    # theta = 2 s^3 - 3 s^2 + 1, divided by s + b.
    rest = 1.0 - 3.0 * b * b - 2.0 * b * b * b
    polynomial = s * (s * (2.0 / 3.0 * s - 1.5 - b) + 3.0 * b + 2.0 * b * b)
    return polynomial + rest * math.log((s + b) / b)


def held_above_vapour(pressure: float, before: float, o: OilLaw) -> float:
    """Return a pressure [Pa], but no less than a tenth of the way from the vapour's to one before.

    Within `EMPTY` of the vapour's it may be any: Newton's next step, on a concave law, is the last.
    """
    above = before + o.above_vapour
    return max(pressure, before - 0.9 * above) if above > EMPTY else pressure


def is_near(pressure: float, near: float, o: OilLaw) -> bool:
    """Tell whether the law's tangent at a pressure near [Pa] is within some `CURVED` at another."""
    off = pressure - near
    return off * off <= CURVED * max(EMPTY, pressure + o.above_vapour)
