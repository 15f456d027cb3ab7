"""The experiments of Thesis section 4.3 and three more: preparation, programme of voltages, limits.

| experiment | rig | identifies |
|---|---|---|
| valve | valve alone (fig. 4.3) | C_R(V), overlap and gain by direction and port |
| spool_lag | the same | how the spool follows |
| compensator | the same, its load takes all of the pump's pressure | a valve's pressure compensator |
| hose, hose_laminar | hose alone (fig. 4.5, 4.7) | R; I and C (not with laminar) |
| motor_external | crane, swing to and fro (fig. 4.9) | R_ex |
| motor_internal | crane on a tilted platform, valve shut (fig. 4.9) | R_in |
| damping_AXIS | crane, one axis at several speeds | B (fig. 4.11) |
| deadband_AXIS | crane, one axis through its overlap, slowly | overlap by direction, from motion |
| gravity | crane, boom and stick from pose to pose | whether load and masses are those of the file |
| validation | crane, all axes | nothing: held out |

A machine whose axes have valves or hoses of their own gets `valve_AXIS`, `compensator_AXIS`, `hose_AXIS` for
each of these. Valves without a pressure compensator get no `compensator`.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from forest_description.derived.limits import joint_limits, pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import joint_angle
from forest_description.machine import Machine
from forest_description.mechanics.drives import CylinderDrive
from forest_description.types import AXES, Vec3
from forest_ident.experiments import rigs
from forest_ident.experiments.excitation import Programme, Row, Track, stairs

TILT = 0.15  # [rad] of the platform for the internal leakage
SWING_ROOM = 1.2  # [rad] to either side
MARGIN = 0.15  # of the stroke that stays free at either end
POSE = 6.5  # [s] from pose to pose: moving, then resting until the crane has stopped swinging
ENDLESS = 1e9  # [rad] a bench's meter turns on and on
CRANE_LIMITS = (
    "Nobody within the crane's reach; hand on the emergency stop. An axis turns round "
    f"{100.0 * MARGIN:.0f} % of its stroke before its ends, the swing {math.degrees(SWING_ROOM):.0f} degrees "
    "to either side of where it starts."
)
BENCH_LIMITS = (
    "Hoses and couplings rated for twice the supply pressure, a guard over them; relief valve set and tested "
    "first. Stop above 350 K of oil."
)


class Plan(NamedTuple):
    """An experiment on a certain machine."""

    name: str
    machine: Machine  # as prepared: a rig, or the crane, tilted or not
    programme: Programme
    angles: Vec3  # [rad] at the start
    setup: str
    metadata: dict[str, float]
    bench: bool = False
    tip: Vec3 = (math.nan, math.nan, math.nan)  # [m] at the start

    @property
    def limits(self) -> str:
        """What keeps people and machine safe."""
        return BENCH_LIMITS if self.bench else CRANE_LIMITS


def names(machine: Machine) -> tuple[str, ...]:
    """Return the experiments that this machine needs, in the order in which they are evaluated."""
    own_valves = [f"valve_{axis}" for axis in AXES if getattr(machine, axis).valve is not None]
    own_hoses = [f"hose_{axis}" for axis in AXES if getattr(machine, axis).hose is not None]
    shared_valve = [] if len(own_valves) == len(AXES) else ["valve"]
    valves = [*shared_valve, *own_valves]
    compensators = [
        name.replace("valve", "compensator")
        for name in valves
        if machine.valve_of(_valve_axis(machine, name)).compensator is not None
    ]
    regimes = {drive.flow_regime for drive in machine.drives if drive.hose is None}
    shared = [name for name, flag in (("hose", "turbulent"), ("hose_laminar", "laminar")) if flag in regimes]
    return (
        *("calibration", *valves, "spool_lag", *compensators, *shared, *own_hoses),
        *("gravity", "motor_external", "motor_internal"),
        *(f"deadband_{axis}" for axis in AXES),
        *(f"damping_{axis}" for axis in AXES),
        "validation",
    )


def plan(name: str, machine: Machine, seed: int = 0, longest: float = math.inf) -> Plan:
    """Return an experiment's plan for a machine.

    Args:
        name: one of `names`, but "calibration", which drives nothing.
        machine: the crane.
        seed: of the levels that are drawn by lot.
        longest: time at which it is cut off, for a trial [s].

    Raises:
        KeyError: there is no such experiment.
    """
    found = _plan(name, machine, seed)
    tip = tip_position(found.angles, found.machine.manipulator.links)
    programme = found.programme._replace(duration=min(found.programme.duration, longest))
    angles = pose_at(tip, found.machine)  # as a simulator computes it that gets the tip
    return found._replace(programme=programme, tip=tip, angles=angles)


def _plan(name: str, machine: Machine, seed: int) -> Plan:
    kind, _, axis_name = name.partition("_")
    own = axis_name in AXES
    axis = AXES.index(axis_name) if own else 0
    of_valve = {"valve": _valve, "compensator": _compensator}
    if kind in of_valve:
        return of_valve[kind](name, machine, _valve_axis(machine, name))
    if name == "spool_lag":
        return _spool_lag(machine)
    if kind == "hose":
        laminar = machine.drives[axis].flow_regime == "laminar" if own else axis_name == "laminar"
        return _hose(name, machine, axis if own else _shared_hose_axis(machine), laminar)
    if kind == "damping" and own:
        levels = tuple(machine.valve_of(axis).rated_voltage * k for k in (0.25, 0.5, 0.35, 0.6, 0.2, 0.45))
        setup = "Crane without load, oil warm, engine at its governed speed."
        return _crane(name, machine, setup, {axis: stairs(levels, 1.6)}, 70.0)
    if kind == "deadband" and own:
        low, high = (k * machine.valve_of(axis).rated_voltage for k in (0.03, 0.24))
        setup = "Crane without load, oil warm. The axis hardly moves: that is what is wanted."
        rows = {axis: (Row(9.0, low, high), Row(9.0, high, low))}
        return _crane(name, machine, setup, rows, 110.0, alternate=True)
    crane = {
        "motor_internal": _motor_internal,
        "motor_external": _motor_external,
        "gravity": _gravity,
    }
    return _validation(machine, seed) if name == "validation" else crane[name](machine)


def _valve_axis(machine: Machine, name: str) -> int:
    """Return the axis whose valve an experiment has on its rig."""
    tail = name.partition("_")[2]
    return AXES.index(tail) if tail in AXES else shared_valve_axis(machine)


def shared_valve_axis(machine: Machine) -> int:
    """Return an axis that has the valve that all share; the swing if none has."""
    return next((axis for axis in range(3) if machine.drives[axis].valve is None), 0)


def _shared_hose_axis(machine: Machine) -> int:
    """Return an axis that has the hose that all share."""
    return next((axis for axis in range(3) if machine.drives[axis].hose is None), 0)


def _bench(
    name: str, machine: Machine, rig: Machine, setup: str, rows: tuple[Row, ...], total: float = 0.0
) -> Plan:
    """Return the plan of an experiment on a rig; by default its rows are driven once each way."""
    duration = total or 2.0 * sum(row.duration for row in rows) + 2.0
    track = Track(rows, -ENDLESS, ENDLESS, alternate=True)
    programme = Programme((track, None, None), duration)
    return Plan(
        name=name,
        machine=rig,
        programme=programme,
        angles=_start(machine),
        setup=setup,
        metadata={},
        bench=True,
    )


def _valve(name: str, machine: Machine, axis: int) -> Plan:
    rated = machine.valve_of(axis).rated_voltage
    fine, coarse = np.arange(0.02, 0.22, 0.01) * rated, np.arange(0.22, 1.001, 0.06) * rated
    setup = (
        "Take the valve off the crane. Port 1 through a flow meter, a braked metering motor and the second "
        "meter back to port 2; supply and tank as on the crane. Pressure transducers of the swing at both "
        "ports, one in the supply. Oil through the cooler at one temperature."
    )
    return _bench(name, machine, rigs.valve_bench(machine, axis), setup, stairs((*fine, *coarse), 0.6))


def _spool_lag(machine: Machine) -> Plan:
    rated = machine.valve_of(0).rated_voltage
    rows = stairs((0.3 * rated, 0.7 * rated, 0.45 * rated, 0.9 * rated), 0.11)
    setup = "As for the valve. The spool sensor and the amplifier's voltage on one clock."
    return _bench("spool_lag", machine, rigs.valve_bench(machine), setup, rows, 16.0)


def _compensator(name: str, machine: Machine, axis: int) -> Plan:
    rated = machine.valve_of(axis).rated_voltage
    levels = tuple(rated * share for share in (0.3, 0.45, 0.6, 0.75, 1.0, 0.5, 0.9, 0.4, 0.7, 0.35))
    setup = (
        "As for the valve. Brake the metering motor until the flow grows no more from two thirds of the "
        "valve's stroke on: there the pump is at its greatest pressure."
    )
    return _bench(name, machine, rigs.overloaded_bench(machine, axis), setup, stairs(levels, 0.8))


def _hose(name: str, machine: Machine, axis: int, laminar: bool) -> Plan:
    rig = rigs.hose_bench(machine, axis, laminar)
    rated = rig.valve_of(0).rated_voltage
    levels = tuple(rated * share for share in (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0))
    groups = [
        stairs((low * rated, high * rated) * round(5.0 / (2.0 * hold)), hold)
        for low, high, hold in ((0.35, 0.6, 0.35), (0.4, 0.7, 0.25), (0.35, 0.7, 0.15), (0.4, 0.8, 0.2))
    ]
    rows = (*stairs(levels, 1.4), *(row for group in groups for row in group))
    length = rigs.as_measured(machine, machine.hose_of(axis)).length
    setup = (
        f"A piece of the hose, {length:g} m, straight, between the valve's port 1 and the braked metering "
        "motor; flow meter and pressure transducer at its entrance, the others at its exit. Bleed it. Oil "
        "through the cooler at one temperature"
        + (", thick enough for laminar flow (Reynolds' number under 2000)." if laminar else ".")
    )
    metadata = {"hose_length": length, "hose_axis": float(axis), "laminar": float(laminar)}
    return _bench(name, machine, rig, setup, rows)._replace(metadata=metadata)


def _crane(
    name: str,
    machine: Machine,
    setup: str,
    rows: Mapping[int, tuple[Row, ...]],
    duration: float,
    alternate: bool = False,
) -> Plan:
    """Return the plan of an experiment on the crane: the rows of each axis that is driven."""
    start = _start(machine)
    ranges = (
        _swing_range(machine, start[0]),
        *(cylinder_range(drive, MARGIN) for drive in machine.drives[1:]),
    )
    tracks = [Track(rows[axis], *ranges[axis], alternate) if axis in rows else None for axis in range(3)]
    programme = Programme((tracks[0], tracks[1], tracks[2]), duration)
    return Plan(name=name, machine=machine, programme=programme, angles=start, setup=setup, metadata={})


def _motor_internal(machine: Machine) -> Plan:
    links = dataclasses.replace(machine.manipulator, platform_tilt=TILT)
    tilted = dataclasses.replace(machine, manipulator=links)
    setup = (
        f"Turn the crane square to the way the platform will tilt, stretch it, then tilt the platform by "
        f"{math.degrees(TILT):.1f} degrees, so that its weight drives the swing. Swing valve shut: the "
        "crane creeps."
    )
    still = _crane("motor_internal", tilted, setup, {}, 100.0)
    angles = (0.9, *_start(machine)[1:])
    return still._replace(angles=angles, metadata={"platform_tilt": TILT})  # for cranes without inclinometer


def _motor_external(machine: Machine) -> Plan:
    rated = machine.valve_of(0).rated_voltage
    rows = stairs(tuple(rated * share for share in (0.3, 0.4, 0.25, 0.35)), 2.5)
    setup = (
        "Lead the motor's case drain into a measured vessel, or through its own meter. Empty the vessel when "
        "the record starts; read it when it ends, and write the volume under case_drain_volume."
    )
    return _crane("motor_external", machine, setup, {0: rows}, 70.0)


def _gravity(machine: Machine) -> Plan:
    rows = {
        axis: (*stairs((0.35 * machine.valve_of(axis).rated_voltage,), hold), *stairs((0.0,), POSE - hold))
        for axis, hold in ((1, 1.1), (2, 1.7))
    }
    setup = "Crane with the head it works with, no log. It moves from pose to pose and rests."
    return _crane("gravity", machine, setup, rows, 60.0)


def _validation(machine: Machine, seed: int) -> Plan:
    generator, rows = np.random.default_rng([seed, 44]), {}
    for axis in range(3):
        levels = machine.valve_of(axis).rated_voltage * generator.uniform(0.15, 0.55, 12)
        rows[axis] = stairs(tuple(levels.tolist()), 0.7 + 0.2 * axis)
    setup = "Crane without load, oil warm. This record is held out: it checks the model."
    return _crane("validation", machine, setup, rows, 40.0, alternate=True)


def cylinder_range(drive: CylinderDrive, margin: float) -> tuple[float, float]:
    """Return the joint angles [rad] at which a cylinder is a share of its stroke from either end."""
    ends = (drive.retracted_length + share * drive.stroke for share in (margin, 1.0 - margin))
    low, high = sorted(joint_angle(length, drive.linkage) for length in ends)
    return low, high


def _swing_range(machine: Machine, start: float) -> tuple[float, float]:
    """Return the angles [rad] between which the swing goes to and fro."""
    low, high = joint_limits(machine)[0]
    return max(low, start - SWING_ROOM), min(high, start + SWING_ROOM)


def _start(machine: Machine) -> Vec3:
    """Return where the crane starts [rad]: as the simulator does, if that is within the soft limits."""
    swing, *others = pose_at(start_tip(machine), machine)
    ranges = (cylinder_range(machine.boom, MARGIN), cylinder_range(machine.stick, MARGIN))
    boom, stick = (min(max(q, low), high) for q, (low, high) in zip(others, ranges, strict=True))
    return swing, boom, stick
