"""Machines that differ by chance from what controller and driver believe: valves, load, spools.

| what | drawn | default |
|---|---|---|
| deadband | of every valve and direction, off by as much as +-deadband, evenly; not under 0 | 0.15 V |
| gain | of every valve and direction: flow at a drop, times 1 -+ gain, evenly | 0.4 |
| head_mass | times 1/head_mass .. head_mass, its logarithm evenly | 2 |
| spool | bandwidth of all spools, likewise; one that follows at once stays | 1.5 |

What is drawn is the simulated machine; what controller and driver believe stays. Equal seeds draw equal
machines, whatever else is drawn from them.
"""

import argparse
import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from forest_description.components.valve_characteristic import Direction
from forest_description.machine import Machine
from forest_sim.equations.plant_parameters import PlantParameters, SpoolValve, parameters_of

STREAM = 2  # of a seed's draws; a sensor suite's are 0 and 1
HIGHEST = {"deadband": 1.0, "gain": 0.9, "head_mass": 10.0, "spool": 10.0}
LOWEST = {"deadband": 0.0, "gain": 0.0, "head_mass": 1.0, "spool": 1.0}
HELP = (
    "every run's machine is drawn: valves' deadbands and gains, head, spools; RANGES: "
    "deadband=0.15,gain=0.4,head_mass=2,spool=1.5 or some of them (these are the defaults)"
)


class Ranges(NamedTuple):
    """How far a machine may be off."""

    deadband: float = 0.15  # [V]
    gain: float = 0.4
    head_mass: float = 2.0
    spool: float = 1.5


class Mismatch(NamedTuple):
    """How far one is; sixes are swing forward, backward, boom forward and so on."""

    deadbands: tuple[float, ...]  # [V] added
    gains: tuple[float, ...]  # factors
    head_mass: float  # factor
    spool: float  # factor of the bandwidth

    def told(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {**self._asdict(), "deadbands": list(self.deadbands), "gains": list(self.gains)}


def draw(seed: int, ranges: Ranges) -> Mismatch:
    """Return a seed's machine."""
    chance = np.random.default_rng([seed, STREAM]).uniform(-1.0, 1.0, 14).tolist()
    return Mismatch(
        deadbands=tuple(ranges.deadband * x for x in chance[:6]),
        gains=tuple(1.0 + ranges.gain * x for x in chance[6:12]),
        head_mass=math.exp(chance[12] * math.log(ranges.head_mass)),
        spool=math.exp(chance[13] * math.log(ranges.spool)),
    )


def applied(machine: Machine, m: Mismatch) -> PlantParameters:
    """Return the kernel's parameters of a machine that is so far off."""
    crane = machine.manipulator
    crane = dataclasses.replace(crane, head_mass=m.head_mass * crane.head_mass)
    p = parameters_of(dataclasses.replace(machine, manipulator=crane))
    one, two, three = (_valve(p.valves[i], i, m) for i in range(3))
    return p._replace(valves=(one, two, three))


def _valve(valve: SpoolValve, axis: int, m: Mismatch) -> SpoolValve:
    law, lag = valve.law, valve.lag
    forward = _direction(law.forward, m.deadbands[2 * axis], m.gains[2 * axis])
    backward = _direction(law.backward, m.deadbands[2 * axis + 1], m.gains[2 * axis + 1])
    return SpoolValve(
        law._replace(forward=forward, backward=backward), lag._replace(frequency=m.spool * lag.frequency)
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
        if not LOWEST[name] <= given[name] <= HIGHEST[name]:
            raise argparse.ArgumentTypeError(f"{part!r}; allowed: {LOWEST[name]:g} .. {HIGHEST[name]:g}")
    return Ranges(**given)
