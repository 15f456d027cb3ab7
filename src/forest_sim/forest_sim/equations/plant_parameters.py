"""The machine as the plant's kernels take it: flat NamedTuples of floats, made once from a `Machine`."""

import math
from functools import lru_cache
from typing import Any, NamedTuple

from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import Linkage
from forest_description.hydraulics.hose import Line
from forest_description.hydraulics.valve_characteristic import ValveLaw
from forest_description.machine import Machine
from forest_description.mechanics.drives import CylinderDrive
from forest_description.mechanics.end_stops import EndStops
from forest_description.types import Vec3
from forest_sim.equations.elastic_links import RIGID_LINKS, ElasticLaws
from forest_sim.hydraulics.actuator import Actuator, cylinder, motor
from forest_sim.hydraulics.compensator import NO_COMPENSATOR, Compensator, compensator
from forest_sim.hydraulics.hydraulic_line import PortGuard
from forest_sim.hydraulics.load_holding import HoldingValve, holding_valve
from forest_sim.hydraulics.oil_law import INCOMPRESSIBLE, OilLaw, oil_law
from forest_sim.hydraulics.oil_volume import NO_CHAMBER, OilVolume
from forest_sim.hydraulics.spool_dynamics import SpoolLag, spool_lag
from forest_sim.hydraulics.supply import Supply, supply
from forest_sim.hydraulics.tank_line import ReturnLine, return_line
from forest_sim.mechanics.bristles import Bristles, bristles
from forest_sim.mechanics.elasticity import elastic_link
from forest_sim.mechanics.end_stop import NO_STOP, UNCUSHIONED, CushionBrake, EndStop
from forest_sim.mechanics.friction import FRICTIONLESS, Friction, friction
from forest_sim.mechanics.gear import NO_GEAR, Gear
from forest_sim.mechanics.manipulator import Body, fold_head
from forest_sim.mechanics.pendulum import HangingHead, hanging_head

NO_DROP = Line(0.0, 0.0, 0.0)
NO_GUARD = PortGuard(math.inf, 0.0, -math.inf, 0.0)


class SpoolValve(NamedTuple):
    """One valve: what its edges do at a spool position, how the spool follows, and its compensator."""

    law: ValveLaw
    lag: SpoolLag
    compensator: Compensator = NO_COMPENSATOR


class Axis(NamedTuple):
    """One hydraulic axis behind its valve: two hoses, the actuator between them, the ends of its stroke."""

    line_1: Line
    line_2: Line
    oil_1: OilVolume
    oil_2: OilVolume
    actuator: Actuator
    friction: Friction
    cushion: CushionBrake
    stop: EndStop
    holds: int  # not 0: load-holding valves stand between hoses and volumes
    holding_1: HoldingValve
    holding_2: HoldingValve


class DriveLaws(NamedTuple):
    """What stands between the swing's motor and its joint: a gear with play, a bearing that sticks."""

    present: int  # 0: none of it
    gear: Gear
    bearing: Bristles


class PlantParameters(NamedTuple):
    """Everything the equations of motion need."""

    valves: tuple[SpoolValve, SpoolValve, SpoolValve]
    swing: Axis
    boom: Axis
    stick: Axis
    boom_linkage: Linkage
    stick_linkage: Linkage
    body: Body
    head: HangingHead
    guard: PortGuard
    supply: Supply
    tip_force: Vec3  # [N] on the tip from outside, in the base frame
    drive: DriveLaws
    tank_line: ReturnLine
    elastic: ElasticLaws = RIGID_LINKS

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """The axes in the order of `AXES`."""
        return (self.swing, self.boom, self.stick)

    def with_axes(self, **changes: Any) -> "PlantParameters":
        """Return the parameters with the same changes to the fields of every axis."""
        swing, boom, stick = (axis._replace(**changes) for axis in self.axes)
        return self._replace(swing=swing, boom=boom, stick=stick)


@lru_cache(maxsize=64)
def plant_parameters(machine: Machine) -> PlantParameters:
    """Return the kernel's parameters for a machine, and keep them: they are asked for again and again."""
    return parameters_of(machine)


def parameters_of(machine: Machine) -> PlantParameters:
    """Return the kernel's parameters for a machine; components that it lacks become neutral numbers."""
    return PlantParameters(
        valves=(_valve(machine, 0), _valve(machine, 1), _valve(machine, 2)),
        swing=_swing(machine),
        boom=_cylinder(machine, 1),
        stick=_cylinder(machine, 2),
        boom_linkage=machine.boom.linkage,
        stick_linkage=machine.stick.linkage,
        body=fold_head(machine.manipulator),
        head=hanging_head(machine.manipulator),
        guard=_guard(machine),
        supply=supply(machine.pump, _manifold_oil(machine)),
        tip_force=(0.0, 0.0, 0.0),
        drive=_drive(machine),
        tank_line=return_line(machine.tank_line),
        elastic=_elastic(machine),
    )


def _drive(machine: Machine) -> DriveLaws:
    given = machine.swing
    present = given.backlash is not None or given.friction is not None
    return DriveLaws(int(present), _gear(machine), bristles(given.friction))


def _elastic(machine: Machine) -> ElasticLaws:
    swing, boom, stick = (drive.elasticity for drive in machine.drives)
    present = swing is not None or boom is not None or stick is not None
    return ElasticLaws(int(present), elastic_link(swing), elastic_link(boom), elastic_link(stick))


def _gear(machine: Machine) -> Gear:
    given, ratio = machine.swing.backlash, machine.swing.gear_ratio
    if given is None:
        return NO_GEAR
    half = 0.5 * given.free_way
    return Gear(
        inertia=given.motor_inertia * ratio * ratio,
        teeth=EndStop(-half, half, given.stiffness, given.damping),
        stop=_swing_stop(joint_limits(machine)[0], machine.end_stops),
    )


def _manifold_oil(machine: Machine) -> OilLaw:
    """Return the law of the manifold's oil; without air its capacitance is constant."""
    return INCOMPRESSIBLE if machine.oil is None or machine.oil.air is None else oil_law(machine.oil)


def _valve(machine: Machine, axis: int) -> SpoolValve:
    valve = machine.valve_of(axis)
    density = 0.0 if machine.oil is None else machine.oil.density
    return SpoolValve(valve.law, spool_lag(valve, density), compensator(valve.compensator))


def _swing(machine: Machine) -> Axis:
    lines, chambers = _lines(machine, 0), machine.swing.chambers
    port = 0.0 if chambers is None else chambers.port_volume
    oil = _oil(machine, 0, lines[0], port, 0.0), _oil(machine, 0, lines[1], port, 0.0)
    return Axis(
        line_1=lines[0],
        line_2=lines[1],
        oil_1=oil[0],
        oil_2=oil[1],
        actuator=motor(machine.swing, *_in_series(lines, oil)),
        friction=FRICTIONLESS,
        cushion=UNCUSHIONED,
        stop=NO_STOP if machine.swing.backlash else _swing_stop(joint_limits(machine)[0], machine.end_stops),
        holds=_holds(machine, 0),
        holding_1=holding_valve(machine.swing.holding_1),
        holding_2=holding_valve(machine.swing.holding_2),
    )


def _cylinder(machine: Machine, axis: int) -> Axis:
    lines = _lines(machine, axis)
    drive = machine.boom if axis == 1 else machine.stick
    oil = _cylinder_oil(machine, axis, 1, lines[0]), _cylinder_oil(machine, axis, 2, lines[1])
    return Axis(
        line_1=lines[0],
        line_2=lines[1],
        oil_1=oil[0],
        oil_2=oil[1],
        actuator=cylinder(drive, *_in_series(lines, oil)),
        friction=friction(drive.friction),
        cushion=_cushion(drive),
        stop=_cylinder_stop(drive, machine.end_stops),
        holds=_holds(machine, axis),
        holding_1=holding_valve(drive.holding_1),
        holding_2=holding_valve(drive.holding_2),
    )


def _holds(machine: Machine, axis: int) -> int:
    drive = machine.drives[axis]
    return int(drive.holding_1 is not None or drive.holding_2 is not None)


def _in_series(lines: tuple[Line, Line], oil: tuple[OilVolume, OilVolume]) -> tuple[Line, Line]:
    """Return what of two hoses stands between volume and actuator: nothing where the volume has it."""
    return (NO_DROP, NO_DROP) if oil[0].yields else lines


def _cylinder_oil(machine: Machine, axis: int, port: int, line: Line) -> OilVolume:
    """Return the oil of one port of a cylinder."""
    drive = machine.boom if axis == 1 else machine.stick
    chambers, shortest = drive.chambers, drive.retracted_length
    if chambers is None:
        return _oil(machine, axis, line, 0.0, 0.0)
    if port == 1:
        retracted = chambers.head_dead_volume - drive.head_area * shortest
        return _oil(machine, axis, line, retracted, drive.head_area)
    extended = chambers.rod_dead_volume + drive.rod_area * (shortest + drive.stroke)
    return _oil(machine, axis, line, extended, -drive.rod_area)


def _oil(machine: Machine, axis: int, line: Line, volume: float, area: float) -> OilVolume:
    """Return a chamber V = volume + area x and the oil in its hose as one volume."""
    oil, drive = machine.oil, machine.drives[axis]
    if oil is None or (drive.chambers is None and oil.air is None):
        return NO_CHAMBER
    share, laminar = machine.hose_of(axis).oil_share(oil.bulk_modulus), drive.flow_regime == "laminar"
    return OilVolume(
        yields=1,
        volume=volume + share * line.capacitance * oil.bulk_modulus,
        area=area,
        wall=(1.0 - share) * line.capacitance,
        laminar_drop=line.resistance if laminar else 0.0,
        turbulent_drop=0.0 if laminar else line.resistance,
        oil=oil_law(oil),
    )


def _lines(machine: Machine, axis: int) -> tuple[Line, Line]:
    return machine.line(axis, 1), machine.line(axis, 2)


def _guard(machine: Machine) -> PortGuard:
    v = machine.port_valves
    if v is None:
        return NO_GUARD
    return PortGuard(
        v.relief_pressure, v.relief_conductance, v.anticavitation_pressure, v.anticavitation_conductance
    )


def _swing_stop(limits: tuple[float, float], stops: EndStops | None) -> EndStop:
    if stops is None:
        return NO_STOP
    return EndStop(*limits, stops.swing_stiffness, stops.swing_damping)


def _cylinder_stop(drive: CylinderDrive, stops: EndStops | None) -> EndStop:
    if stops is None:
        return NO_STOP
    extended = drive.retracted_length + drive.stroke
    return EndStop(drive.retracted_length, extended, stops.cylinder_stiffness, stops.cylinder_damping)


def _cushion(drive: CylinderDrive) -> CushionBrake:
    if drive.cushion is None:
        return UNCUSHIONED
    extended = drive.retracted_length + drive.stroke
    return CushionBrake(drive.retracted_length, extended, drive.cushion.length, drive.cushion.resistance)
