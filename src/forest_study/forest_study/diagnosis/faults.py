"""The faults that are injected in mid-run, each at three severities; an axis goes by the seed.

| fault | what is changed |
|---|---|
| sticking spool | play of the spool; the worst is stuck where it is |
| slow spool | bandwidth and slew limit |
| leaking cylinder, motor | leakage past piston or rotor, at 10 MPa |
| load holding | leakage from each port to the tank, past holding valve and spool, or outside, at 10 MPa |
| worn pump | leakage, as a share of full flow at full pressure |
| biased, frozen, missing | one sensor's channel |
| cold oil | temperature, from the start |
| air | free air in the oil, at tank pressure |
| deadband | overlap of one direction |
| machine file | true areas of the cylinders, from the start |
"""

import dataclasses
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.actuator import leaking
from forest_sim.sensors.sensor_model import ABSENT, FROZEN, SensorModel
from forest_sim.sensors.sensor_suite import CHANNELS

Channels = tuple[SensorModel, ...]
Amount = Any  # of a severity
LITRE_AT_10_MPA = 1e-3 / 60.0 / 1e7  # [m^3/(s Pa)] per L/min
ICE = 273.15  # [K]


class Injected(NamedTuple):
    """What a fault changes."""

    plant: Callable[[PlantParameters], PlantParameters] = lambda p: p
    channels: Callable[[Channels], Channels] = lambda c: c
    temperature: float | None = None  # [K] of the oil, from the start
    true_machine: Callable[[Machine], Machine] = lambda m: m
    from_start: bool = False


class Fault(NamedTuple):
    """A fault and its severities."""

    text: str  # of a severity: "{} L/min"
    amounts: tuple[Amount, Amount, Amount]
    axes: tuple[int, ...]  # that it may hit; the seed chooses
    inject: Callable[[Amount, int], Injected]
    found_as: tuple[str, ...]  # causes of `findings` that name it, {axis} for the one that is hit


HEALTHY = Injected()


def _with_axis(p: PlantParameters, axis: int, **changes: Any) -> PlantParameters:
    name = AXES[axis]
    return p._replace(**{name: getattr(p, name)._replace(**changes)})


def _with_valve(p: PlantParameters, axis: int, **changes: Any) -> PlantParameters:
    valves = list(p.valves)
    valves[axis] = valves[axis]._replace(**changes)
    return p._replace(valves=(valves[0], valves[1], valves[2]))


def _sticks(play: float, axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        lag = p.valves[axis].lag
        lag = lag._replace(frequency=0.0) if math.isinf(play) else lag._replace(play=lag.play + play)
        return _with_valve(p, axis, lag=lag)

    return Injected(plant)


def _slows(share: float, axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        lag = p.valves[axis].lag
        return _with_valve(p, axis, lag=lag._replace(frequency=share * lag.frequency, slew=share * lag.slew))

    return Injected(plant)


def _leaks(litres: float, axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        return _with_axis(p, axis, actuator=leaking(p.axes[axis].actuator, litres * LITRE_AT_10_MPA, 0.0))

    return Injected(plant)


def _drips(litres: float, axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        return _with_axis(p, axis, actuator=leaking(p.axes[axis].actuator, 0.0, litres * LITRE_AT_10_MPA))

    return Injected(plant)


def _wears(share: float, _axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        s = p.supply
        return p._replace(supply=s._replace(leakage=s.leakage + share * s.flow_limit / s.set_pressure))

    return Injected(plant)


def _channel(names: tuple[str, ...], change: Callable[[SensorModel], SensorModel], axis: int) -> Injected:
    at = CHANNELS.index(names[axis])

    def channels(c: Channels) -> Channels:
        return (*c[:at], change(c[at]), *c[at + 1 :])

    return Injected(channels=channels)


def _biased(names: tuple[str, ...], bias: float, axis: int) -> Injected:
    return _channel(names, lambda c: c._replace(bias=c.bias + bias), axis)


def _broken(mode: int, which: tuple[str, ...], axis: int) -> Injected:
    return _channel(which, lambda c: c._replace(mode=mode), axis)


def _chills(celsius: float, _axis: int) -> Injected:
    return Injected(temperature=celsius + ICE, from_start=True)


def _foams(share: float, _axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        for axis in range(3):
            one, two = p.axes[axis].oil_1, p.axes[axis].oil_2
            oil = one.oil._replace(air=share)
            p = _with_axis(p, axis, oil_1=one._replace(oil=oil), oil_2=two._replace(oil=oil))
        return p._replace(supply=p.supply._replace(oil=p.supply.oil._replace(air=share)))

    return Injected(plant)


def _drifts(volts: float, axis: int) -> Injected:
    def plant(p: PlantParameters) -> PlantParameters:
        law = p.valves[axis].law
        way = law.forward._replace(deadband_voltage=law.forward.deadband_voltage + volts)
        return _with_valve(p, axis, law=law._replace(forward=way))

    return Injected(plant)


def _other_areas(share: float, _axis: int) -> Injected:
    def true_machine(m: Machine) -> Machine:
        boom, stick = (
            dataclasses.replace(d, head_area=(1.0 + share) * d.head_area, rod_area=(1.0 + share) * d.rod_area)
            for d in (m.boom, m.stick)
        )
        return dataclasses.replace(m, boom=boom, stick=stick)

    return Injected(true_machine=true_machine, from_start=True)


RESOLVERS = tuple(f"{axis}_resolver" for axis in AXES)
TRANSDUCERS = ("", "boom_transducer", "stick_transducer")
PRESSURES = tuple(f"{axis}_pressure_2_actuator" for axis in AXES)
KINDS = RESOLVERS, TRANSDUCERS, PRESSURES
ALL, CYLINDERS = (0, 1, 2), (1, 2)
SPOOL = ("{axis} spool",)
BIASED = ("{axis} length",)
FAULTS: dict[str, Fault] = {
    "sticking spool": Fault("{} V of play", (0.8, 1.6, math.inf), ALL, _sticks, SPOOL),
    "slow spool": Fault("{} of its bandwidth", (0.3, 0.15, 0.05), ALL, _slows, SPOOL),
    "leaking cylinder": Fault("{} L/min", (0.3, 1.0, 3.0), CYLINDERS, _leaks, ("{axis} piston",)),
    "leaking motor": Fault("{} L/min", (1.0, 3.0, 10.0), (0,), _leaks, ("{axis} piston",)),
    "load holding": Fault("{} L/min", (0.1, 0.3, 1.0), CYLINDERS, _drips, ("{axis} holding",)),
    "worn pump": Fault("{} of its flow", (0.1, 0.2, 0.4), (0,), _wears, ("machine pump",)),
    "biased resolver": Fault("{} rad", (0.0035, 0.0087, 0.035), ALL, partial(_biased, RESOLVERS), BIASED),
    "biased transducer": Fault("{} m", (0.003, 0.01, 0.03), CYLINDERS, partial(_biased, TRANSDUCERS), BIASED),
    "biased pressure": Fault(
        "{:g} Pa", (1e5, 5e5, 2e6), ALL, partial(_biased, PRESSURES), ("{axis} pressure",)
    ),
    "frozen sensor": Fault(
        "{0[1]}", KINDS, CYLINDERS, lambda a, i: _broken(FROZEN, a, i), ("sensors frozen",)
    ),
    "missing sensor": Fault(
        "{0[1]}", KINDS, CYLINDERS, lambda a, i: _broken(ABSENT, a, i), ("sensors missing",)
    ),
    "cold oil": Fault("{} degrees Celsius", (10.0, 0.0, -10.0), (0,), _chills, ("machine cold",)),
    "air": Fault(
        "{} of the oil",
        (0.015, 0.04, 0.1),
        (0,),
        _foams,
        ("swing stiffness", "boom stiffness", "stick stiffness"),
    ),
    "deadband drift": Fault("{} V", (0.1, 0.2, 0.4), ALL, _drifts, ("{axis} deadband",)),
    "machine file": Fault("{} of the areas", (0.1, 0.2, 0.4), (0,), _other_areas, ("machine machine file",)),
}
SEVERITIES = ("mild", "medium", "severe")
HEALTH = "healthy"
CASES = (HEALTH, *(f"{name}, {severity}" for name in FAULTS for severity in SEVERITIES))
"""What a run may have: "worn pump, mild"."""


def injected(case: str, seed: int) -> Injected:
    """Return the fault of a case for a seed, which chooses its axis."""
    if case == HEALTH:
        return HEALTHY
    name, _, severity = case.partition(", ")
    fault = FAULTS[name]
    return fault.inject(fault.amounts[SEVERITIES.index(severity)], _axis(fault, seed))


def right_causes(case: str, seed: int) -> tuple[str, ...]:
    """Return which findings name a case, as "boom spool"; none of a healthy machine."""
    if case == HEALTH:
        return ()
    fault = FAULTS[case.partition(", ")[0]]
    return tuple(text.format(axis=AXES[_axis(fault, seed)]) for text in fault.found_as)


def _axis(fault: Fault, seed: int) -> int:
    return fault.axes[seed % len(fault.axes)]
