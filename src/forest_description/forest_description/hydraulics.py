"""The hydraulic components that all axes of a machine share: pump, valve, hose, port valves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from forest_description.parameter import ParameterSet, parameter, require_order
from forest_description.valve import ValveLaw


class Line(NamedTuple):
    """One hose as lumped elements.

    The resistance is that of ΔP = R Q (laminar) [Pa·s/m³] or ΔP = R Q|Q| (turbulent) [Pa·s²/m⁶]; inertance
    [Pa·s²/m³]; capacitance [m³/Pa].
    """

    resistance: float
    inertance: float
    capacitance: float


@dataclass(frozen=True)
class Pump(ParameterSet):
    """Ideal pressure source. Thesis section 3.2.1."""

    supply_pressure: float = parameter("Pa", 1e5, 5e7, "pump pressure P_s, constant")


@dataclass(frozen=True)
class Valve(ParameterSet):
    """Proportional spool valve, the same on all axes; its law is in ``valve.py``."""

    deadband_voltage: float = parameter("V", 0.0, 5.0, "overlap: no flow up to this voltage")
    rated_voltage: float = parameter("V", 1.0, 50.0, "voltage of the fully open spool")
    minimum_resistance: float = parameter(
        "Pa*s2/m6", 1e9, 1e16, "orifice resistance C_R at the rated voltage"
    )

    def __post_init__(self) -> None:
        """Check ranges, and that the valve opens at all."""
        super().__post_init__()
        require_order("deadband_voltage", self.deadband_voltage, "rated_voltage", self.rated_voltage, "V")

    @property
    def law(self) -> ValveLaw:
        """The constants of ``valve.py``'s functions."""
        return ValveLaw(self.deadband_voltage, self.rated_voltage, self.minimum_resistance)


@dataclass(frozen=True)
class Hose(ParameterSet):
    """The measured hose, of which every line is a longer or shorter piece. Thesis section 4.3.3, 4.3.4."""

    length: float = parameter("m", 0.1, 100.0, "length of the measured hose")
    turbulent_resistance: float = parameter("Pa*s2/m6", 0.0, 1e15, "R of ΔP = R Q|Q| (boom and stick)")
    laminar_resistance: float = parameter("Pa*s/m3", 1e3, 1e13, "R of ΔP = R Q (swing)")
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


@dataclass(frozen=True)
class PortValves(ParameterSet):
    """Relief and anti-cavitation valves at every actuator port; not in the thesis."""

    relief_pressure: float = parameter("Pa", 1e5, 1e8, "port pressure above which oil leaves to the tank")
    relief_conductance: float = parameter("m3/(s*Pa)", 1e-13, 1e-5, "flow per pressure above it")
    anticavitation_pressure: float = parameter("Pa", -1e5, 1e6, "port pressure below which the tank refills")
    anticavitation_conductance: float = parameter("m3/(s*Pa)", 1e-13, 1e-5, "flow per pressure below it")
