"""Units that a machine file may use, each with its factor to SI.

The table is explicit and short on purpose: a unit that is not here is refused with the list of
those that are. A unit is a factor and nothing else: temperatures are in K, because degrees Celsius
have an offset. ``psi`` is the 6894.7 Pa of the thesis' program (Appendix B), not 6894.757 Pa, so
that 3000 psi is its pump pressure; ``hp`` is the thesis' 745.7 W, ``gal`` the US gallon of its flow
meters.
"""

import math
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit of a machine file: ``value * factor`` is in ``si``."""

    si: str
    factor: float


UNITS: dict[str, Unit] = {
    "1": Unit("1", 1.0),
    "percent": Unit("1", 1e-2),
    "kg": Unit("kg", 1.0),
    "lb": Unit("kg", 0.45359237),
    "m": Unit("m", 1.0),
    "mm": Unit("m", 1e-3),
    "in": Unit("m", 0.0254),
    "rad": Unit("rad", 1.0),
    "deg": Unit("rad", math.pi / 180.0),
    "s": Unit("s", 1.0),
    "ms": Unit("s", 1e-3),
    "Hz": Unit("Hz", 1.0),
    "V": Unit("V", 1.0),
    "V/s": Unit("V/s", 1.0),
    "K": Unit("K", 1.0),
    "Pa": Unit("Pa", 1.0),
    "MPa": Unit("Pa", 1e6),
    "bar": Unit("Pa", 1e5),
    "psi": Unit("Pa", 6894.7),
    "m2": Unit("m2", 1.0),
    "cm2": Unit("m2", 1e-4),
    "in2": Unit("m2", 0.0254**2),
    "m3/s": Unit("m3/s", 1.0),
    "L/min": Unit("m3/s", 1e-3 / 60.0),
    "gal/min": Unit("m3/s", 231.0 * 0.0254**3 / 60.0),
    "W": Unit("W", 1.0),
    "kW": Unit("W", 1e3),
    "hp": Unit("W", 745.7),
    "rad/s": Unit("rad/s", 1.0),
    "rpm": Unit("rad/s", 2.0 * math.pi / 60.0),
    "m/s": Unit("m/s", 1.0),
    "N": Unit("N", 1.0),
    "kN": Unit("N", 1e3),
    "m3/rad": Unit("m3/rad", 1.0),
    "m3/rev": Unit("m3/rad", 1.0 / (2.0 * math.pi)),
    "cm3/rev": Unit("m3/rad", 1e-6 / (2.0 * math.pi)),
    "kg*m2": Unit("kg*m2", 1.0),
    "m/s2": Unit("m/s2", 1.0),
    "N/m": Unit("N/m", 1.0),
    "N/V": Unit("N/V", 1.0),
    "N/Pa": Unit("N/Pa", 1.0),
    "N*s/m": Unit("N*s/m", 1.0),
    "N*s2/m2": Unit("N*s2/m2", 1.0),
    "N*m": Unit("N*m", 1.0),
    "N*m/rad": Unit("N*m/rad", 1.0),
    "N*m*s/rad": Unit("N*m*s/rad", 1.0),
    "Pa*s2/m6": Unit("Pa*s2/m6", 1.0),
    "Pa*s/m3": Unit("Pa*s/m3", 1.0),
    "Pa*s2/m3": Unit("Pa*s2/m3", 1.0),
    "m3/Pa": Unit("m3/Pa", 1.0),
    "m3/(s*Pa)": Unit("m3/(s*Pa)", 1.0),
    "L/(min*bar)": Unit("m3/(s*Pa)", 1e-3 / 60.0 / 1e5),
    "m3": Unit("m3", 1.0),
    "L": Unit("m3", 1e-3),
    "kg/m3": Unit("kg/m3", 1.0),
    "m2/s": Unit("m2/s", 1.0),
    "mm2/s": Unit("m2/s", 1e-6),
    "1/K": Unit("1/K", 1.0),
    "Pa/K": Unit("Pa/K", 1.0),
    "MPa/K": Unit("Pa/K", 1e6),
    "W/K": Unit("W/K", 1.0),
    "J/(kg*K)": Unit("J/(kg*K)", 1.0),
}


def units_for(si: str) -> list[str]:
    """Return the names of all units that measure the same quantity as the SI unit ``si``."""
    return [name for name, unit in UNITS.items() if unit.si == si]
