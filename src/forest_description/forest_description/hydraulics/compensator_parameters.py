"""Pressure compensators of spool valves: with them an opening means a flow, whatever the load."""

from dataclasses import dataclass
from typing import ClassVar

from forest_description.config.parameter import ParameterSet, parameter, require_order


@dataclass(frozen=True)
class _Compensator(ParameterSet):
    """What both sorts have in common."""

    setting: float = parameter("Pa", 1e4, 1e7, "of its spring")
    control_range: float = parameter("Pa", 1e3, 5e6, "change of its control pressure from shut to fully open")
    minimum_resistance: float = parameter("Pa*s2/m6", 1e8, 1e18, "C_R of the fully open compensator")
    response_time: float = parameter("s", 0.002, 1.0, "time constant at which it finds its opening")


@dataclass(frozen=True)
class CompensatorBeforeSpool(_Compensator):
    """Between pump and spool: keeps the spool edge's own drop at the setting (load sensing)."""

    kind: ClassVar[str] = "before_spool"

    def __post_init__(self) -> None:
        """Check ranges, and that some drop remains while it controls."""
        super().__post_init__()
        require_order("control_range", self.control_range, "setting", self.setting, "Pa")


@dataclass(frozen=True)
class CompensatorAfterSpool(_Compensator):
    """Behind the spool's edge: keeps the pressure there at the greatest load's (flow sharing, LUDV)."""

    kind: ClassVar[str] = "after_spool"


Compensator = CompensatorBeforeSpool | CompensatorAfterSpool
