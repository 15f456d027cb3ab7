"""The machine as the plant's kernels take it: flat NamedTuples of floats, made once from a `Machine`."""

import math
from functools import lru_cache
from typing import NamedTuple

from forest_description.limits import joint_limits
from forest_description.linkage import Linkage
from forest_description.machine import EndStops, Line, Machine
from forest_description.valve import ValveLaw
from forest_sim.actuator import Actuator, cylinder, motor
from forest_sim.end_stop import EndStop
from forest_sim.line import PortGuard
from forest_sim.manipulator import Body, fold_head

NO_GUARD = PortGuard(math.inf, 0.0, -math.inf, 0.0)


class Axis(NamedTuple):
    """One hydraulic axis: two hoses, the actuator between them and its mechanical stops."""

    line_1: Line
    line_2: Line
    actuator: Actuator
    stop: EndStop


class PlantParameters(NamedTuple):
    """Everything the equations of motion need."""

    swing: Axis
    boom: Axis
    stick: Axis
    boom_linkage: Linkage
    stick_linkage: Linkage
    body: Body
    guard: PortGuard
    valve: ValveLaw
    supply_pressure: float  # [Pa]
    spool_rate: float  # [rad/s] of the spool's first-order lag, inf: the spool follows at once


@lru_cache(maxsize=64)
def plant_parameters(machine: Machine) -> PlantParameters:
    """Return the kernel's parameters for a machine; components that it lacks become neutral numbers."""
    lines = [(machine.line(axis, 1), machine.line(axis, 2)) for axis in range(3)]
    stops = machine.end_stops
    swing_limits = joint_limits(machine)[0]
    return PlantParameters(
        swing=Axis(*lines[0], motor(machine.swing, *lines[0]), _swing_stop(swing_limits, stops)),
        boom=Axis(*lines[1], cylinder(machine.boom, *lines[1]), _cylinder_stop(machine, 1, stops)),
        stick=Axis(*lines[2], cylinder(machine.stick, *lines[2]), _cylinder_stop(machine, 2, stops)),
        boom_linkage=machine.boom.linkage,
        stick_linkage=machine.stick.linkage,
        body=fold_head(machine.manipulator),
        guard=_guard(machine),
        valve=machine.valve.law,
        supply_pressure=machine.pump.supply_pressure,
        spool_rate=math.inf if machine.spool_bandwidth is None else 2.0 * math.pi * machine.spool_bandwidth,
    )


def _guard(machine: Machine) -> PortGuard:
    v = machine.port_valves
    if v is None:
        return NO_GUARD
    return PortGuard(
        v.relief_pressure, v.relief_conductance, v.anticavitation_pressure, v.anticavitation_conductance
    )


def _swing_stop(limits: tuple[float, float], stops: EndStops | None) -> EndStop:
    if stops is None:
        return EndStop(-math.inf, math.inf, 0.0, 0.0)
    return EndStop(*limits, stops.swing_stiffness, stops.swing_damping)


def _cylinder_stop(machine: Machine, axis: int, stops: EndStops | None) -> EndStop:
    if stops is None:
        return EndStop(-math.inf, math.inf, 0.0, 0.0)
    drive = machine.boom if axis == 1 else machine.stick
    extended = drive.retracted_length + drive.stroke
    return EndStop(drive.retracted_length, extended, stops.cylinder_stiffness, stops.cylinder_damping)
