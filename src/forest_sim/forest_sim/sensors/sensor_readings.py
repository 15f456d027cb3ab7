"""What the machine's sensors report of its true state.

The true values go through one law per channel (`sensor_model`), with the errors, the noise and the
faults of a suite (`sensor_suite`, `sensor_faults`); the default suite is exact. What no sensor
measures is derived from their readings (`signal_processing`). NaN stands for what there is no
reading of.

The pump's own flow passes unmeasured: table 4.2 has no meter there.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from forest_description.geometry.kinematics import Links, tip_position, tip_velocity
from forest_description.hydraulics.pump import IdealPump
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_sim.equations.plant import (
    AxisState,
    PlantState,
    Transmission,
    at_joints,
    motor_side,
    supply_draw,
    transmissions,
)
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.actuator import inlet_flow, outlet_flow, port_pressures
from forest_sim.hydraulics.compensator import NONE
from forest_sim.hydraulics.oil_volume import filled_share
from forest_sim.hydraulics.port import port_pressure
from forest_sim.hydraulics.supply import asked_stroke, saturation
from forest_sim.sensors.inertial_unit import (
    STANDING,
    Mounting,
    UnitSpeeds,
    felt_tilts,
    filtered,
    unit_speeds,
)
from forest_sim.sensors.sensor_model import WORKS, SensorMemory, SensorModel, sample, sample_if
from forest_sim.sensors.sensor_suite import (
    CHANNELS,
    EXACT_SUITE,
    NO_DRAWS,
    RESOLVERS,
    TIME_TOLERANCE,
    Draws,
    Suite,
    conditions,
)
from forest_sim.sensors.signal_processing import (
    BOOM_UNIT,
    STICK_UNIT,
    Measurement,
    Motion,
    SpeedEstimate,
    force,
    measurement,
    positions,
    updated_estimates,
)
from forest_sim.solver.integrator import Simulation, ports_of


class Surroundings(NamedTuple):
    """What sensors measure outside of hydraulics and crane."""

    engine_speed: float = 2500.0 * 2.0 * math.pi / 60.0  # [rad/s]
    temperatures: Vec3 = (313.15, 313.15, 313.15)  # [K] tank, pump case, swing motor case
    tilt: tuple[float, float] = (0.0, 0.0)  # [rad] pitch, roll
    rig: bool = False  # a test rig: the second flow meter is at the far end of the swing's hose 1


NOMINAL = Surroundings()
CHANNEL_COUNT = len(CHANNELS)


class SensorState(NamedTuple):
    """What the sensors and the estimators of the 6 speeds, joints then actuators, remember."""

    channels: tuple[SensorMemory, ...]
    estimates: tuple[SpeedEstimate, ...]
    time: float  # [s] since the start
    next_sample: float  # [s]
    unit_speeds: UnitSpeeds = STANDING  # at the last call


def surroundings(machine: Machine) -> Surroundings:
    """Return the surroundings of a machine at work: governed speed, warm oil, tilt as in its file."""
    pump, tilt, oil = machine.pump, (0.0, machine.manipulator.platform_tilt), machine.oil
    speed = NOMINAL.engine_speed if isinstance(pump, IdealPump) else pump.shaft_speed
    warm = NOMINAL.temperatures if oil is None else (oil.reference_temperature,) * 3
    return Surroundings(speed, warm, tilt)


def at_rest(
    simulation: Simulation,
    p: PlantParameters,
    suite: Suite = EXACT_SUITE,
    around: Surroundings = NOMINAL,
) -> SensorState:
    """Return sensors and estimators that have seen the machine stand still at this state."""
    states = [
        sample(c._replace(mode=WORKS), SensorMemory(x, x), x, 0.0, 0.0)[0]
        for c, x in zip(suite.channels, true_values(simulation, p, around), strict=True)
    ]
    for i in (BOOM_UNIT, STICK_UNIT):  # what its filter is off is nothing
        states[i] = SensorMemory(0.0, states[i].reading)
    seen = positions(tuple([state.reading for state in states]), suite.angles, p)
    estimates = tuple(SpeedEstimate(position, 0.0, 0.0) for position in seen)
    return SensorState(tuple(states), estimates, 0.0, suite.period)


class Sensors(NamedTuple):
    """What stays from one sample to the next."""

    plant: PlantParameters
    channels: tuple[SensorModel, ...]  # as they work now
    period: float  # [s] between samples; 0: whenever asked
    around: Surroundings
    angles: int = RESOLVERS  # what boom's and stick's are made of
    mounting: Mounting = Mounting()  # of their inertial units


class Report(NamedTuple):
    """What the sensors say, and what is true."""

    seen: Measurement
    joints: Motion  # angles [rad], rates [rad/s], actuator torques [N m]
    tip: Vec3  # [m]
    tip_velocity: Vec3  # [m/s]


def measure(
    simulation: Simulation,
    state: SensorState,
    p: PlantParameters,
    dt: float,
    suite: Suite = EXACT_SUITE,
    draws: Draws = NO_DRAWS,
    around: Surroundings = NOMINAL,
) -> tuple[SensorState, Measurement]:
    """Sample every sensor, `dt` [s] after the last call. Thesis table 4.2."""
    channels = conditions(suite, state.time + dt, draws.uniform)
    return sampled(state, simulation, draws.normal, sensors(p, suite, around)._replace(channels=channels), dt)


def sensors(p: PlantParameters, suite: Suite, around: Surroundings = NOMINAL) -> Sensors:
    """Return what stays from one sample to the next, while nothing is wrong with the suite."""
    return Sensors(p, suite.channels, suite.period, around, suite.angles, suite.mounting)


def report(
    state: SensorState, simulation: Simulation, normals: Sequence[float], k: tuple[Sensors, Links], dt: float
) -> tuple[SensorState, Report]:
    """Do as `sampled`, and tell the truth beside; `k` holds the lengths of the machine's links, too."""
    s, links = k
    state, seen = sampled(state, simulation, normals, s, dt)
    return state, _with_truth(seen, simulation, s.plant, links)


def report_at_rest(state: SensorState, simulation: Simulation, k: tuple[Sensors, Links]) -> Report:
    """Return what the sensors have said last, and the truth beside; before the first sample.

    Args:
        state: of `at_rest`.
        simulation: the machine, as `at_rest` had it.
        k: as `report`.
    """
    s, links = k
    readings = tuple([channel.reading for channel in state.channels])
    flow, used = _supply(simulation, ports_of(simulation, s.plant), s.plant)
    position = positions(readings, s.angles, s.plant)
    seen = measurement(readings, position, state.estimates, s.plant, flow, used)
    return _with_truth(seen, simulation, s.plant, links)


def _with_truth(seen: Measurement, simulation: Simulation, p: PlantParameters, links: Links) -> Report:
    true = true_joints(simulation, p)
    tip = tip_position(true.position, links)
    return Report(seen, true, tip, tip_velocity(true.position, true.speed, links))


def sampled(
    state: SensorState, simulation: Simulation, normals: Sequence[float], s: Sensors, dt: float
) -> tuple[SensorState, Measurement]:
    """Do as `measure`, for machine code, too.

    Args:
        state: what the last call returned.
        simulation: the machine.
        normals: draws from the standard normal distribution, one for each channel.
        s: what stays.
        dt: time since the last call [s].
    """
    time = state.time + dt
    due = time > state.next_sample - TIME_TOLERANCE
    ports = ports_of(simulation, s.plant)
    before, channels, speeds = state.channels, s.channels, state.unit_speeds
    true = _true_values(simulation, ports, s.plant, s.around)
    if channels[BOOM_UNIT].time_constant > 0.0:
        speeds, channels, true = _by_inertia(speeds, simulation, normals, s, true, dt)
    samples = tuple(
        [sample_if(due, channels[i], before[i], true[i], dt, normals[i]) for i in range(CHANNEL_COUNT)]
    )
    readings = tuple([samples[i][1] for i in range(CHANNEL_COUNT)])
    position = positions(readings, s.angles, s.plant)
    estimates = updated_estimates(state.estimates, position, dt, due)
    next_sample = max(time, state.next_sample + s.period) if due else state.next_sample
    memories = tuple([samples[i][0] for i in range(CHANNEL_COUNT)])
    after = SensorState(memories, estimates, time, next_sample, speeds)
    flow, used = _supply(simulation, ports, s.plant)
    return after, measurement(readings, position, estimates, s.plant, flow, used)


def _by_inertia(
    before: UnitSpeeds,
    simulation: Simulation,
    normals: Sequence[float],
    s: Sensors,
    true: tuple[float, ...],
    dt: float,
) -> tuple[UnitSpeeds, tuple[SensorModel, ...], tuple[float, ...]]:
    """Return how the inertial units move, and channels and values with what their filters take in."""
    links, c = simulation.plant, s.channels
    now = unit_speeds(links, s.mounting)
    tilts = felt_tilts(before, now, links, s.mounting, dt)
    boom, boom_tilt = filtered(c[BOOM_UNIT], true[BOOM_UNIT], tilts[0], normals[BOOM_UNIT], dt)
    stick, stick_tilt = filtered(c[STICK_UNIT], true[STICK_UNIT], tilts[1], normals[STICK_UNIT], dt)
    return now, _with_units(c, boom, stick), _with_units(true, boom_tilt, stick_tilt)


def _with_units(all_channels: tuple[Any, ...], boom: Any, stick: Any) -> tuple[Any, ...]:
    """Return what there is of each channel, with other values of the inertial units."""
    head = tuple([all_channels[i] for i in range(BOOM_UNIT)])
    tail = tuple([all_channels[STICK_UNIT + 1 + i] for i in range(CHANNEL_COUNT - STICK_UNIT - 1)])
    return (*head, boom, stick, *tail)


def true_joints(simulation: Simulation, p: PlantParameters) -> Motion:
    """Return the links' true angles [rad], rates [rad/s] and their actuators' torques [N m].

    They are what the tip goes by: links that give way have their bending in them, sensors have not.
    """
    swing, boom, stick = simulation.plant.swing, simulation.plant.boom, simulation.plant.stick
    joints = at_joints(simulation.plant, p)
    t_1, t_2, t_3 = _transmissions(joints, p)
    motor = motor_side(joints, p)
    return Motion(
        (swing.angle, boom.angle, stick.angle),
        (swing.rate, boom.rate, stick.rate),
        (
            _true_force(motor, p.swing, t_1) * t_1.arm,
            _true_force(joints.boom, p.boom, t_2) * t_2.arm,
            _true_force(joints.stick, p.stick, t_3) * t_3.arm,
        ),
    )


def deflections(simulation: Simulation, p: PlantParameters) -> Vec3:
    """Return by how much the links are ahead of their joints [rad], which no sensor tells; 0 if rigid."""
    links, joints = simulation.plant, at_joints(simulation.plant, p)
    return (
        links.swing.angle - joints.swing.angle,
        links.boom.angle - joints.boom.angle,
        links.stick.angle - joints.stick.angle,
    )


def pump(simulation: Simulation, p: PlantParameters) -> tuple[float, float]:
    """Return the pump's displacement over its greatest, 0..1, and the engine's speed [rad/s]."""
    plant, drive = simulation.plant, p.supply.drive
    displacement = plant.pump.stroke if drive.up > 0.0 else asked_stroke(plant.supply, p.supply).value
    return displacement, plant.pump.speed if drive.inertia > 0.0 else drive.speed


def compensators(simulation: Simulation, p: PlantParameters) -> Vec3:
    """Return the openings of the valves' pressure compensators, 0 shut .. 1 open; NaN for a valve without."""
    swing, boom, stick = (
        lifts.compensator if valve.compensator.sort != NONE else math.nan
        for lifts, valve in zip(simulation.midpoint.lifts, p.valves, strict=True)
    )
    return swing, boom, stick


def true_values(simulation: Simulation, p: PlantParameters, around: Surroundings) -> tuple[float, ...]:
    """Return what every channel would read if it were exact, in the order of `CHANNELS`."""
    ports = ports_of(simulation, p)
    return _true_values(simulation, ports, p, around)


def _true_values(
    simulation: Simulation, ports: tuple[Ports, Ports, Ports], p: PlantParameters, around: Surroundings
) -> tuple[float, ...]:
    plant, spools = at_joints(simulation.plant, p), simulation.spools
    supply = plant.supply.pressure
    t_1, t_2, t_3 = _transmissions(plant, p)
    motor = motor_side(plant, p)
    second = _motor_inflow(motor, p.swing) if around.rig else plant.stick.flow_1
    return (
        *(plant.swing.angle, plant.boom.angle, plant.stick.angle),
        *(t_2.position, t_3.position),
        *axis_pressures(motor, p.swing, t_1, ports[0], supply),
        *axis_pressures(plant.boom, p.boom, t_2, ports[1], supply),
        *axis_pressures(plant.stick, p.stick, t_3, ports[2], supply),
        supply,
        *(plant.swing.flow_1, second),
        *around.temperatures,
        plant.pump.speed if p.supply.drive.inertia > 0.0 else around.engine_speed,
        *(spools[0].position, spools[1].position, spools[2].position),
        *around.tilt,
        _case_drain_flow(motor, p.swing),
        *(plant.boom.angle, plant.boom.angle + plant.stick.angle),
    )


def _transmissions(plant: PlantState, p: PlantParameters) -> tuple[Transmission, Transmission, Transmission]:
    return transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)


def _true_force(s: AxisState, axis: Axis, t: Transmission) -> float:
    one, two = port_pressures(t.arm * s.rate, s.pressure_1, s.pressure_2, axis.actuator)
    return force(one, two, axis.actuator)


def axis_pressures(
    s: AxisState, axis: Axis, t: Transmission, ports: Ports, supply: float
) -> tuple[float, float, float, float]:
    """Return the pressures [Pa] of port 1 at valve and actuator, then of port 2."""
    one, two = port_pressures(t.arm * s.rate, s.pressure_1, s.pressure_2, axis.actuator)
    valve_1 = port_pressure(s.pressure_1, s.flow_1, ports.port_1, supply)
    valve_2 = port_pressure(s.pressure_2, -s.flow_2, ports.port_2, supply)
    return valve_1, one, valve_2, two


def _supply(
    simulation: Simulation, ports: tuple[Ports, Ports, Ports], p: PlantParameters
) -> tuple[float, float]:
    """Return what the axes draw from the pumps [m^3/s], and which part that is of what these can give."""
    flow = supply_draw(simulation.plant, ports).flow
    return flow, saturation(flow, simulation.plant.supply.pressure, p.supply, simulation.plant.pump)


def _case_drain_flow(s: AxisState, axis: Axis) -> float:
    """Return the motor's external leakage [m^3/s]: what goes in and does not come out. Thesis eq. 4.8."""
    a = axis.actuator
    return inlet_flow(s.rate, s.pressure_1, s.pressure_2, a) - outlet_flow(
        s.rate, s.pressure_1, s.pressure_2, a
    )


def _motor_inflow(s: AxisState, axis: Axis) -> float:
    """Return the flow into the motor at port 1 [m^3/s]."""
    through = s.rate * filled_share(s.rate, s.pressure_1, s.pressure_2, axis.oil_1)
    return inlet_flow(through, s.pressure_1, s.pressure_2, axis.actuator)
