"""Machines that differ by chance from what controller and driver believe: valves, load, spools, oil, gear.

| what | drawn | default |
|---|---|---|
| deadband | of every valve and direction, off by as much as +-deadband, evenly; not under 0 | 0.15 V |
| gain | of every valve and direction: flow at a drop, times 1 -+ gain, evenly | 0.4 |
| head_mass | times 1/head_mass .. head_mass, its logarithm evenly | 2 |
| spool | bandwidth of all spools, likewise; one that follows at once stays | 1.5 |
| stiffness | of each axis' hoses (geometric ones: their walls), and of all oil: times 1 -+ it, evenly | 0 |
| tilt | of the platform, +-tilt, evenly | 0 deg |
| head | mass of the head with its load, 0 .. head, evenly; not under what hangs there | as in the file |
| dead_time, hysteresis | of all valves, 0 .. so much, evenly; 0: none | as in the file |
| backlash | free way of the swing's gear, 0 .. backlash, evenly; 0: none | as in the file |
| oil | temperature, 0 .. oil, evenly | as in the file |
| bending | stiffness of column, boom and stick: times 1 -+ bending, evenly; rigid ones stay | 0 |

What is drawn is the simulated machine; what controller and driver believe stays. Equal seeds draw equal
machines, whatever else is drawn from them.
"""

import argparse
import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.derived.temperature import at_temperature
from forest_description.hydraulics.hose import MeasuredHose
from forest_description.hydraulics.oil import Oil
from forest_description.hydraulics.valve_characteristic import Direction
from forest_description.hydraulics.valve_parameters import Valve
from forest_description.machine import Machine
from forest_description.mechanics.drives import Backlash
from forest_description.mechanics.elasticity_parameters import Elasticity
from forest_description.mechanics.load import RotatorAndGrapple
from forest_description.types import Vec3
from forest_sim.equations.plant_parameters import PlantParameters, SpoolValve, parameters_of

ICE = 273.15  # [K] of 0 degrees Celsius
STREAM = 2  # of a seed's draws; a sensor suite's are 0 and 1
HIGHEST = {
    "deadband": 1.0,
    "gain": 0.9,
    "head_mass": 10.0,
    "spool": 10.0,
    "stiffness": 0.9,
    "tilt": 30.0,
    "head": 5000.0,
    "dead_time": 0.02,
    "hysteresis": 5.0,
    "backlash": 5.0,
    "oil": 100.0,
    "bending": 0.9,
}
LOWEST = {"head_mass": 1.0, "spool": 1.0}  # the others: 0
LEAST_HEAD = 50.0  # [kg] under a rotator, or alone
LEAST_DEAD_TIME = 5e-4  # [s] less is none
LEAST_FREE_WAY = 1e-6  # [rad] less is none
HELP = (
    "every run's machine is drawn: valves' deadbands and gains, head, spools; RANGES: "
    "deadband=0.15,gain=0.4,head_mass=2,spool=1.5 or some of them (these are the defaults); also stiffness, "
    "tilt (deg), head (kg), dead_time (s), hysteresis (V), backlash (deg), oil (deg C), bending"
)


class Ranges(NamedTuple):
    """How far a machine may be off."""

    deadband: float = 0.15  # [V]
    gain: float = 0.4
    head_mass: float = 2.0
    spool: float = 1.5
    stiffness: float = 0.0
    tilt: float = 0.0  # [deg]
    head: float | None = None  # [kg]
    dead_time: float | None = None  # [s]
    hysteresis: float | None = None  # [V]
    backlash: float | None = None  # [deg]
    oil: float | None = None  # [degree Celsius]
    bending: float = 0.0


class Mismatch(NamedTuple):
    """How far one is; sixes are swing forward, backward, boom forward and so on."""

    deadbands: tuple[float, ...]  # [V] added
    gains: tuple[float, ...]  # factors
    head_mass: float  # factor
    spool: float  # factor of the bandwidth
    hoses: Vec3  # factors of the stiffness, by axis
    modulus: float  # factor of the oil's
    tilt: float  # [rad] added
    head: float | None  # [kg]; None, here and below: as in the file
    dead_time: float | None  # [s]
    hysteresis: float | None  # [V]
    backlash: float | None  # [rad]
    oil: float | None  # [K]
    links: Vec3  # factors of the links' stiffness

    def told(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {name: list(x) if isinstance(x, tuple) else x for name, x in self._asdict().items()}


def draw(seed: int, ranges: Ranges) -> Mismatch:
    """Return a seed's machine."""
    chance = np.random.default_rng([seed, STREAM]).uniform(-1.0, 1.0, 27).tolist()

    def share(k: int, most: float | None) -> float | None:
        return None if most is None else 0.5 * (1.0 + chance[k]) * most

    backlash, oil = share(22, ranges.backlash), share(23, ranges.oil)
    return Mismatch(
        deadbands=tuple(ranges.deadband * x for x in chance[:6]),
        gains=tuple(1.0 + ranges.gain * x for x in chance[6:12]),
        head_mass=math.exp(chance[12] * math.log(ranges.head_mass)),
        spool=math.exp(chance[13] * math.log(ranges.spool)),
        hoses=(
            1.0 + ranges.stiffness * chance[14],
            1.0 + ranges.stiffness * chance[15],
            1.0 + ranges.stiffness * chance[16],
        ),
        modulus=1.0 + ranges.stiffness * chance[17],
        tilt=math.radians(ranges.tilt * chance[18]),
        head=share(19, ranges.head),
        dead_time=share(20, ranges.dead_time),
        hysteresis=share(21, ranges.hysteresis),
        backlash=None if backlash is None else math.radians(backlash),
        oil=None if oil is None else oil + ICE,
        links=(
            1.0 + ranges.bending * chance[24],
            1.0 + ranges.bending * chance[25],
            1.0 + ranges.bending * chance[26],
        ),
    )


def applied(machine: Machine, m: Mismatch) -> PlantParameters:
    """Return the kernel's parameters of a machine that is so far off.

    Raises:
        MachineError: the machine lacks what is drawn.
    """
    p = parameters_of(drawn(machine, m))
    one, two, three = (_valve(p.valves[i], i, m) for i in range(3))
    return p._replace(valves=(one, two, three))


def drawn(machine: Machine, m: Mismatch) -> Machine:
    """Return a machine with all that is off but its valves' edges and spools.

    Raises:
        MachineError: the machine lacks what is drawn.
    """
    crane = machine.manipulator
    mass, pendulum = m.head_mass * crane.head_mass if m.head is None else m.head, crane.pendulum
    if m.head is not None:
        hung = pendulum.rotator_mass if isinstance(pendulum, RotatorAndGrapple) else 0.0
        mass = max(mass, hung + LEAST_HEAD)
        if isinstance(pendulum, RotatorAndGrapple):
            heavier = (mass - hung) / (crane.head_mass - hung)
            pendulum = dataclasses.replace(pendulum, grapple_inertia=heavier * pendulum.grapple_inertia)
    crane = dataclasses.replace(
        crane, head_mass=mass, pendulum=pendulum, platform_tilt=crane.platform_tilt + m.tilt
    )
    swing, boom, stick = machine.drives
    machine = dataclasses.replace(
        machine,
        manipulator=crane,
        valve=_played(machine.valve, m),
        swing=dataclasses.replace(swing, **_own(machine, 0, m), backlash=_gear(machine, m)),
        boom=dataclasses.replace(boom, **_own(machine, 1, m)),
        stick=dataclasses.replace(stick, **_own(machine, 2, m)),
        oil=_stiff(machine.oil, m),
    )
    return machine if m.oil is None else at_temperature(machine, m.oil)


def _own(machine: Machine, axis: int, m: Mismatch) -> dict[str, Any]:
    """Return an axis' own hose and valve, and its link."""
    own, hose = machine.drives[axis].valve, machine.hose_of(axis)
    if isinstance(hose, MeasuredHose):
        hose = dataclasses.replace(hose, capacitance=hose.capacitance / m.hoses[axis])
    elif hose.wall_modulus is not None:  # its oil is drawn by itself
        hose = dataclasses.replace(hose, wall_modulus=hose.wall_modulus * m.hoses[axis])
    return {"hose": hose, "valve": own and _played(own, m), "elasticity": _bent(machine, axis, m)}


def _bent(machine: Machine, axis: int, m: Mismatch) -> Elasticity | None:
    link = machine.drives[axis].elasticity
    return link and dataclasses.replace(link, stiffness=m.links[axis] * link.stiffness)


def _played(valve: Valve, m: Mismatch) -> Valve:
    """Return a valve with another hysteresis and dead time."""
    if m.hysteresis is not None:
        valve = dataclasses.replace(valve, hysteresis=m.hysteresis or None)
    if m.dead_time is not None:
        valve = dataclasses.replace(valve, dead_time=m.dead_time if m.dead_time >= LEAST_DEAD_TIME else None)
    return valve


def _gear(machine: Machine, m: Mismatch) -> Backlash | None:
    given = machine.swing.backlash
    if m.backlash is None or m.backlash < LEAST_FREE_WAY:
        return given if m.backlash is None else None
    if given is None:
        raise MachineError(f"{machine.name} has no swing.backlash to be drawn; allowed: 0, or a machine with")
    return dataclasses.replace(given, free_way=m.backlash)


def _stiff(oil: Oil | None, m: Mismatch) -> Oil | None:
    return oil and dataclasses.replace(oil, bulk_modulus=m.modulus * oil.bulk_modulus)


def _valve(valve: SpoolValve, axis: int, m: Mismatch) -> SpoolValve:
    law, lag = valve.law, valve.lag
    forward = _direction(law.forward, m.deadbands[2 * axis], m.gains[2 * axis])
    backward = _direction(law.backward, m.deadbands[2 * axis + 1], m.gains[2 * axis + 1])
    return valve._replace(
        law=law._replace(forward=forward, backward=backward),
        lag=lag._replace(frequency=m.spool * lag.frequency),
    )


def _direction(way: Direction, deadband: float, gain: float) -> Direction:
    """Return a direction whose flow at a drop is that much greater: resistances go with its square."""
    edge = way.deadband_voltage + deadband
    return Direction(
        max(edge, min(0.0, way.deadband_voltage)),  # an overlap does not become an underlap
        way.rated_voltage,
        way.resistance_1 / (gain * gain),
        way.resistance_2 / (gain * gain),
    )


def ranges_from(text: str) -> Ranges:
    """Return the ranges of a command line.

    Raises:
        argparse.ArgumentTypeError: one is unknown, no number, or out of its own range.
    """
    given: dict[str, float] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        if name not in Ranges._fields:
            raise argparse.ArgumentTypeError(f"{part!r}; allowed: NAME=NUMBER of {', '.join(Ranges._fields)}")
        try:
            given[name] = float(value)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{part!r}; allowed: {name}=NUMBER") from None
    try:
        require_ranges(Ranges(**given))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return Ranges(**given)


def require_ranges(ranges: Ranges) -> None:
    """Raise ValueError unless each range is within its own."""
    for name, given in ranges._asdict().items():
        low = LOWEST.get(name, 0.0)
        if given is not None and not low <= given <= HIGHEST[name]:
            raise ValueError(f"{name}={given:g}; allowed: {low:g} .. {HIGHEST[name]:g}")
