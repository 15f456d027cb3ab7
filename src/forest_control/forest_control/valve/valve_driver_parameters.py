"""The valve driver's parameters: the machine, as far as it matters here, and what a user may set.

Known once, from the machine's file, for swing, boom and stick; units as in `valve_driver`,
cylinder; motor.
"""

import math
from functools import lru_cache
from typing import Annotated, NamedTuple

from forest_control.valve.inlet_oil import FreeAir, Holding, free_air, holding
from forest_control.valve.load_feedback import load_feedback
from forest_control.valve.spool_model import SpoolLaw, after
from forest_control.valve.valve_adaptation import AdaptationParameters
from forest_control.valve.valve_flow import FlowParameters, Yielding
from forest_description.derived.actuator_kinematics import displacements, metering_drop, rated_speeds
from forest_description.hydraulics.load_holding_parameters import (
    CounterbalanceValve,
    LoadHolding,
    RuptureValve,
)
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.hydraulics.valve_characteristic import ValveLaw
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_msgs_py.runtime.parameter_table import Parameter, tunable
from forest_msgs_py.types import PERIOD

LEAST_FED = 0.002  # [V] leakage that is not fed: it lets the tip of the C-180 sink by 2 mm/s; chosen
NOISY_SERVO = 35.0  # [1/s] seven standard deviations of the position through a servo's gain of 5 1/s


class AxisDriver(NamedTuple):
    """One actuator, as far as the driver knows it."""

    displacement_1: float
    displacement_2: float
    rated_speed: float  # at `rated_voltage` of the ideal valve
    valve: ValveLaw
    hose_linear: float = 0.0  # [N s/m; N m s] both hoses' loss that goes with the speed, at the actuator
    ahead_square: float = 0.0  # [N s^2/m^2; N m s^2] loss with its square, hoses and open holding valves
    back_square: float = 0.0  # and backwards
    slip: float = 0.0  # [rad/s per N m] speed that the motor's leakage takes under load
    damping: float = 0.0  # [N m s/rad] of what turns with the motor: a load while it turns, none at rest
    least_fed: float = 0.0  # [V] leakage from which it is fed
    spool: SpoolLaw = SpoolLaw()
    dither: float = 0.0  # [V] added by turns to every voltage that is not zero
    metering_drop: float = math.inf  # [Pa] that a compensator keeps over the edge to the pump
    throttled_1: bool = False  # what leaves port 1 loses all its pressure in a counterbalance valve
    throttled_2: bool = False  # what leaves port 2
    fills: bool = False  # it is allowed for that its oil must be pressed first
    oil_1: Yielding = Yielding()
    oil_2: Yielding = Yielding()
    middle: float = 0.0  # [m; rad] position that is assumed while none is measured
    air: FreeAir = FreeAir()
    holding_1: Holding = Holding()
    holding_2: Holding = Holding()
    load_feedback: float = 0.0  # [m/s per N; rad/s per N m] speed that a load above its mean takes off


Axes = tuple[AxisDriver, AxisDriver, AxisDriver]


class Settings(NamedTuple):
    """The valve driver's settings: parameters of its node that may be set while it runs."""

    compensate: Annotated[bool, tunable("false: commands pass unchanged, for experiments")] = True
    beyond_valve: Annotated[bool, tunable("compensate hoses, leakage and the spool's lag")] = True
    hold_zone: Annotated[float, tunable("commands that leave the spool centred", "V", 0.0, 1.0)] = 0.02
    load_bandwidth: Annotated[float, tunable("low-pass of the loads", "Hz", 0.01, 50.0)] = 1.0
    minimum_drop: Annotated[
        float,
        tunable("smallest drop over the valve that is counted on, over the pump's pressure", "", 0.01, 1.0),
    ] = 0.1
    dither_amplitude: Annotated[
        float, tunable("amplitude of the dither; negative: half the file's hysteresis", "V", -1.0, 2.0)
    ] = -1.0
    dither_frequency: Annotated[float, tunable("frequency of the dither", "Hz", 1.0, 100.0)] = 50.0
    adapt: Annotated[bool, tunable("learn deadband and gain of every valve")] = True
    forgetting_time: Annotated[
        float, tunable("age at which a sample of the adaptation counts 1/e", "s", 1.0, 3600.0)
    ] = 20.0
    deadband_range: Annotated[
        float, tunable("largest difference of a learnt deadband from the machine file", "V", 0.0, 2.0)
    ] = 0.4
    gain_range: Annotated[
        float, tunable("largest factor between a learnt gain and the machine file's", "", 1.0, 5.0)
    ] = 2.0


class DriverParameters(NamedTuple):
    """Of `valve_driver_node`, beside its settings."""

    period: Annotated[float, Parameter("nominal period of the commands", "s", 1e-4, 0.1)] = PERIOD
    command_timeout: Annotated[float, Parameter("age at which a command is lost", "s", 0.01, 0.2)] = 0.1
    pressure_timeout: Annotated[float, Parameter("age at which pressures are lost", "s", 0.01, 2.0)] = 0.1
    shadow: Annotated[bool, Parameter("compute everything, publish no voltage")] = False
    plain_arrays: Annotated[bool, Parameter("publish Float64MultiArray without stamp")] = False


class Parameters(NamedTuple):
    """Machine and settings, as the core takes them."""

    axes: Axes
    supply_pressure: float  # [Pa], the highest that the pump keeps
    idle_pressure: float  # [Pa], without flow; taken where it is not measured
    preload: float  # [Pa] of the tank line
    return_resistance: float  # [Pa s^2/m^6] of the tank line
    compensate: bool
    beyond_valve: bool
    hold_zone: float  # [V]
    command_noises: Vec3  # [V] commands up to this may be noise
    load_bandwidth: float  # [rad/s]
    minimum_drop: float
    dither_frequency: float  # [Hz]
    adapt: bool
    adaptation: AdaptationParameters
    flows: tuple[FlowParameters, FlowParameters, FlowParameters]


@lru_cache(maxsize=64)
def parameters(machine: Machine, settings: Settings) -> Parameters:
    """Return the core's parameters for a machine, and keep them for the next run."""
    line, beyond = machine.tank_line, settings.compensate and settings.beyond_valve
    return Parameters(
        axes=axis_drivers(
            machine, settings.beyond_valve, settings.dither_amplitude if settings.compensate else 0.0
        ),
        supply_pressure=machine.pump.supply_pressure,
        idle_pressure=machine.pump.idle_pressure,
        preload=line.preload if line is not None and beyond else 0.0,
        return_resistance=line.resistance if line is not None and beyond else 0.0,
        compensate=settings.compensate,
        beyond_valve=beyond,
        hold_zone=settings.hold_zone,
        command_noises=(
            command_noise(machine, 0),
            command_noise(machine, 1),
            command_noise(machine, 2),
        ),
        load_bandwidth=2.0 * math.pi * settings.load_bandwidth,
        minimum_drop=settings.minimum_drop,
        dither_frequency=settings.dither_frequency,
        adapt=settings.compensate and settings.adapt,
        adaptation=AdaptationParameters(
            settings.forgetting_time, settings.deadband_range, settings.gain_range
        ),
        flows=(_flow(machine, 0), _flow(machine, 1), _flow(machine, 2)),
    )


def axis_drivers(machine: Machine, beyond_valve: bool = True, dither: float = 0.0) -> Axes:
    """Return the actuators of a machine, with the valve alone or with what lies beyond it, too."""
    speeds = rated_speeds(machine)
    return (
        _axis_driver(machine, 0, speeds[0], beyond_valve, dither),
        _axis_driver(machine, 1, speeds[1], beyond_valve, dither),
        _axis_driver(machine, 2, speeds[2], beyond_valve, dither),
    )


def moved_spools(spools: Vec3, voltages: Vec3, axes: Axes, dt: float) -> Vec3:
    """Return where the spools are [V] after voltages [V] were in force for dt [s]."""
    return (
        after(spools[0], voltages[0], axes[0].spool, dt),
        after(spools[1], voltages[1], axes[1].spool, dt),
        after(spools[2], voltages[2], axes[2].spool, dt),
    )


def _axis_driver(machine: Machine, axis: int, speed: float, beyond_valve: bool, dither: float) -> AxisDriver:
    one, two = displacements(machine, axis)
    driver = AxisDriver(
        one, two, speed, machine.valve_of(axis).law, metering_drop=metering_drop(machine, axis)
    )
    if not beyond_valve:
        return driver
    linear, square = _hoses(machine, axis)
    check_1, open_1 = _holding(machine.drives[axis].holding_1, one)
    check_2, open_2 = _holding(machine.drives[axis].holding_2, two)
    return driver._replace(
        hose_linear=linear,
        ahead_square=square + check_1 + open_2,
        back_square=square + check_2 + open_1,
        slip=_slip(machine, axis),
        damping=machine.swing.damping if axis == 0 else 0.0,
        least_fed=_least_fed(machine, axis),
        spool=_spool(machine, axis),
        dither=dither if dither >= 0.0 else 0.5 * _hysteresis(machine, axis),
        throttled_1=_is_throttled(machine, axis, machine.drives[axis].holding_1),
        throttled_2=_is_throttled(machine, axis, machine.drives[axis].holding_2),
        fills=axis == 0 or machine.drives[axis].chambers is not None,
        oil_1=_oil(machine, axis, 1),
        oil_2=_oil(machine, axis, 2),
        middle=_middle(machine, axis),
        air=free_air(machine, axis),
        holding_1=holding(machine.drives[axis].holding_1),
        holding_2=holding(machine.drives[axis].holding_2),
        load_feedback=_load_feedback(machine, axis) if driver.metering_drop < math.inf else 0.0,
    )


def _oil(machine: Machine, axis: int, port: int) -> Yielding:
    """Return the oil of hose and chamber at a port. Merritt, Hydraulic Control Systems, section 3.1."""
    hose = machine.line(axis, port).capacitance
    modulus = math.inf if machine.oil is None else machine.oil.bulk_modulus
    if axis == 0:
        motor = machine.swing.chambers
        return Yielding(fixed=hose + (motor.port_volume / modulus if motor is not None else 0.0))
    drive = machine.boom if axis == 1 else machine.stick
    chambers, longest = drive.chambers, drive.retracted_length + drive.stroke
    if chambers is None:
        return Yielding(fixed=hose)
    if port == 1:
        retracted = chambers.head_dead_volume - drive.head_area * drive.retracted_length
        return Yielding(fixed=hose + retracted / modulus, growing=drive.head_area / modulus)
    extended = chambers.rod_dead_volume + drive.rod_area * longest
    return Yielding(fixed=hose + extended / modulus, growing=-drive.rod_area / modulus)


def _middle(machine: Machine, axis: int) -> float:
    if axis == 0:
        return 0.0
    drive = machine.boom if axis == 1 else machine.stick
    return drive.retracted_length + 0.5 * drive.stroke


def _load_feedback(machine: Machine, axis: int) -> float:
    """Return c of `load_feedback` for an axis whose flow heeds no load."""
    x, stiffness = _middle(machine, axis), 0.0
    for port, displacement in zip((1, 2), displacements(machine, axis), strict=True):
        oil = _oil(machine, axis, port)
        stiffness += displacement**2 / (oil.fixed + oil.growing * x)
    return load_feedback(machine, axis, stiffness)


def _spool(machine: Machine, axis: int) -> SpoolLaw:
    valve = machine.valve_of(axis)
    bandwidth, slew = valve.spool_bandwidth, valve.spool_slew_limit
    return SpoolLaw(
        lag=0.0 if bandwidth is None else 1.0 / (2.0 * math.pi * bandwidth),
        slew=math.inf if slew is None else slew,
    )


def _hysteresis(machine: Machine, axis: int) -> float:
    """Return the hysteresis [V] that dither takes out."""
    return machine.valve_of(axis).hysteresis or 0.0


def _hoses(machine: Machine, axis: int) -> tuple[float, float]:
    """Return what both hoses take at unit speed, linear and square part. Thesis section 4.3.3."""
    parts = [
        (displacement, machine.line(axis, port).resistance)
        for port, displacement in zip((1, 2), displacements(machine, axis), strict=True)
    ]
    if machine.drives[axis].flow_regime == "laminar":
        return sum(d**2 * resistance for d, resistance in parts), 0.0
    return 0.0, sum(d**3 * resistance for d, resistance in parts)


def _holding(valve: LoadHolding | None, displacement: float) -> tuple[float, float]:
    """Return what a load-holding valve takes at unit speed, into the actuator and fully open out of it."""
    if valve is None:
        return 0.0, 0.0
    inwards = valve.minimum_resistance if isinstance(valve, RuptureValve) else valve.check_resistance
    return displacement**3 * inwards, displacement**3 * valve.minimum_resistance


def _is_throttled(machine: Machine, axis: int, valve: LoadHolding | None) -> bool:
    """Tell whether a valve opens no wider than it must: its pilot has what a load-sensing pump leaves.

    A pump of constant pressure opens it wide; a pressure compensator meters the inlet anyway.
    """
    plain = machine.valve_of(axis).compensator is None
    return plain and isinstance(valve, CounterbalanceValve) and isinstance(machine.pump, LoadSensingPump)


def _slip(machine: Machine, axis: int) -> float:
    """Return how much slower a load makes an actuator by its leakage [rad/s per N m]; cylinders are tight.

    Half of what leaves port 1 for the case is missing at the mean of both ports. Thesis eq. 4.8.
    """
    if axis != 0:
        return 0.0
    swing, oil = machine.swing, displacements(machine, 0)[0]
    leakage = 1.0 / swing.internal_leakage_resistance + 0.5 / swing.external_leakage_resistance
    return leakage / oil**2


def _least_fed(machine: Machine, axis: int) -> float:
    """Return from how much leakage on [V] an actuator is fed that is held.

    A load that dry friction bears moves nothing: what leaks under it must not be fed.
    """
    friction = machine.swing.friction if axis == 0 else None
    if friction is None:
        return LEAST_FED
    speed = _slip(machine, axis) * friction.breakaway_torque
    return max(LEAST_FED, machine.valve_of(axis).rated_voltage * speed / rated_speeds(machine)[axis])


def command_noise(machine: Machine, axis: int) -> float:
    """Return the command [V] that a servo may make of its position's noise."""
    noise = _position_noise(machine, axis) * NOISY_SERVO
    return machine.valve_of(axis).rated_voltage * noise / rated_speeds(machine)[axis]


def _position_noise(machine: Machine, axis: int) -> float:
    """Return the standard deviation of a sample of the actuator's position [rad; m]."""
    sensor = machine.sensors.resolver if axis == 0 else machine.sensors.linear_transducer
    return (sensor.noise or 0.0) if sensor is not None else 0.0


def _flow(machine: Machine, axis: int) -> FlowParameters:
    """Return the parameters of an axis' measured flow."""
    one, two = displacements(machine, axis)
    swing = machine.swing
    return FlowParameters(
        displacement_1=one,
        displacement_2=two,
        oil_1=_oil(machine, axis, 1),
        oil_2=_oil(machine, axis, 2),
        internal_leakage=1.0 / swing.internal_leakage_resistance if axis == 0 else 0.0,
        external_leakage=1.0 / swing.external_leakage_resistance if axis == 0 else 0.0,
        position_noise=_position_noise(machine, axis),
        supply_pressure=machine.pump.supply_pressure,
        dead_time=machine.valve_of(axis).dead_time or 0.0,
        play=swing.backlash.free_way if axis == 0 and swing.backlash is not None else 0.0,
        metering_drop=metering_drop(machine, axis),
    )
