"""From the channels' readings to quantities, and to what is derived from them as on a real machine.

- Speeds: backward difference of the positions read, behind a first-order low-pass (`SPEED_BANDWIDTH`);
  causal, so it lags. Over the time since the last sample, so that a lost one does not look like a jump.
- Forces and torques: from the pressures read at the actuators and, for torques, the angles read.

NaN stands for what there is no reading of, and for what would be derived from it.

| quantity | shape | unit |
|---|---|---|
| joint angle, rate, torque | 3 (swing, boom, stick) | rad, rad/s, N m |
| actuator position, speed, force | 3 | rad or m, rad/s or m/s, N m or N |
| pressures | 12: axis, port, place (valve, actuator) | Pa |
| flows | 2: into port 1 of swing and stick | m^3/s |
| spools | 3 | V |
| temperatures | 3: tank, pump case, swing motor case | K |
| engine speed | 1 | rad/s |
| tilt of the platform | 2: pitch, roll | rad |
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from forest_description.linkage import lever_arm
from forest_sim.actuator import Actuator
from forest_sim.parameters import PlantParameters
from forest_sim.pendulum import Triple
from forest_sim.sensor_suite import PLACES

SPEED_BANDWIDTH = 25.0  # [Hz]

JOINTS, CYLINDERS, PRESSURES = PLACES["resolver"], PLACES["linear_transducer"], PLACES["pressure"]
FLOWS, TEMPERATURES, ENGINE_SPEED = PLACES["flow_meter"], PLACES["thermocouple"], PLACES["tachometer"]
SPOOLS, TILT, CASE_DRAIN = PLACES["spool_sensor"], PLACES["inclinometer"], PLACES["case_drain"]


class Motion(NamedTuple):
    """Positions, speeds and efforts of three joints or actuators; NaN where there is no reading."""

    position: Triple
    speed: Triple
    effort: Triple


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
    flows: tuple[float, ...]
    supply_pressure: float
    supply_flow: float
    supply_saturation: float
    case_drain_flow: float
    spools: Triple
    temperatures: Triple
    engine_speed: float
    tilt: tuple[float, ...]


def estimate_speed(e: SpeedEstimate, position: float, dt: float, due: bool) -> SpeedEstimate:
    """Return the estimate `dt` [s] later; only a sample that is due, and not lost, moves it."""
    elapsed = e.age + dt
    if not due or math.isnan(position):
        return SpeedEstimate(e.position, e.speed, elapsed)
    keep = math.exp(-2.0 * math.pi * SPEED_BANDWIDTH * elapsed)
    speed = keep * e.speed + (1.0 - keep) * (position - e.position) / elapsed
    return SpeedEstimate(position, speed, 0.0)


def force(pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return the actuator's force [N; N m] from its pressures, without friction. Thesis eq. 3.17, 3.19."""
    return a.own_displacement_1 * pressure_1 - a.own_displacement_2 * pressure_2


def measurement(
    read: list[float],
    estimates: tuple[SpeedEstimate, ...],
    p: PlantParameters,
    supply_flow: float,
    supply_saturation: float,
) -> Measurement:
    """Return readings, in the order of `CHANNELS`, by quantity, with what is derived from them."""
    seen, pressures = positions(read), tuple(read[PRESSURES][:12])
    # No speed of a position that has no sample now.
    speeds = tuple(
        math.nan if math.isnan(position) else e.speed for e, position in zip(estimates, seen, strict=True)
    )
    forces = (
        force(pressures[1], pressures[3], p.swing.actuator),
        force(pressures[5], pressures[7], p.boom.actuator),
        force(pressures[9], pressures[11], p.stick.actuator),
    )
    arms = 1.0, lever_arm(seen[1], p.boom_linkage), lever_arm(seen[2], p.stick_linkage)
    torques = forces[0] * arms[0], forces[1] * arms[1], forces[2] * arms[2]
    return Measurement(
        joints=Motion(_triple(seen[:3]), _triple(speeds[:3]), torques),
        actuators=Motion(_triple(seen[3:]), _triple(speeds[3:]), forces),
        pressures=pressures,
        flows=tuple(read[FLOWS]),
        supply_pressure=read[PRESSURES][12],
        supply_flow=supply_flow,
        supply_saturation=supply_saturation,
        case_drain_flow=read[CASE_DRAIN][0],
        spools=_triple(read[SPOOLS]),
        temperatures=_triple(read[TEMPERATURES]),
        engine_speed=read[ENGINE_SPEED][0],
        tilt=tuple(read[TILT]),
    )


def positions(read: list[float]) -> tuple[float, ...]:
    """Return the positions read of 3 joints and 3 actuators; the swing's resolver serves both."""
    joints = read[JOINTS]
    return *joints, joints[0], *read[CYLINDERS]


def _triple(values: Sequence[float]) -> Triple:
    return values[0], values[1], values[2]
