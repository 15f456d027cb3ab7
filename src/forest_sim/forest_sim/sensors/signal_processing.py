"""From the channels' readings to quantities, and to what is derived from them as on a real machine.

- Speeds: backward difference of the positions read, behind a first-order low-pass
  (`SPEED_BANDWIDTH`); causal, so it lags. Over the time since the last sample, so that a lost one
  does not look like a jump.
- Angles of boom and stick: from their resolvers, or from what stands in for these
  (`sensor_suite.ANGLES`): from the cylinders' lengths through the linkages, or from inertial units'
  attitudes, the stick's less the boom's.
- Forces and torques: from the pressures read at the actuators and, for torques, the angles read.

NaN stands for what there is no reading of, and for what would be derived from it.

| quantity | shape | unit |
|---|---|---|
| joint angle, rate, torque | 3 (swing, boom, stick) | rad, rad/s, N m |
| actuator position, speed, force | 3 | rad or m, rad/s or m/s, N m or N |
| pressures | 12: axis, port, place (valve, actuator) | Pa |
| readings | one of each channel, in the order of `CHANNELS` | the channel's |
"""

import math
from typing import NamedTuple

from forest_description.geometry.linkage import angle_at, lever_arm
from forest_description.types import Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.actuator import Actuator
from forest_sim.sensors.sensor_suite import CYLINDERS, INERTIAL_UNITS, PLACES

SPEED_BANDWIDTH = 25.0  # [Hz]

PRESSURES = PLACES["pressure"].start  # where these channels begin
BOOM_UNIT = PLACES["inertial_unit"].start
STICK_UNIT = BOOM_UNIT + 1

Readings = tuple[float, ...]
Positions = tuple[float, ...]  # joints, then actuators
Estimates = tuple["SpeedEstimate", ...]  # joints, then actuators


class Motion(NamedTuple):
    """Positions, speeds and efforts of three joints or actuators; NaN where there is no reading."""

    position: Vec3
    speed: Vec3
    effort: Vec3


class SpeedEstimate(NamedTuple):
    """A speed estimator: last position read, filtered speed, time since then [s]."""

    position: float
    speed: float
    age: float


class Measurement(NamedTuple):
    """One sample of every sensor; NaN where there is none."""

    joints: Motion
    actuators: Motion
    pressures: tuple[float, ...]
    supply_pressure: float
    supply_flow: float
    supply_saturation: float
    readings: Readings

    def of_kind(self, kind: str) -> Readings:
        """Return the readings of a kind of sensor, by its name in `sensor_suite.KINDS`."""
        return self.readings[PLACES[kind]]


def estimate_speed(e: SpeedEstimate, position: float, dt: float, due: bool) -> SpeedEstimate:
    """Return the estimate `dt` [s] later; only a sample that is due, and not lost, moves it."""
    elapsed = e.age + dt
    if not due or math.isnan(position):
        return SpeedEstimate(e.position, e.speed, elapsed)
    keep = math.exp(-2.0 * math.pi * SPEED_BANDWIDTH * elapsed)
    speed = keep * e.speed + (1.0 - keep) * (position - e.position) / elapsed
    return SpeedEstimate(position, speed, 0.0)


def updated_estimates(before: Estimates, position: Positions, dt: float, due: bool) -> Estimates:
    """Return the estimates of all six speeds `dt` [s] later."""
    return tuple([estimate_speed(before[i], position[i], dt, due) for i in range(6)])


def force(pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return the actuator's force [N; N m] from its pressures, without friction. Thesis eq. 3.17, 3.19."""
    return a.own_displacement_1 * pressure_1 - a.own_displacement_2 * pressure_2


def measurement(
    readings: Readings,
    position: Positions,
    estimates: Estimates,
    p: PlantParameters,
    supply_flow: float,
    supply_saturation: float,
) -> Measurement:
    """Return readings, in the order of `CHANNELS`, by quantity, with what is derived from them."""
    at = tuple([readings[PRESSURES + i] for i in range(12)])
    speeds = tuple([_speed_or_nan(estimates[i], position[i]) for i in range(6)])
    forces = (
        force(at[1], at[3], p.swing.actuator),
        force(at[5], at[7], p.boom.actuator),
        force(at[9], at[11], p.stick.actuator),
    )
    arms = 1.0, lever_arm(position[1], p.boom_linkage), lever_arm(position[2], p.stick_linkage)
    torques = forces[0] * arms[0], forces[1] * arms[1], forces[2] * arms[2]
    return Measurement(
        joints=Motion((position[0], position[1], position[2]), (speeds[0], speeds[1], speeds[2]), torques),
        actuators=Motion((position[3], position[4], position[5]), (speeds[3], speeds[4], speeds[5]), forces),
        pressures=at,
        supply_pressure=readings[PRESSURES + 12],
        supply_flow=supply_flow,
        supply_saturation=supply_saturation,
        readings=readings,
    )


def positions(readings: Readings, angles: int, p: PlantParameters) -> Positions:
    """Return the positions read of 3 joints and 3 actuators; the swing's resolver serves both.

    Thesis App. A, first two equations, for angles by the cylinders.
    """
    boom, stick = readings[1], readings[2]
    if angles == CYLINDERS:
        boom, stick = angle_at(readings[3], p.boom_linkage), angle_at(readings[4], p.stick_linkage)
    elif angles == INERTIAL_UNITS:
        boom, stick = readings[BOOM_UNIT], readings[STICK_UNIT] - readings[BOOM_UNIT]
    return readings[0], boom, stick, readings[0], readings[3], readings[4]


def _speed_or_nan(e: SpeedEstimate, position: float) -> float:
    """Return an estimate's speed; there is none of a position that has no sample now."""
    return math.nan if math.isnan(position) else e.speed
