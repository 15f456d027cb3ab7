"""The machine's sensors by kind: what each can show, how far it may be off, how much it jitters.

| word | meaning |
|---|---|
| accuracy | bound of a unit's static error, ±; each unit has its own within it |
| noise | standard deviation of one sample, on top of the static error |
| full scale, lowest, highest | what can be shown; beyond it a reading stands at the end |
| resolution | smallest step of the reading |

A kind that is None is not on the machine. An accuracy or a noise that is None is not known and
counts as zero.
"""

from dataclasses import dataclass

from forest_description.config.parameter import (
    MachineError,
    ParameterSet,
    optional_choice,
    optional_parameter,
    parameter,
    require_order,
)
from forest_description.sensors.sensor_calibration import Calibration

ANGLE_KINDS = ("resolver", "linear_transducer", "inertial_unit")


@dataclass(frozen=True)
class Resolver(ParameterSet):
    """Angle of a joint. Thesis table 4.2."""

    full_scale: float = parameter("rad", 0.1, 200.0, "range, half of it to either side of the joint's zero")
    accuracy: float | None = parameter("rad", 0.0, 0.2, "bound of the static error")
    noise: float | None = parameter("rad", 0.0, 0.1, "standard deviation of a sample")
    resolution: float | None = optional_parameter("rad", 0.0, 0.1, "smallest step of the reading")


@dataclass(frozen=True)
class LinearTransducer(ParameterSet):
    """Length of a cylinder; mounted so that the stroke lies in the middle of its range. Thesis table 4.2.

    A cable encoder (draw wire) beside a cylinder is one, too: its drum and cable add accuracy and
    play.
    """

    full_scale: float = parameter("m", 0.01, 20.0, "range of the transducer")
    resolution: float | None = parameter("1", 0.0, 0.1, "smallest step, share of full scale")
    noise: float | None = parameter("m", 0.0, 0.1, "standard deviation of a sample")
    accuracy: float | None = optional_parameter(
        "1", 0.0, 0.1, "bound of the static error, share of full scale"
    )
    play: float | None = optional_parameter(
        "m", 0.0, 0.1, "way of a cable or drum before the reading follows"
    )


@dataclass(frozen=True)
class PressureTransducer(ParameterSet):
    """Gauge pressure, from zero up. Thesis table 4.2."""

    full_scale: float = parameter("Pa", 1e5, 2e8, "range of the transducer")
    accuracy: float | None = parameter("1", 0.0, 0.1, "bound of the static error, share of full scale")
    noise: float | None = parameter("Pa", 0.0, 1e7, "standard deviation of a sample")
    resolution: float | None = optional_parameter("1", 0.0, 0.1, "smallest step, share of full scale")


@dataclass(frozen=True)
class FlowMeter(ParameterSet):
    """Turbine in the oil's way. Thesis table 4.2, section 4.3.2.4."""

    lowest: float = parameter("m3/s", 0.0, 0.1, "smallest flow shown; any smaller one reads as this")
    highest: float = parameter("m3/s", 1e-6, 1.0, "largest flow shown")
    accuracy: float | None = parameter("1", 0.0, 0.2, "bound of the static error, share of the reading")
    time_constant: float = parameter("s", 0.0, 10.0, "first-order lag")
    noise: float | None = parameter("m3/s", 0.0, 0.01, "standard deviation of a sample")

    def __post_init__(self) -> None:
        """Check ranges, and that there is something to show."""
        super().__post_init__()
        require_order("lowest", self.lowest, "highest", self.highest, "m3/s")


@dataclass(frozen=True)
class Thermocouple(ParameterSet):
    """Temperature of the oil. Thesis table 4.2."""

    lowest: float = parameter("K", 0.0, 400.0, "lower end of the range")
    highest: float = parameter("K", 250.0, 3000.0, "upper end of the range")
    accuracy: float | None = parameter("K", 0.0, 20.0, "bound of the static error")
    noise: float | None = parameter("K", 0.0, 20.0, "standard deviation of a sample")

    def __post_init__(self) -> None:
        """Check ranges, and that there is something to show."""
        super().__post_init__()
        require_order("lowest", self.lowest, "highest", self.highest, "K")


@dataclass(frozen=True)
class Tachometer(ParameterSet):
    """Speed of the engine. Thesis table 4.2."""

    accuracy: float | None = parameter("rad/s", 0.0, 50.0, "bound of the static error")
    noise: float | None = parameter("rad/s", 0.0, 50.0, "standard deviation of a sample")


@dataclass(frozen=True)
class SpoolSensor(ParameterSet):
    """Position of a valve's spool, as the voltage that holds it there. Thesis section 4.2.2."""

    accuracy: float | None = parameter("V", 0.0, 5.0, "bound of the static error")
    noise: float | None = parameter("V", 0.0, 5.0, "standard deviation of a sample")


@dataclass(frozen=True)
class Inclinometer(ParameterSet):
    """Tilt of the platform, pitch and roll. Thesis section 4.2.2."""

    accuracy: float | None = parameter("rad", 0.0, 0.2, "bound of the static error")
    noise: float | None = parameter("rad", 0.0, 0.2, "standard deviation of a sample")


@dataclass(frozen=True)
class InertialUnit(ParameterSet):
    """Angle of boom and of stick above the platform: a gyro, held upright by accelerometers.

    The platform's own tilt is taken as known.
    """

    boom_distance: float = parameter("m", 0.0, 20.0, "from the boom's joint to its unit, along the boom")
    stick_distance: float = parameter("m", 0.0, 20.0, "from the stick's joint to its unit, along the stick")
    time_constant: float = parameter("s", 0.01, 100.0, "in which the accelerometers correct the gyro")
    accuracy: float | None = parameter("rad", 0.0, 0.2, "bound of the static error, mounting included")
    gyro_bias: float | None = parameter("rad/s", 0.0, 0.1, "bound of the gyro's rate at rest")
    gyro_noise: float | None = parameter("rad/s", 0.0, 0.1, "standard deviation of a sample of the gyro")
    accelerometer_noise: float | None = parameter(
        "m/s2", 0.0, 10.0, "standard deviation of a sample of an accelerometer"
    )
    resolution: float | None = optional_parameter("rad", 0.0, 0.1, "smallest step of the reading")


@dataclass(frozen=True)
class CaseDrain(ParameterSet):
    """Meter of the swing motor's external leakage; the thesis collected the oil in a vessel instead."""

    accuracy: float | None = parameter("1", 0.0, 0.2, "bound of the static error, share of the reading")
    noise: float | None = parameter("m3/s", 0.0, 0.01, "standard deviation of a sample")


@dataclass(frozen=True)
class Sensors(ParameterSet):
    """Every kind of sensor of a machine; None: the machine has none of that kind. Thesis section 4.2.2."""

    resolver: Resolver | None
    linear_transducer: LinearTransducer | None
    pressure: PressureTransducer | None
    flow_meter: FlowMeter | None
    thermocouple: Thermocouple | None
    tachometer: Tachometer | None
    spool_sensor: SpoolSensor | None
    inclinometer: Inclinometer | None
    case_drain: CaseDrain | None
    calibration: Calibration | None
    sample_rate: float = parameter("Hz", 1.0, 200.0, "samples of every sensor; held in between")
    inertial_unit: InertialUnit | None = None
    joint_angles: str | None = optional_choice(
        *ANGLE_KINDS, doc="what makes boom's and stick's angles in place of resolvers; left out: resolvers do"
    )

    @property
    def by_resolvers(self) -> bool:
        """Whether boom's and stick's angles are those of resolvers."""
        return self.joint_angles in (None, "resolver")

    def __post_init__(self) -> None:
        """Check that the kind that boom's and stick's angles are made of is fitted."""
        super().__post_init__()
        if self.joint_angles is not None and getattr(self, self.joint_angles) is None:
            fitted = [kind for kind in ANGLE_KINDS if getattr(self, kind) is not None]
            allowed = ", ".join([*fitted, "its numbers"])
            raise MachineError(f"joint_angles: {self.joint_angles} is not fitted; allowed: {allowed}")
