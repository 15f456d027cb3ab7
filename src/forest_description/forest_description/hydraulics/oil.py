"""The oil: density, bulk modulus and viscosity against temperature, and what it takes to warm it.

Symbols:
    T, T_r  temperature, reference temperature [K]
    ρ, α_T  density [kg/m³], thermal expansion [1/K]
    β       bulk modulus [Pa]
    ν, μ    kinematic [m²/s] and absolute viscosity μ = ρ ν [Pa·s]

Every number of a machine holds at the oil's reference temperature; ``temperature.at_temperature``
gives the machine at another one. Pressure has no influence on the oil here.
"""

import dataclasses
import math
from dataclasses import dataclass

from forest_description.config.parameter import ParameterSet, parameter, replace_unchecked, require_order

WALTHER_OFFSET = 0.7  # [mm²/s] added to the viscosity in ASTM D341, from 2 mm²/s upwards
SQUARE_MILLIMETRES = 1e6  # in a square metre
SOFTEST = 1e8  # [Pa] half air
COLDEST, HOTTEST = 223.15, 423.15  # [K] -50 and 150 °C, beyond which no hydraulic oil works


@dataclass(frozen=True)
class EntrainedAir(ParameterSet):
    """Free air in the oil, and where the oil boils; the thesis' oil has none and pulls without end."""

    share: float = parameter("1", 1e-5, 0.2, "free air at tank pressure, by volume of the oil")
    dissolving_pressure: float = parameter("Pa", 1e5, 5e7, "above the tank's, from which all is dissolved")
    tank_pressure: float = parameter("Pa", 3e4, 3e5, "absolute pressure of the tank")
    vapour_pressure: float = parameter("Pa", 0.0, 2e4, "absolute, at which the oil boils")


@dataclass(frozen=True)
class Oil(ParameterSet):
    """The hydraulic oil; the thesis names it in its table of components and gives it no temperature."""

    reference_temperature: float = parameter(
        "K", COLDEST, HOTTEST, "at which all numbers of the machine hold, and the oil's below"
    )
    density: float = parameter("kg/m3", 500.0, 2000.0, "density ρ")
    thermal_expansion: float = parameter("1/K", 0.0, 5e-3, "relative growth of volume per temperature")
    bulk_modulus: float = parameter("Pa", SOFTEST, 1e10, "β of the oil alone, without walls")
    bulk_modulus_slope: float = parameter("Pa/K", -5e7, 5e7, "slope dβ/dT over temperature")
    cold_temperature: float = parameter("K", COLDEST, HOTTEST, "where cold_viscosity was measured")
    cold_viscosity: float = parameter("m2/s", 2e-6, 0.1, "kinematic viscosity there")
    hot_temperature: float = parameter("K", COLDEST, HOTTEST, "where hot_viscosity was measured")
    hot_viscosity: float = parameter("m2/s", 2e-6, 0.1, "kinematic viscosity there")
    specific_heat: float = parameter("J/(kg*K)", 100.0, 1e4, "heat to warm a mass of oil")
    volume: float = parameter("m3", 1e-3, 100.0, "volume of all oil, in tank and lines")
    heat_loss_coefficient: float = parameter("W/K", 0.0, 1e6, "heat to the ambient per temperature above it")
    ambient_temperature: float = parameter("K", 200.0, 400.0, "of the air around the machine")
    air: EntrainedAir | None = None  # may be left out

    def __post_init__(self) -> None:
        """Check ranges, and that the oil thins as it warms."""
        super().__post_init__()
        cold, hot = self.cold_temperature, self.hot_temperature
        require_order("cold_temperature", cold, "hot_temperature", hot, "K")
        require_order("hot_viscosity", self.hot_viscosity, "cold_viscosity", self.cold_viscosity, "m2/s")

    @property
    def heat_capacity(self) -> float:
        """What it takes to warm all oil [J/K]."""
        return self.density * self.volume * self.specific_heat

    @property
    def sound_speed(self) -> float:
        """C_0 = sqrt(β/ρ) [m/s] in the oil alone, for ``line_bandwidth.py``."""
        return math.sqrt(self.bulk_modulus / self.density)

    def kinematic_viscosity(self, temperature: float) -> float:
        """Return ν [m²/s] at a temperature [K]: ln ln(ν/(mm²/s) + 0.7) is straight over ln T.

        Walther's law in the form of ASTM D341, which needs no more terms from 2 mm²/s upwards.
        """
        cold, hot = _walther(self.cold_viscosity), _walther(self.hot_viscosity)
        span = math.log(self.hot_temperature / self.cold_temperature)
        w = cold + (hot - cold) * math.log(temperature / self.cold_temperature) / span
        return (math.exp(math.exp(w)) - WALTHER_OFFSET) / SQUARE_MILLIMETRES

    def density_at(self, temperature: float) -> float:
        """Return ρ exp(-α_T (T - T_r)) [kg/m³] at a temperature [K]."""
        return self.density * math.exp(-self.thermal_expansion * (temperature - self.reference_temperature))

    def absolute_viscosity(self, temperature: float) -> float:
        """Return μ = ρ ν [Pa·s] at a temperature [K]."""
        return self.density_at(temperature) * self.kinematic_viscosity(temperature)

    def at(self, temperature: float) -> "Oil":
        """Return the same oil described at another reference temperature [K]; its mass stays.

        Raises:
            MachineError: The temperature is outside its range.
        """
        density = self.density_at(temperature)
        softer = self.bulk_modulus + self.bulk_modulus_slope * (temperature - self.reference_temperature)
        return replace_unchecked(
            dataclasses.replace(self, reference_temperature=temperature),
            density=density,
            bulk_modulus=max(SOFTEST, softer),  # a straight line ends somewhere: no oil has less than none
            volume=self.volume * self.density / density,
        )


def _walther(viscosity: float) -> float:
    """Return ln ln(ν/(mm²/s) + 0.7), the ordinate of the ASTM D341 chart."""
    return math.log(math.log(viscosity * SQUARE_MILLIMETRES + WALTHER_OFFSET))
