"""Valves at an actuator's port that hold its load: counterbalance, pilot-operated check, hose rupture."""

from dataclasses import dataclass
from typing import ClassVar

from forest_description.config.parameter import ParameterSet, parameter, require_order


@dataclass(frozen=True)
class CounterbalanceValve(ParameterSet):
    """Over-centre valve: load and pilot pressure together open it for oil from the actuator."""

    kind: ClassVar[str] = "counterbalance"

    setting: float = parameter("Pa", 1e5, 1e8, "load pressure that cracks it without pilot pressure")
    pilot_ratio: float = parameter("1", 0.5, 20.0, "pilot area over that of the load")
    hysteresis: float = parameter("Pa", 0.0, 2e7, "it reseats so far below the pressure that cracks it")
    opening_range: float = parameter("Pa", 1e5, 1e8, "rise of load and pilot from cracking to fully open")
    minimum_resistance: float = parameter("Pa*s2/m6", 1e8, 1e18, "C_R of the fully open valve")
    check_resistance: float = parameter("Pa*s2/m6", 1e7, 1e18, "C_R of its check valve, to the actuator")
    response_time: float = parameter("s", 0.002, 1.0, "time constant of its poppet")

    def __post_init__(self) -> None:
        """Check ranges, and that the valve reseats."""
        super().__post_init__()
        require_order("hysteresis", self.hysteresis, "setting", self.setting, "Pa")


@dataclass(frozen=True)
class PilotCheckValve(ParameterSet):
    """Pilot-operated check valve: the load shuts it, pilot pressure opens it for oil from the actuator."""

    kind: ClassVar[str] = "pilot_check"

    setting: float = parameter("Pa", 1e4, 1e7, "pilot force over the load's that opens it, by its spring")
    pilot_ratio: float = parameter("1", 1.0, 20.0, "pilot area over that of the load")
    hysteresis: float = parameter("Pa", 0.0, 2e7, "it reseats so far below the pressure that opens it")
    opening_range: float = parameter("Pa", 1e5, 1e8, "rise of the pilot's force from cracking to fully open")
    minimum_resistance: float = parameter("Pa*s2/m6", 1e8, 1e18, "C_R of the fully open valve")
    check_resistance: float = parameter("Pa*s2/m6", 1e7, 1e18, "C_R of it as a check, to the actuator")
    response_time: float = parameter("s", 0.002, 1.0, "time constant of its poppet")


@dataclass(frozen=True)
class RuptureValve(ParameterSet):
    """Hose-rupture valve: too much flow from the actuator shuts it, until oil comes to the actuator again."""

    kind: ClassVar[str] = "rupture"

    closing_flow: float = parameter("m3/s", 1e-6, 0.1, "flow from the actuator that shuts it")
    minimum_resistance: float = parameter("Pa*s2/m6", 1e7, 1e18, "C_R of the open valve, both ways")
    response_time: float = parameter("s", 0.002, 1.0, "time constant of its poppet")


LoadHolding = CounterbalanceValve | PilotCheckValve | RuptureValve
