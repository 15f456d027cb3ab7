"""The pumps: how the manifold's pressure answers what three axes draw from it.

| symbol | name | unit |
|---|---|---|
| P_s | pressure in the manifold | Pa |
| P_r | pressure that the pump's control aims at | Pa |
| Q_d | flow that the pumps displace | m^3/s |
| S | flow that the axes draw | m^3/s |
| W | greatest hydraulic power, engine power times mechanical efficiency | W |

    C dP_s/dt = Q_d - P_s/R_leak - relief(P_s) - S

Displacement and engine limit the flow, min(Q_max, W/P_s); a compensator takes it back to zero
within a narrow band under P_r. Thesis section 2.2, 3.2.1, fig. 2.3, 3.4. A swash plate that takes
time is asked for that displacement, and an engine that droops turns it (`pump_drive`). An ideal
pump has none of this: P_s stands still.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.pump import (
    ConstantFlowPump,
    IdealPump,
    LoadSensingPump,
    PressureCompensatedPump,
    Pump,
)
from forest_sim.hydraulics.oil_law import INCOMPRESSIBLE, OilLaw, density, enthalpy
from forest_sim.hydraulics.pump_drive import (
    NO_DRIVE,
    UNDRIVEN,
    PumpDrive,
    PumpState,
    Sloped,
    pump_drive,
    speed_after,
    stroke_after,
)


class Supply(NamedTuple):
    """The pumps as one; `ideal` is not 0 for a source of constant pressure."""

    ideal: int
    set_pressure: float  # [Pa] greatest P_r
    flow_limit: float  # Q_max [m^3/s]
    power_limit: float  # W [W]
    efficiency: float  # hydraulic over shaft power
    compensation: float  # dQ/dP of the compensator [m^3/(s Pa)], 0: none, always full flow
    leakage: float  # 1/R_leak [m^3/(s Pa)]
    capacitance: float  # C [m^3/Pa]
    relief_pressure: float  # [Pa]
    relief_conductance: float  # [m^3/(s Pa)]
    margin: float  # [Pa] of a load-sensing pump
    rate: float  # [1/s] of its lag; 0: P_r stands still
    volume: float = 0.0  # [m^3] of oil with air in the manifold; 0: the capacitance is constant
    oil: OilLaw = INCOMPRESSIBLE
    drive: PumpDrive = NO_DRIVE


class SupplyState(NamedTuple):
    """Pressure in the manifold and the control's aim; also holds their time derivatives."""

    pressure: float  # P_s [Pa]
    reference: float  # P_r [Pa]


class PumpFlow(NamedTuple):
    """What the pumps do at a pressure."""

    displaced: float  # Q_d [m^3/s]
    delivered: float  # Q_d less leakage and relief [m^3/s]
    slope: float  # d(delivered)/dP_s [m^3/(s Pa)], never positive
    control: float  # d(delivered)/dP_r [m^3/(s Pa)], never negative


class DrivenFlow(NamedTuple):
    """What pumps with swash plate and engine do at the end of an implicit stage."""

    flow: PumpFlow
    pump: PumpState


def supply(pump: Pump, law: OilLaw = INCOMPRESSIBLE) -> Supply:
    """Return the kernel's constants of a machine's pump, and of the oil in its manifold."""
    if isinstance(pump, IdealPump):
        return Supply(
            ideal=1,
            set_pressure=pump.supply_pressure,
            flow_limit=math.inf,
            power_limit=math.inf,
            efficiency=1.0,
            compensation=0.0,
            leakage=0.0,
            capacitance=1.0,
            relief_pressure=math.inf,
            relief_conductance=0.0,
            margin=0.0,
            rate=0.0,
            oil=law,
        )
    band = pump.compensator_band if isinstance(pump, PressureCompensatedPump | LoadSensingPump) else math.inf
    margin, lag = (pump.margin, pump.response_time) if isinstance(pump, LoadSensingPump) else (0.0, math.inf)
    relief = pump.supply_pressure if isinstance(pump, ConstantFlowPump) else pump.relief_pressure
    return Supply(
        ideal=0,
        set_pressure=pump.supply_pressure,
        flow_limit=pump.flow_limit,
        power_limit=_power_limit(pump),
        efficiency=pump.mechanical_efficiency,
        compensation=pump.flow_limit / band,
        leakage=1.0 / pump.leakage_resistance,
        capacitance=pump.manifold_capacitance,
        relief_pressure=relief,
        relief_conductance=pump.relief_conductance,
        margin=margin,
        rate=1.0 / lag,
        volume=0.0 if law.air == 0.0 else pump.manifold_capacitance / law.compliance,
        oil=law,
        drive=pump_drive(pump),
    )


def _power_limit(pump: ConstantFlowPump | PressureCompensatedPump | LoadSensingPump) -> float:
    """Return the power [W] at which displacement is taken back: the engine's, unless that may droop."""
    power = pump.engine_power * pump.mechanical_efficiency
    if isinstance(pump, ConstantFlowPump):
        return power
    if pump.engine is not None:
        power = math.inf
    return power if pump.torque_limit is None else min(power, pump.torque_limit * pump.shaft_speed)


def manifold_oil(pressure: float, s: Supply) -> float:
    """Return what the manifold holds at a pressure [Pa]: oil [m^3]; without air, that pressure."""
    return s.volume * density(pressure, s.oil).ratio if s.volume > 0.0 else pressure


def manifold_capacitance(pressure: float, s: Supply) -> float:
    """Return C [m^3/Pa] of the manifold at a pressure [Pa]."""
    if s.volume == 0.0:
        return s.capacitance
    return s.volume * density(pressure, s.oil).slope


def manifold_energy(pressure: float, s: Supply) -> float:
    """Return the energy [J] in the manifold: C P^2/2, or of oil with air V (nu h - P)."""
    if s.volume == 0.0:
        return 0.5 * s.capacitance * pressure**2
    return s.volume * (enthalpy(pressure, s.oil) * density(pressure, s.oil).ratio - pressure)


def pump_flow(pressure: float, reference: float, s: Supply) -> PumpFlow:
    """Return what pumps deliver whose displacement is at once what is asked. Thesis section 3.2.1, fig. 3.4.

    Args:
        pressure: P_s [Pa].
        reference: P_r [Pa].
        s: the pumps.
    """
    return _delivered(_asked(pressure, reference, s), pressure, s)


def flow_at(supply: SupplyState, pump: PumpState, s: Supply) -> PumpFlow:
    """Return what the pumps deliver into the manifold at a state; of its `slope` swash plates have none."""
    if s.drive.present == 0:
        return pump_flow(supply.pressure, supply.reference, s)
    stroke = asked_stroke(supply, s)
    if s.drive.up > 0.0:
        stroke = Sloped(pump.stroke, 0.0)
    return _delivered(_displaced(stroke, pump.speed, s), supply.pressure, s)


def flow_after(supply: SupplyState, known: PumpState, step: float, s: Supply) -> DrivenFlow:
    """Return what pumps with swash plate and engine deliver at the end of an implicit stage; not inlined.

    Args:
        supply: at the stage's end.
        known: the stage's known part of swash plate and engine.
        step: the stage's implicit step [s].
        s: the pumps.
    """
    stroke = stroke_after(known.stroke, asked_stroke(supply, s), step, s.drive)
    speed = speed_after(known.speed, pump_torque(stroke.value, supply.pressure, s), step, s.drive)
    flow = _delivered(_displaced(stroke, speed, s), supply.pressure, s)
    return DrivenFlow(flow, PumpState(stroke.value, speed))


def asked_stroke(supply: SupplyState, s: Supply) -> Sloped:
    """Return the displacement over the greatest one that compensator and limiter ask for, 0..1."""
    asked = _asked(supply.pressure, supply.reference, s)
    return Sloped(asked.value / s.flow_limit, asked.slope / s.flow_limit, asked.control / s.flow_limit)


def pump_torque(stroke: float, pressure: float, s: Supply) -> float:
    """Return T_p [N m] of pumps at a displacement over the greatest one; below zero the oil drives them."""
    ideal = s.flow_limit / s.drive.speed * stroke * pressure
    return ideal / s.efficiency if ideal > 0.0 else ideal * s.efficiency


def _displaced(stroke: Sloped, speed: float, s: Supply) -> Sloped:
    """Return Q_d [m^3/s] of a displacement at a speed [rad/s]."""
    full = s.flow_limit * (speed / s.drive.speed)
    return Sloped(full * stroke.value, full * stroke.slope, full * stroke.control)


def _asked(pressure: float, reference: float, s: Supply) -> Sloped:
    """Return the flow [m^3/s] at the speed without load that compensator and limiter ask for."""
    displaced, slope, control = available_flow(pressure, s), 0.0, 0.0
    if displaced < s.flow_limit:
        slope = -displaced / pressure
    wanted = s.compensation * (reference - pressure)
    if s.compensation > 0.0 and wanted < displaced:
        control = s.compensation if wanted > 0.0 else 0.0
        displaced, slope = max(0.0, wanted), -control
    return Sloped(displaced, slope, control)


def _delivered(of: Sloped, pressure: float, s: Supply) -> PumpFlow:
    """Return what of a displaced flow [m^3/s] leakage and relief valve leave."""
    displaced, slope, control = of
    delivered = displaced - s.leakage * pressure
    slope -= s.leakage
    if pressure > s.relief_pressure:
        delivered -= s.relief_conductance * (pressure - s.relief_pressure)
        slope -= s.relief_conductance
    return PumpFlow(displaced, delivered, slope, control)


def available_flow(pressure: float, s: Supply) -> float:
    """Return min(Q_max, W/P_s) [m^3/s], what displacement and engine allow at a pressure [Pa]."""
    return min(s.flow_limit, s.power_limit / pressure) if pressure > 0.0 else s.flow_limit


def saturation(draw: float, pressure: float, s: Supply, pump: PumpState = UNDRIVEN) -> float:
    """Return which part of what the pumps can give the axes draw, 0..1; 1: each gets what its load leaves it.

    Args:
        draw: S [m^3/s].
        pressure: P_s [Pa].
        s: the pumps; an ideal one never saturates.
        pump: how fast an engine turns them.
    """
    if s.ideal:
        return 0.0
    turned = pump.speed / s.drive.speed if s.drive.inertia > 0.0 else 1.0
    most = turned * available_flow(pressure, s) - s.leakage * pressure
    return min(1.0, max(0.0, draw / most)) if most > 0.0 else 1.0


def reference_rate(reference: float, load: float, s: Supply) -> float:
    """Return dP_r/dt [Pa/s]: a load-sensing pump follows the greatest load with a lag. Thesis section 2.2.

    Args:
        reference: P_r [Pa].
        load: greatest pressure at a port that draws from the supply [Pa].
        s: the pumps.
    """
    return s.rate * (_aim(load, s) - reference)


def reference_after(reference: float, load: float, s: Supply, step: float) -> float:
    """Return P_r [Pa] at the end of an implicit stage, P_r = reference + step dP_r/dt."""
    kept = 1.0 / (1.0 + step * s.rate)
    return kept * (reference + step * s.rate * _aim(load, s))


def reference_gain(load: float, s: Supply, step: float) -> float:
    """Return d(`reference_after`)/d(load)."""
    if load <= 0.0 or load + s.margin >= s.set_pressure:
        return 0.0
    return step * s.rate / (1.0 + step * s.rate)


def _aim(load: float, s: Supply) -> float:
    return min(s.set_pressure, max(0.0, load) + s.margin)
