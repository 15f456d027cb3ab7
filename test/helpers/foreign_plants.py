"""Cranes with structure that a fit's start model lacks: what identification does with another make.

| structure | what the crane has, and the told machine lacks |
|---|---|
| own | nothing: only its numbers differ |
| chambers | oil with free air in cylinders and motor |
| spool_play | hysteresis, dead time and a slew limit of the valves |
| dry_friction | seals with a Stribeck peak, a slewing ring that sticks (LuGre), backlash of its gear |
| flexible_links | boom and stick that bend, a column that twists |
| counterbalance | load-holding valves at boom and stick, and the oil that they hold |
| load_sensing | a load-sensing pump, and compensators behind the spools that share the flow |
| pendulum | a head that hangs and swings |
| curved_valve | notches: the opening grows with a power of the stroke |

Structure and first numbers come from the shipped machines; every number of them, and each that identification
looks for, is drawn. The crane is simulated by the laws that the fit could use, if it were told of them: this
judges what a *missing* structure does to a fit, not the laws.
"""

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError, parameter_of
from forest_description.config.random_machine import BY_DIRECTION, DRAWN
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.hydraulics.valve_parameters import FlowCurve
from forest_description.machine import Machine, load_machine
from forest_description.mechanics.load import Pendulum
from forest_ident.measurements.parameter_path import (
    part_of,
    value_of,
    with_directions,
    with_part,
    with_values,
)

TOLD = "c180_hoses"
"""What the person believes the crane to be; the fit starts from it."""
AS_BUILT, FORWARDER = "c180", "forwarder"  # whose sections the crane has besides
WITHIN = 0.4  # share by which a number is drawn to either side
SCALE = 0.02  # share by which a mass is known that was weighed with a crane's scale or read off a drawing
TAPE = 0.005  # [m] by which a length is known that was measured with a tape
MASSES = ("base_mass", "boom_mass", "stick_mass", "head_mass")
LENGTHS = ("boom_length", "stick_length", "base_offset", "boom_x", "stick_x")
LINKAGE = ("retracted_length", "pivot_to_base", "pivot_to_rod")
ATTEMPTS = 200  # draws, until one is a machine
KNOTS = (0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)  # of the stroke, where a curved valve's flow is told


class Foreign(NamedTuple):
    """A crane, and what is told of it."""

    structure: str
    crane: Machine
    told: Machine
    drawn: tuple[str, ...]  # keys that identification looks for, as drawn


def _from(donor: str, *paths: str) -> Callable[[Machine], Machine]:
    """Return what adds sections of another machine."""

    def added(machine: Machine) -> Machine:
        other = load_machine(donor)
        for path in paths:
            machine = with_part(machine, path, part_of(other, path))
        return machine

    return added


def _load_sensing(machine: Machine) -> Machine:
    """Return a machine whose own pump senses the load, with compensators behind the spools."""
    other = load_machine(FORWARDER)
    own = {f.name: getattr(machine.pump, f.name) for f in dataclasses.fields(machine.pump)}
    assert isinstance(other.pump, LoadSensingPump)
    pump = LoadSensingPump(**own, margin=other.pump.margin, response_time=other.pump.response_time)
    machine = dataclasses.replace(machine, pump=pump)
    return with_part(machine, "valve.compensator", other.valve.compensator)


def _pendulum(machine: Machine) -> Machine:
    return with_part(machine, "manipulator.pendulum", Pendulum(length=0.9, inertia=60.0, damping=250.0))


class _Structure(NamedTuple):
    add: Callable[[Machine], Machine]
    paths: tuple[str, ...]  # sections and numbers that are drawn


def _added(donor: str, *paths: str) -> _Structure:
    return _Structure(_from(donor, *paths), paths)


_STRUCTURES = {
    "own": _Structure(lambda machine: machine, ()),
    "chambers": _added(AS_BUILT, "oil.air", "swing.chambers", "boom.chambers", "stick.chambers"),
    "spool_play": _added(AS_BUILT, "valve.hysteresis", "valve.dead_time", "valve.spool_slew_limit"),
    "dry_friction": _added(AS_BUILT, "swing.friction", "swing.backlash", "boom.friction", "stick.friction"),
    "flexible_links": _added(FORWARDER, "swing.elasticity", "boom.elasticity", "stick.elasticity"),
    "counterbalance": _added(
        *(AS_BUILT, "boom.chambers", "stick.chambers"),
        *("boom.holding_1", "stick.holding_1", "stick.holding_2"),
    ),
    "load_sensing": _Structure(_load_sensing, ("pump.margin", "pump.response_time", "valve.compensator")),
    "pendulum": _Structure(_pendulum, ("manipulator.pendulum",)),
    "curved_valve": _Structure(lambda machine: machine, ()),
}
STRUCTURES = tuple(_STRUCTURES)


def foreign(structure: str, seed: int) -> Foreign:
    """Return a drawn crane of a structure; equal arguments give equal cranes.

    Args:
        structure: one of `STRUCTURES`.
        seed: of everything that is drawn. A draw that no machine file may hold (a breakaway force below the
            sliding one) is drawn again.
    """
    told, made = load_machine(TOLD), _STRUCTURES[structure]
    for attempt in range(ATTEMPTS):
        generator = np.random.default_rng([seed, STRUCTURES.index(structure), attempt])
        try:
            crane, keys = _drawn(made.add(told), generator)
            for path in made.paths:
                crane = with_part(crane, path, _varied(part_of(crane, path), generator))
            if structure == "curved_valve":
                crane = with_part(crane, "valve.curve", _curve(crane, generator))
        except MachineError:
            continue
        return Foreign(structure, dataclasses.replace(crane, name=f"{structure}:{seed}"), told, keys)
    raise MachineError(f"no {structure} of seed {seed} is a machine after {ATTEMPTS} draws")


def _share(generator: np.random.Generator, within: float) -> float:
    return 1.0 + float(generator.uniform(-within, within))


def _drawn(machine: Machine, generator: np.random.Generator) -> tuple[Machine, tuple[str, ...]]:
    """Return the machine with all that identification looks for drawn, and with a person's errors."""
    machine = with_directions(machine, "valve")
    names = [*(f"valve.{n}" for n in DRAWN[:3]), *(f"valve.backward.{n}" for n in BY_DIRECTION)]
    names += [f"hose.{n}" for n in DRAWN[3:7]]
    names += [f"swing.{n}" for n in DRAWN[7:]] + ["boom.damping", "stick.damping"]
    values = {key: value_of(machine, key) * _share(generator, WITHIN) for key in names}
    masses = [f"manipulator.{name}" for name in MASSES]
    values |= {key: value_of(machine, key) * _share(generator, SCALE) for key in masses}
    lengths = [f"manipulator.{name}" for name in LENGTHS]
    lengths += [f"{axis}.{name}" for axis in ("boom", "stick") for name in LINKAGE]
    values |= {key: value_of(machine, key) + float(generator.uniform(-TAPE, TAPE)) for key in lengths}
    return with_values(machine, values), (*names, *masses)


def _varied(
    part: object, generator: np.random.Generator, allowed: tuple[float, float] | None = None
) -> object:
    """Return a number, or every number of a section, drawn within the share, inside its allowed range."""
    if isinstance(part, float):
        value = part * _share(generator, WITHIN)
        return value if allowed is None else min(max(value, allowed[0]), allowed[1])
    assert dataclasses.is_dataclass(part)
    assert not isinstance(part, type)
    changes = {}
    for field in dataclasses.fields(part):
        number, bounds = getattr(part, field.name), parameter_of(field)
        if isinstance(number, float) and bounds is not None:
            changes[field.name] = _varied(number, generator, (bounds.low, bounds.high))
    return dataclasses.replace(part, **changes)


def _curve(machine: Machine, generator: np.random.Generator) -> FlowCurve:
    """Return a progressive curve: the flow at one drop grows with the stroke to a power of 1.2 to 2."""
    valve, power = machine.valve, float(generator.uniform(1.2, 2.0))
    assert valve.backward is not None
    edge = max(valve.deadband_voltage, valve.backward.deadband_voltage)
    volts = tuple(edge + s * (valve.rated_voltage - edge) for s in KNOTS[:-1])
    return FlowCurve((*volts, valve.rated_voltage), tuple(1e-3 * s**power for s in KNOTS))
