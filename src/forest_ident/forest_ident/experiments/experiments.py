"""The experiments of Thesis section 4.3 and three more: what a person prepares, what is driven, how far.

| experiment | rig | tells |
|---|---|---|
| valve | valve alone (fig. 4.3) | C_R(V), overlap and gain by direction and port |
| spool_lag | the same | how the spool follows |
| hose, hose_laminar | hose alone (fig. 4.5, 4.7) | R; I and C (not with laminar) |
| motor_external | crane, swing to and fro (fig. 4.9) | R_ex |
| motor_internal | crane on a tilted platform, valve shut (fig. 4.9) | R_in |
| damping_AXIS | crane, one axis at several speeds | B (fig. 4.11) |
| deadband_AXIS | crane, one axis through its overlap, slowly | overlap by direction, from motion |
| gravity | crane, boom and stick from pose to pose | whether load and masses are as told |
| validation | crane, all axes | nothing: held out |

A machine whose axes have valves or hoses of their own gets `valve_AXIS`, `hose_AXIS` for each of these.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from forest_description.derived.limits import joint_limits, pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import joint_angle
from forest_description.machine import CylinderDrive, Machine
from forest_description.types import AXES, Vec3
from forest_ident.experiments import test_rig
from forest_ident.experiments.excitation import Programme, Row, Track, stairs

TILT = 0.15  # [rad] of the platform for the internal leakage
SWING_ROOM = 1.2  # [rad] to either side
MARGIN = 0.15  # of the stroke that stays free at either end
POSE = 6.5  # [s] from pose to pose: moving, then resting until the crane has stopped swinging
ENDLESS = 1e9  # [rad] a bench's meter turns on and on


class Plan(NamedTuple):
    """An experiment on a certain machine."""

    name: str
    machine: Machine  # as prepared: a rig, or the crane, tilted or not
    programme: Programme
    angles: Vec3  # [rad] at the start
    bench: bool
    setup: str
    facts: dict[str, float]
    tip: Vec3 = (math.nan, math.nan, math.nan)  # [m] at the start

    @property
    def limits(self) -> str:
        """What keeps the machine from harm."""
        return BENCH_LIMITS if self.bench else _crane_limits()


CRANE_LIMITS = (
    "Nobody within the crane's reach; hand on the emergency stop. An axis turns round {margin:.0f} % of its "
    "stroke before its ends, the swing {room:.0f} degrees to either side of where it starts."
)
BENCH_LIMITS = (
    "Hoses and couplings rated for twice the supply pressure, a guard over them; relief valve set and tested "
    "first. Stop above 350 K of oil."
)


def names(machine: Machine) -> tuple[str, ...]:
    """Return the experiments that this machine needs, in the order in which they are evaluated."""
    own_valves = [f"valve_{axis}" for axis in AXES if getattr(machine, axis).valve is not None]
    own_hoses = [f"hose_{axis}" for axis in AXES if getattr(machine, axis).hose is not None]
    shared_valve = [] if len(own_valves) == len(AXES) else ["valve"]
    regimes = {drive.flow_regime for drive in machine.drives if drive.hose is None}
    shared = [name for name, flag in (("hose", "turbulent"), ("hose_laminar", "laminar")) if flag in regimes]
    return (
        *("calibration", *shared_valve, *own_valves, "spool_lag", *shared, *own_hoses),
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
    angles = pose_at(tip, found.machine)  # as a simulator has it that is told the tip
    return found._replace(programme=programme, tip=tip, angles=angles)


def _plan(name: str, machine: Machine, seed: int) -> Plan:
    kind, _, axis_name = name.partition("_")
    axis = AXES.index(axis_name) if axis_name in AXES else 0
    if kind == "valve":
        return _valve(name, machine, axis if axis_name in AXES else shared_valve_axis(machine))
    if name == "spool_lag":
        return _spool_lag(machine)
    if kind == "hose":
        own = axis_name in AXES
        laminar = machine.drives[axis].flow_regime == "laminar" if own else axis_name == "laminar"
        return _hose(name, machine, axis if own else _shared_hose(machine), laminar)
    if kind in ("damping", "deadband") and axis_name in AXES:
        return _one_axis(name, machine, axis)
    if name in ("motor_external", "motor_internal"):
        return _motor(name, machine)
    if name in ("gravity", "validation"):
        return _all_axes(name, machine, seed)
    raise KeyError(name)


def shared_valve_axis(machine: Machine) -> int:
    """Return an axis that has the valve that all share; the swing if none has."""
    return next((axis for axis in range(3) if machine.drives[axis].valve is None), 0)


def _shared_hose(machine: Machine) -> int:
    """Return an axis that has the hose that all share."""
    return next((axis for axis in range(3) if machine.drives[axis].hose is None), 0)


def _valve(name: str, machine: Machine, axis: int) -> Plan:
    rig = test_rig.valve_bench(machine, axis)
    valve = machine.valve_of(axis)
    rated = valve.rated_voltage
    fine = tuple(np.arange(0.02, 0.22, 0.01) * rated)
    coarse = tuple(np.arange(0.22, 1.001, 0.06) * rated)
    rows = stairs((*fine, *coarse), 0.6)
    track = Track(tuple(rows), -ENDLESS, ENDLESS, alternate=True)
    total = 2.0 * sum(row.duration for row in rows) + 2.0
    setup = (
        "Take the valve off the crane. Port 1 through a flow meter, a braked metering motor and the second "
        "meter back to port 2; supply and tank as on the crane. Pressure transducers of the swing at both "
        "ports, one in the supply. Oil through the cooler at one temperature."
    )
    programme = Programme((track, None, None), total)
    return Plan(
        name=name, machine=rig, programme=programme, angles=_rest(machine), bench=True, setup=setup, facts={}
    )


def _spool_lag(machine: Machine) -> Plan:
    rig = test_rig.valve_bench(machine)
    rated = machine.valve_of(0).rated_voltage
    rows = stairs((0.3 * rated, 0.7 * rated, 0.45 * rated, 0.9 * rated), 0.11)
    track = Track(rows, -ENDLESS, ENDLESS, alternate=True)
    setup = "As for the valve. The spool sensor and the amplifier's voltage on one clock."
    programme = Programme((track, None, None), 16.0)
    return Plan(
        name="spool_lag",
        machine=rig,
        programme=programme,
        angles=_rest(machine),
        bench=True,
        setup=setup,
        facts={},
    )


def _hose(name: str, machine: Machine, axis: int, laminar: bool) -> Plan:
    rig = test_rig.hose_bench(machine, axis, laminar)
    rated = rig.swing.valve.rated_voltage if rig.swing.valve else machine.valve.rated_voltage
    levels = tuple(rated * share for share in (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0))
    groups = [
        stairs((low * rated, high * rated) * round(5.0 / (2.0 * hold)), hold)
        for low, high, hold in ((0.35, 0.6, 0.35), (0.4, 0.7, 0.25), (0.35, 0.7, 0.15), (0.4, 0.8, 0.2))
    ]
    rows = (*stairs(levels, 1.4), *(row for group in groups for row in group))
    track = Track(tuple(rows), -ENDLESS, ENDLESS, alternate=True)
    total = 2.0 * sum(row.duration for row in rows) + 2.0
    length = test_rig.as_measured(machine, machine.hose_of(axis)).length
    setup = (
        f"A piece of the hose, {length:g} m, straight, between the valve's port 1 and the braked metering "
        "motor; flow meter and pressure transducer at its entrance, the others at its exit. Bleed it. Oil "
        "through the cooler at one temperature"
        + (", thick enough for laminar flow (Reynolds' number under 2000)." if laminar else ".")
    )
    programme = Programme((track, None, None), total)
    facts = {"hose_length": length, "hose_axis": float(axis), "laminar": float(laminar)}
    return Plan(
        name=name,
        machine=rig,
        programme=programme,
        angles=_rest(machine),
        bench=True,
        setup=setup,
        facts=facts,
    )


def _motor(name: str, machine: Machine) -> Plan:
    rest = _rest(machine)
    if name == "motor_internal":
        tilted = dataclasses.replace(
            machine, manipulator=dataclasses.replace(machine.manipulator, platform_tilt=TILT)
        )
        setup = (
            f"Turn the crane square to the way the platform will tilt, stretch it, then tilt the platform by "
            f"{math.degrees(TILT):.1f} degrees, so that its weight drives the swing. Swing valve shut: the "
            "crane creeps."
        )
        start = (0.9, rest[1], rest[2])
        programme = Programme((None, None, None), 100.0)
        told = {"platform_tilt": TILT}  # for cranes without an inclinometer
        return Plan(
            name=name, machine=tilted, programme=programme, angles=start, bench=False, setup=setup, facts=told
        )
    rated = machine.valve_of(0).rated_voltage
    rows = stairs(tuple(rated * share for share in (0.3, 0.4, 0.25, 0.35)), 2.5)
    setup = (
        "Lead the motor's case drain into a measured vessel, or through its own meter. Empty the vessel when "
        "the record starts; read it when it ends, and write the volume under case_drain_volume."
    )
    programme = Programme((_track(machine, 0, rest, rows), None, None), 70.0)
    return Plan(
        name=name, machine=machine, programme=programme, angles=rest, bench=False, setup=setup, facts={}
    )


def _one_axis(name: str, machine: Machine, axis: int) -> Plan:
    rest, valve = _rest(machine), machine.valve_of(axis)
    rated = valve.rated_voltage
    if name.startswith("damping"):
        shares = (0.25, 0.5, 0.35, 0.6, 0.2, 0.45)
        rows, total = stairs(tuple(rated * share for share in shares), 1.6), 70.0
        setup = "Crane without load, oil warm, engine at its governed speed."
    else:
        rows = (Row(9.0, 0.03 * rated, 0.24 * rated), Row(9.0, 0.24 * rated, 0.03 * rated))
        setup, total = "Crane without load, oil warm. The axis hardly moves: that is what is wanted.", 110.0
    tracks: list[Track | None] = [None, None, None]
    tracks[axis] = _track(machine, axis, rest, rows, alternate=name.startswith("deadband"))
    programme = Programme((tracks[0], tracks[1], tracks[2]), total)
    return Plan(
        name=name, machine=machine, programme=programme, angles=rest, bench=False, setup=setup, facts={}
    )


def _all_axes(name: str, machine: Machine, seed: int) -> Plan:
    rest, generator = _rest(machine), np.random.default_rng([seed, 44])
    rated = [machine.valve_of(axis).rated_voltage for axis in range(3)]
    tracks: list[Track | None] = [None, None, None]
    if name == "gravity":
        for axis, hold in ((1, 1.1), (2, 1.7)):
            rows = (*stairs((0.35 * rated[axis],), hold), *stairs((0.0,), POSE - hold))
            tracks[axis] = _track(machine, axis, rest, rows)
        setup, total = (
            "Crane with the head it works with, no log. It moves from pose to pose and rests.",
            60.0,
        )
    else:
        for axis in range(3):
            shares = generator.uniform(0.15, 0.55, 12)
            rows = stairs(tuple(float(rated[axis] * share) for share in shares), 0.7 + 0.2 * axis)
            tracks[axis] = _track(machine, axis, rest, rows, alternate=True)
        setup, total = "Crane without load, oil warm. This record is held out: it checks the model.", 40.0
    programme = Programme((tracks[0], tracks[1], tracks[2]), total)
    return Plan(
        name=name, machine=machine, programme=programme, angles=rest, bench=False, setup=setup, facts={}
    )


def _track(machine: Machine, axis: int, rest: Vec3, rows: tuple[Row, ...], alternate: bool = False) -> Track:
    low, high = joint_limits(machine)[axis]
    if axis == 0:
        low, high = max(low, rest[0] - SWING_ROOM), min(high, rest[0] + SWING_ROOM)
    else:
        low, high = _inside(machine.boom if axis == 1 else machine.stick)
    return Track(rows, low, high, alternate)


def _inside(drive: CylinderDrive) -> tuple[float, float]:
    """Return the angles at which the cylinder is `MARGIN` of its stroke from either end."""
    ends = (drive.retracted_length + share * drive.stroke for share in (MARGIN, 1.0 - MARGIN))
    low, high = sorted(joint_angle(length, drive.linkage) for length in ends)
    return low, high


def _rest(machine: Machine) -> Vec3:
    """Return where the crane starts: as the simulator does, if that is within the soft limits [rad]."""
    swing, *others = pose_at(start_tip(machine), machine)
    inside = (_inside(machine.boom), _inside(machine.stick))
    boom, stick = (min(max(q, low), high) for q, (low, high) in zip(others, inside, strict=True))
    return swing, boom, stick


def _crane_limits() -> str:
    return CRANE_LIMITS.format(margin=100.0 * MARGIN, room=math.degrees(SWING_ROOM))
