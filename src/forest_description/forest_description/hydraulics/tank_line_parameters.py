"""The line from the valves to the tank: filter, cooler and preload valve, and the oil before them."""

from dataclasses import dataclass

from forest_description.config.parameter import ParameterSet, parameter


@dataclass(frozen=True)
class TankLine(ParameterSet):
    """Return line, through which the oil of all valves goes to the tank; without it they see the tank."""

    preload: float = parameter("Pa", 0.0, 3e6, "pressure below which it passes nothing to the tank")
    resistance: float = parameter("Pa*s2/m6", 1e7, 1e14, "C_R of filter and line: pressure over flow squared")
    capacitance: float = parameter("m3/Pa", 1e-13, 1e-8, "of the oil between valves and filter")
