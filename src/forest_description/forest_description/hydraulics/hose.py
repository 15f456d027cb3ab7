"""The types of hose that a machine may have, as lumped elements of a piece of it.

Symbols:
    L, D, A  length [m], bore [m] and its area [m²]
    Q        flow [m³/s]; Q_n the nominal one
    R, I, C  resistance [Pa·s/m³ laminar, Pa·s²/m⁶ turbulent], inertance [Pa·s²/m³], capacitance
    [m³/Pa] ρ, μ     density [kg/m³] and absolute viscosity [Pa·s] of the oil
    β, K     bulk modulus of the oil; what the wall adds to it, 1/β_eff = 1/β + 1/K [Pa]

One lump per hose is an approximation; ``line_bandwidth.py`` says up to which frequency.
"""

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from forest_description.config.parameter import ParameterSet, parameter
from forest_description.hydraulics.oil import Oil

BLASIUS = 0.3164 * 8.0 / math.pi**2 * (math.pi / 4.0) ** 0.25
"""α of Thesis eq. 4.3, 0.2414: Blasius' friction factor 0.3164 Re^-1/4 of a smooth pipe, written with Q."""

BORE_DOC = "inside diameter"


class Line(NamedTuple):
    """One hose as lumped elements.

    The resistance is that of ΔP = R Q (laminar) [Pa·s/m³] or ΔP = R Q|Q| (turbulent) [Pa·s²/m⁶];
    inertance [Pa·s²/m³]; capacitance [m³/Pa].
    """

    resistance: float
    inertance: float
    capacitance: float


def bore_area(bore: float) -> float:
    """Return A = π D²/4 [m²] of a bore [m]."""
    return 0.25 * math.pi * bore * bore


@dataclass(frozen=True)
class MeasuredHose(ParameterSet):
    """A hose as measured, of which every line is a longer or shorter piece. Thesis section 4.3.3, 4.3.4."""

    kind: ClassVar[str] = "measured"

    length: float = parameter("m", 0.1, 100.0, "length of the measured hose")
    bore: float = parameter("m", 1e-3, 0.5, BORE_DOC)
    turbulent_resistance: float = parameter("Pa*s2/m6", 0.0, 1e15, "R of ΔP = R Q|Q| (turbulent)")
    laminar_resistance: float = parameter("Pa*s/m3", 1e3, 1e13, "R of ΔP = R Q (laminar)")
    inertance: float = parameter("Pa*s2/m3", 1e3, 1e10, "fluid inertance I")
    capacitance: float = parameter("m3/Pa", 1e-16, 1e-8, "capacitance C of oil and wall")

    def line(self, length: float, exponent: float, laminar: bool) -> Line:
        """Return a piece of this hose: R scales with length, I and C with length to the power ``exponent``.

        Thesis eq. 4.3, 4.4, 4.5b. The exponent is 1; 2 is what Appendix B prints for the stick.

        Args:
            length: Length of the piece [m].
            exponent: Power of the length ratio for inertance and capacitance.
            laminar: Whether the resistance is the laminar one.
        """
        ratio = length / self.length
        resistance = self.laminar_resistance if laminar else self.turbulent_resistance
        return Line(resistance * ratio, self.inertance * ratio**exponent, self.capacitance * ratio**exponent)

    def oil_share(self, bulk_modulus: float) -> float:
        """Return the oil's share of the capacitance, A L/(β C); the rest is the wall's.

        A capacitance measured smaller than the oil's alone counts as the oil's altogether.

        Args:
            bulk_modulus: β [Pa].
        """
        return min(1.0, bore_area(self.bore) * self.length / (bulk_modulus * self.capacitance))


@dataclass(frozen=True)
class GeometricHose(ParameterSet):
    """A hose known by its bore and its wall; the machine's oil gives the rest. Thesis section 4.3.3, 4.3.4.

    It is smooth and straight, without fittings. docs/explanation/equations.md tells how far the
    measured one is from it.
    """

    kind: ClassVar[str] = "geometric"

    bore: float = parameter("m", 1e-3, 0.5, BORE_DOC)
    wall_modulus: float | None = parameter(
        "Pa", 1e6, 1e13, "K of the wall, 1/β_eff = 1/β + 1/K; null: a rigid one"
    )
    turbulent_coefficient: float = parameter(
        "1", 0.01, 10.0, "α of ΔP = α μ^0.25 ρ^0.75 L D^-4.75 Q^1.75; 0.2414 is Blasius' smooth pipe"
    )
    nominal_flow: float = parameter(
        "m3/s", 1e-6, 1.0, "turbulent flow at which Q^1.75 and its approximation Q|Q| agree"
    )

    def line(self, length: float, laminar: bool, oil: Oil) -> Line:
        """Return the elements of a hose of a length [m] that is filled with an oil.

            laminar    R = 128 μ L/(π D⁴)                            (Hagen-Poiseuille)
            turbulent  R = α μ^0.25 ρ^0.75 L D^-4.75 Q_n^-0.25
            I = ρ L/A,  C = A L (1/β + 1/K)

        Thesis eq. 4.3, 4.4, 4.5b. Differs: the thesis replaces Q^1.75 by Q|Q| and fits R anew; here
        both agree at Q_n (a quarter of Q_n loses 29 % too little, four times Q_n 41 % too much).

        Args:
            length: L [m].
            laminar: Whether the resistance is the laminar one.
            oil: At its reference temperature.
        """
        area, viscosity = bore_area(self.bore), oil.absolute_viscosity(oil.reference_temperature)
        if laminar:
            resistance = 128.0 * viscosity * length / (math.pi * self.bore**4)
        else:
            oils = viscosity**0.25 * oil.density**0.75
            resistance = self.turbulent_coefficient * oils * length * self.bore**-4.75
            resistance *= self.nominal_flow**-0.25
        compliance = 1.0 / oil.bulk_modulus + (1.0 / self.wall_modulus if self.wall_modulus else 0.0)
        return Line(resistance, oil.density * length / area, area * length * compliance)

    def oil_share(self, bulk_modulus: float) -> float:
        """Return the oil's share of the capacitance, K/(K + β); the rest is the wall's.

        Args:
            bulk_modulus: β [Pa].
        """
        return 1.0 if self.wall_modulus is None else self.wall_modulus / (self.wall_modulus + bulk_modulus)


Hose = MeasuredHose | GeometricHose
