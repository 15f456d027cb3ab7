"""Physics that a machine file can say and a model may lack, with the size that a search starts from.

| name | the model gets | residuals look like |
|---|---|---|
| friction | dry friction of seals and slewing ring | a step where the speed changes its sign |
| backlash | play of the swing's gear | knocks and pauses where the swing's load changes sides |
| chambers | oil with free air in cylinders and motor | slower, lower oscillations after steps |
| hysteresis | play, dead time and slew limit of the spools | an opening apart between up and down, a delay |
| holding | counterbalance valves at boom and stick | a back pressure while the load is lowered |
| bending | boom and stick that bend, a column that twists | oscillations of the links after steps |
| pendulum | a head that hangs | a slow sway after each change of speed |
| leakage | spools that leak past their overlap | a load that sinks while its valve is shut |
| curve | notches: the opening grows with a power of the stroke | an error over the voltage, at any speed |

Sizes are usual ones of a crane; those that grow with the crane follow from its areas, masses and pressures.
"""

import dataclasses
from collections.abc import Callable, Collection
from typing import NamedTuple

from forest_description.hydraulics.load_holding_parameters import CounterbalanceValve
from forest_description.hydraulics.oil import EntrainedAir
from forest_description.hydraulics.valve_parameters import FlowCurve, Valve
from forest_description.machine import Machine
from forest_description.mechanics.drives import (
    Backlash,
    BearingFriction,
    CylinderChambers,
    CylinderDrive,
    Friction,
    MotorChambers,
)
from forest_description.mechanics.elasticity_parameters import Elasticity
from forest_description.mechanics.load import Pendulum
from forest_description.types import AXES
from forest_ident.measurements.parameter_path import SECTIONS, part_of, with_part

SEAL_PRESSURE, BREAKAWAY = 1.5e5, 1.5  # [Pa] on the piston; over Coulomb's: usual of good seals
RING = 0.03  # of the motor's greatest torque: usual of a greased slewing ring
DEAD_SHARE = 0.03  # of what the stroke sweeps: ports and pipes
FREE_WAY = 1.5e-3  # [rad] of the joint: half a millimetre between pinion and ring
SHARE_OF_AIR, ABSOLUTE = 0.005, 0.101325e6  # usual of mobile machines; [Pa] of a vented tank
PLAY, DEAD_TIME = 0.04, 0.008  # of the rated voltage, usual of valves without spool feedback; [s]
STROKE_TIME = 0.04  # [s] from the centre to full opening: what a pilot stage's flow allows
SETTING = 1.3  # times the pump's pressure, above any load that the crane was made for
SAG = 0.008  # [rad] by which the outstretched crane's weight bends a link: usual of welded beams
LEAK = 8.3e-8  # [m^3/s] past an edge at the pump's pressure, 5 mL/min: a good spool
POWER = 1.5  # of the stroke, with which the opening of notches grows
KNOTS = (0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)  # of the stroke


class Candidate(NamedTuple):
    """One kind of physics. Its `add` returns the machine with it; what the machine has stays."""

    name: str  # of --allow
    physics: str
    pattern: str  # what it leaves in residuals
    add: Callable[[Machine], Machine]
    rig: bool = False  # whether the valve's rig shows it: then its records tell, and no other
    parts: tuple[str, ...] = ()  # sections of an axis of which only its own damping record tells


def _friction(machine: Machine) -> Machine:
    for axis in ("boom", "stick"):
        drive = getattr(machine, axis)
        if drive.friction is None:
            force = SEAL_PRESSURE * drive.head_area
            seals = Friction(force, BREAKAWAY * force, stribeck_speed=0.012, smoothing_speed=0.002)
            machine = with_part(machine, f"{axis}.friction", seals)
    if machine.swing.friction is not None:
        return machine
    swing = machine.swing
    torque = RING * swing.gear_ratio * swing.motor_displacement * machine.pump.supply_pressure
    ring = BearingFriction(
        coulomb_torque=torque,
        breakaway_torque=BREAKAWAY * torque,
        stribeck_speed=0.01,
        stiffness=1e4 * torque,
        damping=50.0 * torque,
        elastic_share=0.8,
    )
    return with_part(machine, "swing.friction", ring)


def _backlash(machine: Machine) -> Machine:
    swing = machine.swing
    if swing.backlash is not None:
        return machine
    torque = swing.gear_ratio * swing.motor_displacement * machine.pump.supply_pressure
    # A motor's inertia grows as the power of 5/3 of its displacement: 0.0024 kg m2 at 45 cm3 a turn.
    inertia = 0.0024 * (swing.motor_displacement / 7.16e-6) ** (5.0 / 3.0)
    play = Backlash(FREE_WAY, inertia, stiffness=1e3 * torque, damping=0.4 * torque)
    return with_part(machine, "swing.backlash", play)


def _dead(drive: CylinderDrive) -> CylinderChambers:
    head, rod = (DEAD_SHARE * area * drive.stroke for area in (drive.head_area, drive.rod_area))
    return CylinderChambers(head, rod)


def _chambers(machine: Machine) -> Machine:
    for axis in ("boom", "stick"):
        if getattr(machine, axis).chambers is None:
            machine = with_part(machine, f"{axis}.chambers", _dead(getattr(machine, axis)))
    if machine.swing.chambers is None:
        # Half of the motor's displacement per turn is about a radian's three times, and as much of pipe.
        machine = with_part(machine, "swing.chambers", MotorChambers(14.0 * machine.swing.motor_displacement))
    if machine.oil is not None and machine.oil.air is None:
        air = EntrainedAir(SHARE_OF_AIR, 3e6, ABSOLUTE, 100.0)
        machine = with_part(machine, "oil.air", air)
    return machine


def _each_valve(machine: Machine, changed: Callable[[Valve], Valve]) -> Machine:
    for section in SECTIONS:
        valve = part_of(machine, section)
        if valve is not None:
            machine = with_part(machine, section, changed(valve))
    return machine


def _hysteresis(machine: Machine) -> Machine:
    def changed(valve: Valve) -> Valve:
        return dataclasses.replace(
            valve,
            hysteresis=valve.hysteresis or PLAY * valve.rated_voltage,
            dead_time=valve.dead_time or DEAD_TIME,
            spool_slew_limit=valve.spool_slew_limit or valve.rated_voltage / STROKE_TIME,
        )

    return _each_valve(machine, changed)


def _leakage(machine: Machine) -> Machine:
    def changed(valve: Valve) -> Valve:
        least = LEAK / machine.pump.supply_pressure
        return dataclasses.replace(valve, leakage_conductance=valve.leakage_conductance or least)

    return _each_valve(machine, changed)


def _curve(machine: Machine) -> Machine:
    def changed(valve: Valve) -> Valve:
        if valve.curve is not None:
            return valve
        back = valve.deadband_voltage if valve.backward is None else valve.backward.deadband_voltage
        edge = max(valve.deadband_voltage, back)
        volts = tuple(edge + s * (valve.rated_voltage - edge) for s in KNOTS[:-1])
        return dataclasses.replace(
            valve, curve=FlowCurve((*volts, valve.rated_voltage), tuple(1e-3 * s**POWER for s in KNOTS))
        )

    return _each_valve(machine, changed)


def _holding(machine: Machine) -> Machine:
    for axis in ("boom", "stick"):
        drive = getattr(machine, axis)
        if drive.chambers is None:
            machine = with_part(machine, f"{axis}.chambers", _dead(drive))
        edge = (drive.valve or machine.valve).minimum_resistance
        valve = CounterbalanceValve(
            setting=SETTING * machine.pump.supply_pressure,
            pilot_ratio=3.0,
            hysteresis=1e6,
            opening_range=5e6,
            minimum_resistance=edge / 7.0,
            check_resistance=edge / 20.0,
            response_time=0.01,
        )
        for port in (1,) if axis == "boom" else (1, 2):
            if getattr(drive, f"holding_{port}") is None:
                machine = with_part(machine, f"{axis}.holding_{port}", valve)
    return machine


def _bending(machine: Machine) -> Machine:
    m = machine.manipulator
    stick = m.gravity * (m.stick_mass * abs(m.stick_x) + m.head_mass * m.stick_length)
    reach = m.boom_length + m.stick_length
    boom = m.gravity * (
        m.boom_mass * abs(m.boom_x) + m.stick_mass * (m.boom_length + abs(m.stick_x)) + m.head_mass * reach
    )
    for axis, torque in (("swing", boom), ("boom", boom), ("stick", stick)):
        if getattr(machine, axis).elasticity is None:
            stiffness = torque / SAG
            link = Elasticity(stiffness, damping=1e-3 * stiffness, root_inertia=50.0)
            machine = with_part(machine, f"{axis}.elasticity", link)
    return machine


def _pendulum(machine: Machine) -> Machine:
    if machine.manipulator.pendulum is not None:
        return machine
    length, mass = 0.9, machine.manipulator.head_mass
    body = Pendulum(length, inertia=0.1 * mass * length**2, damping=0.1 * mass * length**2 * 3.3)
    return with_part(machine, "manipulator.pendulum", body)


def added(candidate: Candidate, machine: Machine, records: Collection[str]) -> tuple[Machine, list[str]]:
    """Return the machine with a candidate where records tell of it, and the axes of which none does.

    Args:
        candidate: whose physics are added.
        machine: that may lack them.
        records: names of the records that are fitted.

    Raises:
        MachineError: this crane cannot have them.
    """
    richer, untold = candidate.add(machine), []
    for axis in AXES if candidate.parts else ():
        keys = [key for key in (f"{axis}.{part}" for part in candidate.parts) if part_of(richer, key)]
        new = [key for key in keys if part_of(machine, key) is None]
        if new and f"damping_{axis}" not in records:
            untold.append(axis)
            for key in new:
                richer = with_part(richer, key, None)
    return richer, untold


CANDIDATES = (
    Candidate(
        "friction",
        "dry friction",
        "a step where the speed changes its sign",
        _friction,
        parts=("friction",),
    ),
    Candidate(
        "backlash",
        "backlash of the swing's gear",
        "knocks and pauses where the swing's load changes sides",
        _backlash,
    ),
    Candidate(
        "chambers",
        "oil in cylinders and motor, with free air",
        "a slower, lower oscillation after each change of speed",
        _chambers,
    ),
    Candidate(
        "hysteresis",
        "hysteresis and dead time of the spools",
        "an opening that lies apart for rising and falling voltage, and comes late",
        _hysteresis,
        rig=True,
    ),
    Candidate(
        "holding",
        "load-holding valves",
        "a back pressure while the load is lowered",
        _holding,
        parts=("holding_1", "holding_2", "chambers"),
    ),
    Candidate("bending", "links that bend", "oscillations of the links after each change of speed", _bending),
    Candidate("pendulum", "a head that hangs", "a slow sway after each change of speed", _pendulum),
    Candidate("leakage", "spools that leak", "a load that sinks while its valve is shut", _leakage),
    Candidate(
        "curve",
        "a valve whose opening is not straight over the voltage",
        "an error of the flow over the voltage",
        _curve,
        rig=True,
    ),
)
ADDED = (
    *("oil.air", "manipulator.pendulum"),
    *(f"{axis}.{part}" for axis in AXES for part in ("friction", "chambers", "elasticity")),
    *("swing.backlash", "boom.holding_1", "stick.holding_1", "stick.holding_2"),
    *(
        f"{section}.{part}"
        for section in SECTIONS
        for part in ("hysteresis", "dead_time", "spool_slew_limit", "curve", "leakage_conductance")
    ),
)
"""Sections and numbers that candidates add."""
NAMES = tuple(candidate.name for candidate in CANDIDATES)
