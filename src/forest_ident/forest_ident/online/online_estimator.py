"""Running estimates of a crane's overlap, gain and damping from its sensors, sample by sample.

The pure core of the on-line node: `step` takes one sample of the machine and the acting voltages, and
returns the estimates after it. Six quantities per axis, see `LABELS`.

| quantity | from | unit |
|---|---|---|
| deadband_forward, deadband_backward | V over the flow that the motion takes, by direction | V |
| gain_forward, gain_backward | opening flow per volt, k = 1/(sqrt(C_Rmin) (V_r - V_d)) | m^3/(s V sqrt(Pa)) |
| damping | (4.11) without accelerations: samples with little of it count alone | N s/m; N m s/rad |

Speeds are the machine's own causal estimates, pressures those at the actuators; the hoses' loss is taken from
the machine file. Thesis table 4.1, eq. 4.1, 4.11.
"""

import math
from typing import NamedTuple

from forest_description.geometry.linkage import lever_arm
from forest_description.machine import Machine
from forest_description.mechanics.drives import SwingDrive
from forest_description.types import Vec3
from forest_ident.online import recursive_least_squares
from forest_ident.online.recursive_least_squares import Estimator
from forest_msgs_py.interfaces.topics import IDENTIFICATION
from forest_sim.mechanics.manipulator import Body, dynamics, fold_head

LABELS = IDENTIFICATION.labels
MARGIN = 0.15  # of the rated voltage, beyond which the law of the valve is fitted
SETTLED = 0.3  # [s] for which a voltage has been held
WINDOW = 0.6  # [s] of steady motion that counts as one sample
LEAST_DROP = 1e5  # [Pa] over an edge, at least
SCALE = 1e6  # gains are some 1e-7: scaled to about one, P stays in its bound
STANDSTILL = 0.02  # share of the rated speed under which an axis counts as at rest


class Sample(NamedTuple):
    """One sample of the machine; what is not read is NaN."""

    angles: Vec3  # [rad]
    rates: Vec3  # [rad/s]
    pressures_1: Vec3  # [Pa] at the actuators
    pressures_2: Vec3
    supply: float  # [Pa]
    voltages: Vec3  # [V]


class Sums(NamedTuple):
    """Sums over a window of an axis: it rocks, so that single samples are no steady motion."""

    time: float = 0.0  # [s]
    samples: float = 0.0
    speed: float = 0.0
    pressure_1: float = 0.0
    pressure_2: float = 0.0
    supply: float = 0.0
    load: float = 0.0  # on the actuator, of gravity and the other joints


class Axis(NamedTuple):
    """Estimates of one axis, how long its voltage has been held, and the window that is being filled."""

    forward: Estimator
    backward: Estimator
    drive: Estimator
    voltage: float = 0.0
    since: float = 0.0  # [s]
    sums: Sums = Sums()


class State(NamedTuple):
    """Estimates of all axes."""

    axes: tuple[Axis, Axis, Axis]


class Parameters(NamedTuple):
    """Constants of the machine, and the memory of the estimates."""

    displacements: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    machine: Machine
    body: Body
    memory: float  # [s]


def parameters(machine: Machine, memory: float = 60.0) -> Parameters:
    """Return the core's constants for a machine; a sample counts 1/e after ``memory`` [s]."""
    swing = machine.swing.gear_ratio * machine.swing.motor_displacement
    pairs = (
        (swing, swing),
        (machine.boom.head_area, machine.boom.rod_area),
        (machine.stick.head_area, machine.stick.rod_area),
    )
    return Parameters(pairs, machine, fold_head(machine.manipulator), memory)


def initial(p: Parameters) -> State:
    """Return the state at the machine file's values, with large standard errors."""
    swing, boom, stick = (_initial_axis(p.machine, axis) for axis in range(3))
    return State((swing, boom, stick))


def _initial_axis(machine: Machine, axis: int) -> Axis:
    law = machine.valve_of(axis).law
    forward, backward = (
        recursive_least_squares.start(
            _line(way.resistance_1, way.deadband_voltage, way.rated_voltage), (1e3, 1e3)
        )
        for way in (law.forward, law.backward)
    )
    drive = recursive_least_squares.start((machine.drives[axis].damping, 0.0), (1e3, 1e3))
    return Axis(forward, backward, drive)


def _line(c_r: float, edge: float, rated: float) -> tuple[float, float]:
    gain = 1.0 / (math.sqrt(c_r) * (rated - edge))
    return gain * SCALE, -gain * edge * SCALE


def step(state: State, sample: Sample, p: Parameters, dt: float) -> State:
    """Return the estimates after a sample, ``dt`` [s] after the last one."""
    load = dynamics(sample.angles, sample.rates, p.body).bias
    swing, boom, stick = (_axis(state.axes[axis], axis, sample, load[axis], p, dt) for axis in range(3))
    return State((swing, boom, stick))


def _axis(a: Axis, axis: int, s: Sample, load: float, p: Parameters, dt: float) -> Axis:
    voltage = s.voltages[axis]
    since = a.since + dt if voltage == a.voltage else 0.0
    a = a._replace(voltage=voltage, since=since)
    drive = p.machine.drives[axis]
    arm = 1.0 if isinstance(drive, SwingDrive) else lever_arm(s.angles[axis], drive.linkage)
    values = (s.rates[axis] * arm, s.pressures_1[axis], s.pressures_2[axis], s.supply, load / arm)
    if since < SETTLED or not all(map(math.isfinite, values)):
        return a._replace(sums=Sums())
    now = (dt, 1.0, *values)
    sums = Sums(*(old + new for old, new in zip(a.sums, now, strict=True)))
    if sums.time < WINDOW - 1e-9:
        return a._replace(sums=sums)
    mean = Sums(sums.time, 1.0, *(part / sums.samples for part in sums[2:]))
    return _updated(a._replace(sums=Sums()), axis, mean, p)


def _updated(a: Axis, axis: int, mean: Sums, p: Parameters) -> Axis:
    """Return the axis after a full window."""
    speed, one, two = mean.speed, mean.pressure_1, mean.pressure_2
    valve, (d_1, d_2) = p.machine.valve_of(axis), p.displacements[axis]
    flow = math.sqrt(p.machine.pump.supply_pressure / (2.0 * valve.minimum_resistance))
    if abs(speed) < STANDSTILL * flow / d_1:
        return a
    force = d_1 * one - d_2 * two - mean.load
    regressor = (speed, math.copysign(1.0, speed))
    a = a._replace(drive=recursive_least_squares.step(a.drive, regressor, force, mean.time, p.memory))
    edge, forward = abs(a.voltage), a.voltage > 0.0
    if not MARGIN * valve.rated_voltage <= edge < valve.rated_voltage or a.voltage * speed < 0.0:
        return a
    driven, other = (one, two) if forward else (two, one)
    flow, drop = _inlet(axis, abs(speed), driven, other, mean.supply, forward, p)
    if drop <= LEAST_DROP:
        return a
    way = a.forward if forward else a.backward
    y = SCALE * flow / math.sqrt(drop)
    way = recursive_least_squares.step(way, (edge, 1.0), y, mean.time, p.memory)
    return a._replace(forward=way) if forward else a._replace(backward=way)


def _inlet(
    axis: int, speed: float, driven: float, other: float, supply: float, forward: bool, p: Parameters
) -> tuple[float, float]:
    """Return the flow [m^3/s] into the driven port and the drop [Pa] over its edge. Thesis eq. 4.1."""
    flow = p.displacements[axis][0 if forward else 1] * speed
    if axis == 0:
        drive = p.machine.swing
        flow += (driven - other) / drive.internal_leakage_resistance
        flow += driven / drive.external_leakage_resistance
    line = p.machine.line(axis, 1 if forward else 2)
    laminar = p.machine.drives[axis].flow_regime == "laminar"
    loss = line.resistance * (flow if laminar else flow * flow)
    return flow, supply - driven - loss


def report(state: State) -> tuple[float, ...]:
    """Return the estimates, in the order of `LABELS`."""
    values: list[float] = []
    for a in state.axes:
        for way in (a.forward, a.backward):
            values += _valve(way)
        values += [a.drive.theta[0], recursive_least_squares.spread(a.drive)[0]]
    return tuple(values)


def _valve(e: Estimator) -> list[float]:
    """Return overlap and gain of a direction with their spreads; the overlap is -theta_2/theta_1."""
    gain, offset = e.theta
    error_1, error_2 = recursive_least_squares.spread(e)
    if gain <= 0.0:
        return [math.nan, math.nan, gain / SCALE, error_1 / SCALE]
    covariance = e.variance * e.covariance[1]
    edge = -offset / gain
    variance = (error_2**2 + 2.0 * edge * covariance + (edge * error_1) ** 2) / gain**2
    return [edge, math.sqrt(max(variance, 0.0)), gain / SCALE, error_1 / SCALE]
