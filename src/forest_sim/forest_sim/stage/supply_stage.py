"""The manifold within an implicit stage: its equation, slopes and bounds.

C (P_s - base) = h (delivered - drawn)
"""

import math
from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.hydraulic_line import supply_coupling
from forest_sim.hydraulics.pump_drive import PumpState
from forest_sim.hydraulics.supply import (
    Supply,
    SupplyState,
    flow_after,
    manifold_capacitance,
    manifold_oil,
    pump_flow,
    reference_after,
    reference_gain,
)
from forest_sim.mechanics.manipulator import Pair
from forest_sim.midpoint.load_sensing import load_weights
from forest_sim.stage.axis_stage import AxisSolution

SUPPLY_TOLERANCE = 1e3  # [Pa] of Newton's last correction of P_s
SUPPLY_SHARE = 1e-3  # of the absolute pressure, where oil holds air: the next one is some pascals
UNBOUNDED = (-math.inf, math.inf)


class AxisDraw(NamedTuple):
    """What one axis asks of the supply within a stage."""

    flow: float  # [m^3/s]
    conductance: float  # d(flow)/dP_s [m^3/(s Pa)]
    gain: float  # d(flow)/d(actuator speed) [m^2; m^3/rad]
    load: float  # that it shows [Pa], 0 or more
    load_by_supply: float  # d(load)/dP_s
    load_by_speed: float  # d(load)/d(actuator speed) [Pa s/m; Pa s/rad]
    sensed: float  # the share of the step in which it does
    feeds: Pair  # d(flow into hose 1, 2)/dP_s [m^3/(s Pa)]


class Control(NamedTuple):
    """How P_r at a stage's end follows an iterate."""

    by_supply: float  # dP_r/dP_s
    by_rate: Vec3  # dP_r/d(rate) of the actuators, seen at their joints [Pa s]


NO_CONTROL = Control(0.0, (0.0, 0.0, 0.0))


class SupplyError(NamedTuple):
    """The manifold's equation of a stage and its slopes."""

    residual: float  # [m^3]
    slope: float  # by P_s [m^3/Pa]
    by_rate: Vec3  # by the joint rates [m^3 s]
    on_rates: Vec3  # -d(residual of the joints)/dP_s [m^3 s]: the same, but for what P_r has of the rates
    feeds: tuple[Pair, Pair, Pair]  # d(flow into hose 1, 2)/dP_s of swing, boom, stick [m^3/(s Pa)]
    state: SupplyState  # P_s [Pa] of the iterate, and the P_r that follows from it
    control: Control = NO_CONTROL


def supply_error(
    base: SupplyState,
    known: PumpState,
    supply: float,
    axes: tuple[AxisSolution, AxisSolution, AxisSolution],
    ports: tuple[Ports, Ports, Ports],
    arms: Vec3,
    h: float,
    p: PlantParameters,
) -> SupplyError:
    """Return the manifold's equation, C (P_s - base) = h (delivered - drawn), at an iterate.

    Swash plate and engine are found from their known parts. What the engine's speed yields to P_s
    within a stage is left out of the slope: it is of order h^2.

    Where the oil holds air, `base` has what the manifold holds in place of its pressure.
    """
    one = _axis_draw(axes[0], ports[0], supply, h)
    two = _axis_draw(axes[1], ports[1], supply, h)
    three = _axis_draw(axes[2], ports[2], supply, h)
    reference, control = base.reference, NO_CONTROL
    if p.supply.rate > 0.0:
        reference, control = load_sensing(reference, one, two, three, arms, h, p.supply)
    pump = pump_flow(supply, reference, p.supply)
    if p.supply.drive.present:
        pump = flow_after(SupplyState(supply, reference), known, h, p.supply).flow
    drawn = one.flow + two.flow + three.flow
    conductance = one.conductance + two.conductance + three.conductance
    stored = p.supply.capacitance * (supply - base.pressure)
    if p.supply.volume > 0.0:
        stored = manifold_oil(supply, p.supply) - base.pressure
    capacitance = manifold_capacitance(supply, p.supply)
    on_rates = h * arms[0] * one.gain, h * arms[1] * two.gain, h * arms[2] * three.gain
    controlled = h * pump.control
    return SupplyError(
        residual=stored + h * (drawn - pump.delivered),
        slope=capacitance + h * (conductance - pump.slope) - controlled * control.by_supply,
        by_rate=(
            on_rates[0] - controlled * control.by_rate[0],
            on_rates[1] - controlled * control.by_rate[1],
            on_rates[2] - controlled * control.by_rate[2],
        ),
        on_rates=on_rates,
        feeds=(one.feeds, two.feeds, three.feeds),
        state=SupplyState(supply, reference),
        control=control,
    )


def load_sensing(
    before: float, one: AxisDraw, two: AxisDraw, three: AxisDraw, arms: Vec3, h: float, supply: Supply
) -> tuple[float, Control]:
    """Return P_r [Pa] at the stage's end, which follows the highest load, and how it follows the iterate.

    Args:
        before: P_r's known part [Pa].
        one: what the swing asks.
        two: what the boom asks.
        three: what the stick asks.
        arms: d(actuator speed)/d(joint rate).
        h: the stage's implicit step [s].
        supply: constants of the pump.
    """
    one, two, three = _relieved(one, supply), _relieved(two, supply), _relieved(three, supply)
    loads, shares = (one.load, two.load, three.load), (one.sensed, two.sensed, three.sensed)
    w = load_weights(loads, shares)
    load = w[0] * loads[0] + w[1] * loads[1] + w[2] * loads[2]
    reference, gain = reference_after(before, load, supply, h), reference_gain(load, supply, h)
    w = gain * w[0], gain * w[1], gain * w[2]
    control = Control(
        by_supply=w[0] * one.load_by_supply + w[1] * two.load_by_supply + w[2] * three.load_by_supply,
        by_rate=(
            w[0] * arms[0] * one.load_by_speed,
            w[1] * arms[1] * two.load_by_speed,
            w[2] * arms[2] * three.load_by_speed,
        ),
    )
    return reference, control


def _relieved(axis: AxisDraw, supply: Supply) -> AxisDraw:
    """Return an axis that shows the line for a share of a step no more than its relief valve leaves.

    Clipped after the mean, a load above it would count for more than its share.
    """
    highest = supply.set_pressure - supply.margin
    if axis.sensed == 1.0 or axis.load <= highest:
        return axis
    return axis._replace(load=highest, load_by_supply=0.0, load_by_speed=0.0)


def _axis_draw(axis: AxisSolution, ports: Ports, supply: float, h: float) -> AxisDraw:
    """Return what an axis asks of the supply within a stage."""
    one = supply_coupling(axis.one, ports.port_1, supply, axis.lines[0], h)
    two = supply_coupling(axis.two, ports.port_2, supply, axis.lines[1], h)
    gain = axis.swept[0] * one.gain - axis.swept[1] * two.gain
    first, second = ports.sensed
    load = load_by_supply = load_by_speed = 0.0
    if first > 0.0 and axis.one.port_pressure > load:
        load, load_by_supply = axis.one.port_pressure, one.port_gain
        load_by_speed = -axis.swept[0] * axis.one.port_stiffness
    if second > 0.0 and axis.two.port_pressure > load:
        load, load_by_supply = axis.two.port_pressure, two.port_gain
        load_by_speed = axis.swept[1] * axis.two.port_stiffness
    feeds = one.feed, two.feed
    return AxisDraw(
        flow=one.draw + two.draw,
        conductance=one.conductance + two.conductance,
        gain=gain,
        load=load,
        load_by_supply=load_by_supply,
        load_by_speed=load_by_speed,
        sensed=max(first, second),
        feeds=feeds,
    )


def supply_tolerance(supply: float, p: PlantParameters) -> float:
    """Return how small Newton's last correction of P_s must be [Pa]; near vacuum oil with air is curved."""
    if p.supply.volume == 0.0:
        return SUPPLY_TOLERANCE
    return SUPPLY_SHARE * (supply + p.supply.oil.above_vapour)


def tightened_bounds(bounds: Pair, pressure: float, change: float) -> Pair:
    """Return the bounds of the supply's pressure after Newton has pointed up or down from one [Pa].

    Its equation rises with the pressure, but with the kinks of a pump's characteristic, across
    which Newton alone may jump to and fro. The rates move meanwhile: bounds that have closed on
    nothing are dropped.
    """
    low, high = (pressure, bounds[1]) if change > 0.0 else (bounds[0], pressure)
    return (low, high) if high - low > SUPPLY_TOLERANCE else UNBOUNDED
