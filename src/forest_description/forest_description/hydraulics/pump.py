"""The types of pump that a machine may have; their laws are in ``forest_sim.hydraulics.supply``.

A sort of pump is a class below, in the union `Pump`; `forest_sim.hydraulics.supply.supply` makes
its constants. `identifiable` names the numbers that an identification finds from motions with a
transducer in the supply.

All but the ideal one deliver into a manifold between pump and valves. Its pressure is a state: it
settles where what the three axes draw equals what the pump can give.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

from forest_description.config.parameter import (
    MachineError,
    ParameterSet,
    optional_parameter,
    parameter,
    require_order,
)


@dataclass(frozen=True)
class Engine(ParameterSet):
    """Diesel engine whose governor lets the speed droop; a pump without one turns at constant speed."""

    inertia: float = parameter("kg*m2", 0.01, 1e3, "of crankshaft, flywheel and pumps")
    droop: float = parameter("1", 1e-3, 0.5, "share of shaft_speed lost from no load to greatest torque")
    torque: float = parameter("N*m", 1.0, 1e5, "greatest that it gives, as far as engine_power allows")
    stall_speed: float = parameter("rad/s", 1.0, 1000.0, "below it the engine stalls: it gives no torque")


@dataclass(frozen=True)
class IdealPump(ParameterSet):
    """Source of constant pressure at any flow. Thesis section 3.2.1, fig. 3.4."""

    kind: ClassVar[str] = "ideal"
    identifiable: ClassVar[tuple[str, ...]] = ("supply_pressure",)

    supply_pressure: float = parameter("Pa", 1e5, 5e7, "pump pressure P_s, constant")

    @property
    def flow_limit(self) -> float:
        """Greatest flow [m³/s]: there is none."""
        return math.inf

    @property
    def idle_pressure(self) -> float:
        """Pressure while nobody draws [Pa]."""
        return self.supply_pressure


@dataclass(frozen=True)
class _RealPump(ParameterSet):
    """What every real pump has: a shaft with limited power, leakage, friction, a manifold behind it."""

    identifiable: ClassVar[tuple[str, ...]] = ("supply_pressure",)

    supply_pressure: float = parameter("Pa", 1e5, 5e7, "pressure that the pump keeps, at no flow")
    count: float = parameter("1", 1.0, 20.0, "number of equal pumps on one manifold")
    displacement: float = parameter("m3/rad", 1e-8, 1e-3, "greatest displacement of one pump")
    shaft_speed: float = parameter(
        "rad/s", 1.0, 1000.0, "speed of the engine and the pumps; without load, where it droops"
    )
    engine_power: float = parameter("W", 100.0, 1e7, "greatest power that the engine gives to the pumps")
    mechanical_efficiency: float = parameter("1", 0.1, 1.0, "hydraulic over shaft power, friction's share")
    leakage_resistance: float = parameter("Pa*s/m3", 1e8, 1e18, "from the outlet to the tank, all pumps")
    manifold_capacitance: float = parameter("m3/Pa", 1e-13, 1e-8, "of the oil between pumps and valves")
    relief_conductance: float = parameter("m3/(s*Pa)", 1e-13, 1e-5, "of the main relief valve, above it")

    def __post_init__(self) -> None:
        """Check ranges, that pumps are whole, and that they can build up their pressure."""
        super().__post_init__()
        if self.count != round(self.count):
            raise MachineError(f"count ({self.count:g}) must be a whole number")
        leaked = self.supply_pressure / self.leakage_resistance
        if leaked >= self.flow_limit:
            raise MachineError(
                f"leakage_resistance ({self.leakage_resistance:g} Pa*s/m3) lets all that the pumps deliver "
                f"({self.flow_limit:g} m3/s) back before supply_pressure is reached; allowed: above "
                f"{self.supply_pressure / self.flow_limit:g} Pa*s/m3"
            )
        needed = leaked * self.supply_pressure / self.mechanical_efficiency
        if needed >= self.engine_power:
            raise MachineError(
                f"engine_power ({self.engine_power:g} W) does not even hold supply_pressure against "
                f"leakage_resistance; allowed: above {needed:g} W"
            )

    @property
    def flow_limit(self) -> float:
        """Flow at full displacement [m³/s]."""
        return self.count * self.displacement * self.shaft_speed

    @property
    def idle_pressure(self) -> float:
        """Pressure while nobody draws, but for leakage and droop [Pa]."""
        return self.supply_pressure


@dataclass(frozen=True)
class ConstantFlowPump(_RealPump):
    """Full flow at any pressure; what nobody takes goes over the relief valve. Thesis section 2.2, fig. 2.3.

    ``supply_pressure``, which commands are scaled with, is where its relief valve opens.
    """

    kind: ClassVar[str] = "constant_flow"


@dataclass(frozen=True, kw_only=True)
class _ControlledPump(_RealPump):
    """A pump that takes its stroke back at a pressure; the main relief valve is there for its failure."""

    relief_pressure: float = parameter("Pa", 1e5, 1e8, "at which the main relief valve opens")
    compensator_band: float = parameter("Pa", 1e3, 1e7, "pressure by which full stroke lies below no flow")
    stroke_up_time: float | None = optional_parameter(
        "s", 1e-3, 10.0, "time constant of the swash plate towards more displacement"
    )
    stroke_down_time: float | None = optional_parameter(
        "s", 1e-3, 10.0, "time constant of the swash plate towards less displacement"
    )
    torque_limit: float | None = optional_parameter(
        "N*m", 1.0, 1e6, "displacement of all pumps times pressure, at most"
    )
    engine: Engine | None = None

    def __post_init__(self) -> None:
        """Check ranges, that the relief valve is shut in control, and what swash plate and engine need."""
        super().__post_init__()
        band, most = self.compensator_band, self.supply_pressure
        require_order("compensator_band", band, "supply_pressure", most, "Pa")
        if self.relief_pressure < self.supply_pressure:
            raise MachineError(
                f"relief_pressure ({self.relief_pressure:g} Pa) must not be below supply_pressure "
                f"({self.supply_pressure:g} Pa): the pump would deliver over it at rest"
            )
        if (self.stroke_up_time is None) != (self.stroke_down_time is None):
            given = "stroke_down_time" if self.stroke_up_time is None else "stroke_up_time"
            raise MachineError(f"{given} alone; allowed: stroke_up_time and stroke_down_time, or neither")
        if self.torque_limit is not None:
            self._require_torque("torque_limit", self.torque_limit, 1.0)
        if self.engine is not None:
            self._require_torque("engine.torque", self.engine.torque, self.mechanical_efficiency)
            drooped = (1.0 - self.engine.droop) * self.shaft_speed
            if self.engine.stall_speed >= drooped:
                raise MachineError(
                    f"engine.stall_speed ({self.engine.stall_speed:g} rad/s) must be below the speed at "
                    f"greatest torque ({drooped:g} rad/s, by engine.droop of shaft_speed): the engine "
                    f"would stall before it gives it"
                )

    def _require_torque(self, name: str, torque: float, efficiency: float) -> None:
        """Raise if a torque [N m] does not hold the pressure against leakage."""
        leaked = self.supply_pressure / self.leakage_resistance
        needed = leaked / self.shaft_speed * self.supply_pressure / efficiency
        if torque <= needed:
            raise MachineError(
                f"{name} ({torque:g} N*m) does not even hold supply_pressure against leakage_resistance; "
                f"allowed: above {needed:g} N*m"
            )


@dataclass(frozen=True)
class PressureCompensatedPump(_ControlledPump):
    """Constant pressure as far as displacement and engine reach. Thesis section 3.2.1, fig. 3.4."""

    kind: ClassVar[str] = "pressure_compensated"
    identifiable: ClassVar[tuple[str, ...]] = ("supply_pressure", "compensator_band")


@dataclass(frozen=True)
class LoadSensingPump(_ControlledPump):
    """Pressure a margin above the greatest load, reached with a lag. Thesis section 2.2, fig. 2.3."""

    kind: ClassVar[str] = "load_sensing"
    # No experiment loads it up to its greatest pressure.
    identifiable: ClassVar[tuple[str, ...]] = ("margin", "response_time")

    margin: float = parameter("Pa", 1e4, 2e7, "by which the pump stays above the greatest load")
    response_time: float = parameter("s", 1e-3, 10.0, "time constant with which it follows the load")

    def __post_init__(self) -> None:
        """Check ranges, and that the margin leaves something for a load and for the pump's droop."""
        super().__post_init__()
        if self.margin >= self.supply_pressure:
            raise MachineError(
                f"margin ({self.margin:g} Pa) must be smaller than supply_pressure "
                f"({self.supply_pressure:g} Pa)"
            )
        require_order("compensator_band", self.compensator_band, "margin", self.margin, "Pa")

    @property
    def idle_pressure(self) -> float:
        """Pressure while nobody draws, but for leakage and droop [Pa]."""
        return self.margin


Pump = IdealPump | PressureCompensatedPump | ConstantFlowPump | LoadSensingPump
