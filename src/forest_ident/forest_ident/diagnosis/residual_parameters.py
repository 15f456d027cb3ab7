"""The monitor's numbers of a machine: its file as the residuals need it."""

import math
from typing import NamedTuple

from forest_description.geometry.linkage import Linkage, linkage_of
from forest_description.hydraulics.oil import COLDEST, HOTTEST, SQUARE_MILLIMETRES, WALTHER_OFFSET, Oil
from forest_description.hydraulics.valve_characteristic import ValveLaw
from forest_description.machine import Machine
from forest_description.mechanics.drives import SwingDrive
from forest_ident.diagnosis.monitor_readings import CHANNELS
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.hydraulics.load_holding import NONE
from forest_sim.hydraulics.oil_volume import OilVolume
from forest_sim.hydraulics.supply import Supply
from forest_sim.sensors.sensor_suite import KINDS

STRAIGHT = linkage_of(1.0, 1.0, 0.0)


class Port(NamedTuple):
    """One port of an actuator."""

    area: float  # [m^2; m^3/rad]
    wall: float  # capacitance of a hose that is all that yields [m^3/Pa]
    oil: OilVolume
    is_open: int  # 1: nothing stands between the transducers at valve and actuator but the hose


class AxisNumbers(NamedTuple):
    """One axis."""

    law: ValveLaw
    lag: float  # [s] of the spool behind its voltage, dead time included
    linkage: Linkage
    one: Port
    two: Port
    internal_leakage: float  # [m^3/(s Pa)]
    external_leakage: float


class Viscosity(NamedTuple):
    """The oil's absolute viscosity over temperature: Walther's law, as in `forest_description`'s `Oil`."""

    reference: float = 0.0  # [K] at which the file's leakages hold; 0: oil without a temperature
    ordinate: float = 0.0  # [1] ln ln(nu/(mm^2/s) + 0.7) there
    slope: float = 0.0  # [1] of the ordinate over ln T
    expansion: float = 0.0  # [1/K]


class Parameters(NamedTuple):
    """All axes, the supply, the oil, and which sensors the file says there are."""

    axes: tuple[AxisNumbers, AxisNumbers, AxisNumbers]
    supply: Supply
    oil: Viscosity
    fitted: tuple[int, ...]  # 1 for each of `CHANNELS` that the machine has


def parameters(machine: Machine) -> Parameters:
    """Return the monitor's numbers of a machine, in SI units but for volts at the valves.

    Raises:
        MachineError: boom and stick have no resolvers: the monitor knows no other angles' errors.
    """
    machine.demand_resolvers("the monitor")
    plant = plant_parameters(machine)
    swing, boom, stick = (_axis(machine, plant, i) for i in range(3))
    kind_of = {channel: kind.name for kind in KINDS for channel in kind.channels}
    fitted = tuple(int(getattr(machine.sensors, kind_of[name]) is not None) for name in CHANNELS)
    return Parameters(
        axes=(swing, boom, stick),
        supply=plant.supply,
        oil=_viscosity(machine.oil) if machine.oil else Viscosity(),
        fitted=fitted,
    )


def thinned(v: Viscosity, temperature: float) -> float:
    """Return by which factor oil leaks more than at the file's temperature; 1 without a thermometer.

    Args:
        v: of the oil.
        temperature: of the oil in the tank [K]; NaN: not read.
    """
    if v.reference == 0.0 or math.isnan(temperature):
        return 1.0
    t = max(COLDEST, min(HOTTEST, temperature))
    thick, thin = _millimetres(v.ordinate), _millimetres(v.ordinate + v.slope * math.log(t / v.reference))
    return thick / thin * math.exp(v.expansion * (t - v.reference))


def _millimetres(ordinate: float) -> float:
    """Return a kinematic viscosity [mm^2/s]."""
    return math.exp(math.exp(ordinate)) - WALTHER_OFFSET


def _viscosity(oil: Oil) -> Viscosity:
    def ordinate(temperature: float) -> float:
        kinematic = oil.kinematic_viscosity(temperature)
        return math.log(math.log(SQUARE_MILLIMETRES * kinematic + WALTHER_OFFSET))

    cold, hot = oil.cold_temperature, oil.hot_temperature
    return Viscosity(
        reference=oil.reference_temperature,
        ordinate=ordinate(oil.reference_temperature),
        slope=(ordinate(hot) - ordinate(cold)) / math.log(hot / cold),
        expansion=oil.thermal_expansion,
    )


def _axis(machine: Machine, plant: PlantParameters, i: int) -> AxisNumbers:
    axis, valve, drive = plant.axes[i], plant.valves[i], machine.drives[i]
    lag = 0.0 if valve.lag.frequency in (0.0, float("inf")) else 1.0 / valve.lag.frequency
    a, ports = axis.actuator, []
    sides = (
        (a.own_displacement_1, axis.oil_1, axis.holding_1),
        (a.own_displacement_2, axis.oil_2, axis.holding_2),
    )
    for port, (area, oil, holding) in enumerate(sides, start=1):
        ports.append(Port(area, machine.line(i, port).capacitance, oil, int(holding.sort == NONE)))
    return AxisNumbers(
        law=valve.law,
        lag=lag + valve.lag.dead_time,
        linkage=STRAIGHT if isinstance(drive, SwingDrive) else drive.linkage,
        one=ports[0],
        two=ports[1],
        internal_leakage=a.internal_leakage,
        external_leakage=a.external_leakage,
    )


def full_speed(k: AxisNumbers) -> float:
    """Return a speed near an axis's greatest [m/s; rad/s]: half of 20 MPa over each edge."""
    return math.sqrt(1e7 / k.law.forward.resistance_1) / k.one.area
