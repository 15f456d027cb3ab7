"""Which sensors the machine has, in one fixed order, and what each unit of them is worth.

A suite is made once, from the machine's file, a seed and faults. The seed gives every unit its
static error, uniform within its accuracy unless the file tells what the unit's calibration found,
and starts the generator of the samples' noise. Every channel has its own place in both, so that
taking one away changes no other.

Without noise a suite is exact: no error, lag, floor, resolution, range or sampling; absences and
faults hold.

Boom and stick have either resolvers or what `sensors.joint_angles` names. So their inertial units
have the draws that would be their resolvers', and leave all other draws as they are.
"""

import math
import zlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.mechanics.drives import CylinderDrive
from forest_description.sensors.sensor_calibration import Unit, line_of
from forest_description.sensors.sensor_kinds import ANGLE_KINDS, FlowMeter, InertialUnit, LinearTransducer
from forest_description.types import AXES
from forest_sim.sensors.inertial_unit import EARTH, Mounting
from forest_sim.sensors.sensor_model import ABSENT, EXACT, SensorModel

PORTS = tuple(f"{port}_{place}" for port in (1, 2) for place in ("valve", "actuator"))
TIME_TOLERANCE = 1e-9  # [s] by which sums of periods may be off


class Kind(NamedTuple):
    """Sensors of one kind: key of the machine file's section, unit, channels."""

    name: str
    unit: str
    channels: tuple[str, ...]


KINDS = (
    Kind("resolver", "rad", tuple(f"{axis}_resolver" for axis in AXES)),
    Kind("linear_transducer", "m", ("boom_transducer", "stick_transducer")),
    Kind(
        "pressure",
        "Pa",
        (*(f"{axis}_pressure_{port}" for axis in AXES for port in PORTS), "supply_pressure"),
    ),
    Kind("flow_meter", "m3/s", ("swing_flow", "stick_flow")),
    Kind("thermocouple", "K", ("tank_temperature", "pump_temperature", "motor_temperature")),
    Kind("tachometer", "rad/s", ("engine_speed",)),
    Kind("spool_sensor", "V", tuple(f"{axis}_spool" for axis in AXES)),
    Kind("inclinometer", "rad", ("platform_pitch", "platform_roll")),
    Kind("case_drain", "m3/s", ("case_drain",)),
    Kind("inertial_unit", "rad", ("boom_inertial_unit", "stick_inertial_unit")),
)
CHANNELS = tuple(channel for kind in KINDS for channel in kind.channels)
PLACES = {
    kind.name: slice(CHANNELS.index(kind.channels[0]), CHANNELS.index(kind.channels[-1]) + 1)
    for kind in KINDS
}
UNIT = {channel: kind.unit for kind in KINDS for channel in kind.channels}
DRAWN = tuple(name for name in CHANNELS if not name.endswith("_inertial_unit"))
DRAW_OF = [DRAWN.index(name.replace("inertial_unit", "resolver")) for name in CHANNELS]

# What boom's and stick's angles are made of.
RESOLVERS = 0
CYLINDERS = 1
INERTIAL_UNITS = 2
ANGLES = dict(zip(ANGLE_KINDS, (RESOLVERS, CYLINDERS, INERTIAL_UNITS), strict=True))


class Fault(NamedTuple):
    """Something wrong with a channel from `start` to before `end` [s], counted from the machine's start."""

    channel: int  # place in CHANNELS
    mode: int  # of the channel; WORKS: biased only
    bias: float  # [the channel's]
    probability: float  # that a sample is hit
    start: float
    end: float
    noise: float = 1.0  # factor


class Suite(NamedTuple):
    """All sensors of a machine; channels in the order of `CHANNELS`."""

    channels: tuple[SensorModel, ...]
    period: float = 0.0  # [s] between samples; 0: whenever asked
    faults: tuple[Fault, ...] = ()
    seed: int = 0
    angles: int = RESOLVERS  # what boom's and stick's are made of
    mounting: Mounting = Mounting()


class Draws(NamedTuple):
    """What chance says to one sample of every channel: standard normal; uniform in 0 .. 1."""

    normal: Sequence[float]
    uniform: Sequence[float]


EXACT_SUITE = Suite((EXACT,) * len(CHANNELS))
NO_DRAWS = Draws((0.0,) * len(CHANNELS), (0.0,) * len(CHANNELS))


def sensor_suite(
    machine: Machine, noise: bool = False, seed: int = 0, faults: tuple[Fault, ...] = ()
) -> Suite:
    """Return a machine's sensors: exact ones, or with everything that its file says of them.

    Thesis section 4.2.2: the rate of the data acquisition.
    """
    shares = iter(np.random.default_rng([seed, 0]).uniform(-1.0, 1.0, len(CHANNELS)).tolist())
    channels = []
    for kind in KINDS:
        for name in kind.channels:
            share, fitted = next(shares), _is_fitted(machine, kind.name, name)
            made = (
                _calibrated(_channel(kind.name, name, machine, share), name, machine)
                if fitted and noise
                else EXACT
            )
            channels.append(made if fitted else made._replace(mode=ABSENT))
    period = 1.0 / machine.sensors.sample_rate if noise else 0.0
    return Suite(tuple(channels), period, faults, seed, angles_of(machine), _mounting(machine))


def angles_of(machine: Machine) -> int:
    """Return what boom's and stick's angles are made of."""
    return ANGLES[machine.sensors.joint_angles or "resolver"]


def calibrated(suite: Suite) -> Suite:
    """Return the suite without its units' static errors, which a calibration takes out."""
    return suite._replace(channels=tuple(c._replace(bias=0.0, gain=1.0) for c in suite.channels))


def noise_generator(suite: Suite, run: str = "") -> np.random.Generator:
    """Return the generator of a suite's draws; equal seeds give equal readings.

    Args:
        suite: of sensors.
        run: name of the run: another one has other noise from the same units.
    """
    return np.random.default_rng([suite.seed, 1, zlib.crc32(run.encode())] if run else [suite.seed, 1])


def draw(generator: np.random.Generator) -> Draws:
    """Draw for one sample of every channel."""
    count = len(DRAWN)
    return Draws(
        generator.standard_normal(count)[DRAW_OF].tolist(), generator.random(count)[DRAW_OF].tolist()
    )


def conditions(suite: Suite, time: float, uniform: Sequence[float]) -> tuple[SensorModel, ...]:
    """Return the channels as they work at a time [s]; the suite's own while it has no faults."""
    if not suite.faults:
        return suite.channels
    channels = list(suite.channels)
    for fault in suite.faults:
        if fault.start - TIME_TOLERANCE <= time < fault.end - TIME_TOLERANCE:
            channel = channels[fault.channel]
            hit = uniform[fault.channel] < fault.probability
            mode = max(channel.mode, fault.mode) if hit else channel.mode
            channels[fault.channel] = channel._replace(
                bias=channel.bias + fault.bias, noise=fault.noise * channel.noise, mode=mode
            )
    return tuple(channels)


def _channel(kind: str, name: str, machine: Machine, share: float) -> SensorModel:
    """Return one unit, off by a share (-1 .. 1) of what its accuracy allows. Thesis table 4.2."""
    sensors = machine.sensors
    if kind == "flow_meter" and sensors.flow_meter is not None:
        return _flow_meter(sensors.flow_meter, share)
    if kind == "linear_transducer" and sensors.linear_transducer is not None:
        drive = machine.boom if name.startswith("boom") else machine.stick
        return _linear_transducer(sensors.linear_transducer, drive, share)
    if kind == "inertial_unit" and sensors.inertial_unit is not None:
        return _inertial_unit(sensors.inertial_unit, share, 1.0 / sensors.sample_rate)
    part = getattr(sensors, kind)
    error, low, high = (part.accuracy or 0.0) * share, -math.inf, math.inf
    exact = SensorModel(noise=part.noise or 0.0)
    if kind == "case_drain":
        return exact._replace(gain=1.0 + error)
    if kind == "resolver":
        low, high = -0.5 * part.full_scale, 0.5 * part.full_scale
        exact = exact._replace(resolution=part.resolution or 0.0)
    elif kind == "pressure":
        error, low, high = error * part.full_scale, 0.0, part.full_scale
        exact = exact._replace(resolution=part.full_scale * (part.resolution or 0.0))
    elif kind == "thermocouple":
        low, high = part.lowest, part.highest
    return exact._replace(bias=error, low=low, high=high)


def _calibrated(channel: SensorModel, name: str, machine: Machine) -> SensorModel:
    """Return one unit, off as its calibration found it, if there was one. Thesis section 4.3.1."""
    unit: Unit | None = getattr(machine.sensors.calibration, name, None)
    if unit is None:
        return channel
    gain, bias = line_of(unit)
    return channel._replace(gain=gain, bias=bias)


def _flow_meter(meter: FlowMeter, share: float) -> SensorModel:
    """Return a turbine; its range counts either way. Thesis table 4.2, section 4.3.2.4."""
    return SensorModel(
        time_constant=meter.time_constant,
        gain=1.0 + (meter.accuracy or 0.0) * share,
        noise=meter.noise or 0.0,
        floor=meter.lowest,
        low=-meter.highest,
        high=meter.highest,
    )


def _linear_transducer(transducer: LinearTransducer, drive: CylinderDrive, share: float) -> SensorModel:
    """Return a transducer whose range reaches as far beyond either end of the stroke. Thesis table 4.2."""
    low = drive.retracted_length - 0.5 * (transducer.full_scale - drive.stroke)
    return SensorModel(
        bias=transducer.full_scale * (transducer.accuracy or 0.0) * share,
        resolution=transducer.full_scale * (transducer.resolution or 0.0),
        noise=transducer.noise or 0.0,
        low=low,
        high=low + transducer.full_scale,
        play=transducer.play or 0.0,
    )


def _inertial_unit(unit: InertialUnit, share: float, period: float) -> SensorModel:
    """Return a unit that has run for long: its gyro's bias is a part of its static error."""
    time = unit.time_constant
    noise = math.hypot(time * (unit.gyro_noise or 0.0), (unit.accelerometer_noise or 0.0) / EARTH)
    return SensorModel(
        time_constant=time,
        bias=share * ((unit.accuracy or 0.0) + time * (unit.gyro_bias or 0.0)),
        noise=noise * math.sqrt(period),
        resolution=unit.resolution or 0.0,
    )


def _is_fitted(machine: Machine, kind: str, name: str) -> bool:
    """Tell whether a machine has a channel: no resolver at boom and stick if others make their angles."""
    instead = angles_of(machine) != RESOLVERS and name in ("boom_resolver", "stick_resolver")
    return getattr(machine.sensors, kind) is not None and not instead


def _mounting(machine: Machine) -> Mounting:
    """Return where the inertial units are; without them nowhere."""
    links, unit, g = machine.manipulator.links, machine.sensors.inertial_unit, machine.manipulator.gravity
    if unit is None:
        return Mounting()
    return Mounting(links.base_offset, links.boom, unit.boom_distance, unit.stick_distance, g)
