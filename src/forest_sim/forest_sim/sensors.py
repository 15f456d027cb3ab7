"""What the machine's sensors report of its true state.

Positions are sampled; speeds are what a real machine can know: the backward difference of sampled positions
behind a first-order low-pass (`SPEED_BANDWIDTH`), causal, so it lags. Torques and forces come from the
pressures at the actuators. Noise, range and accuracy of Thesis table 4.2 are not modelled yet: these sensors
are exact.

| quantity | shape | unit |
|---|---|---|
| joint angle, rate, torque | 3 (swing, boom, stick) | rad, rad/s, N m |
| actuator position, speed, force | 3 | rad or m, rad/s or m/s, N m or N |
| pressures | 12: axis, port, place (valve, actuator) | Pa |
| flows | 2: into port 1 of swing and stick | m^3/s |
"""

import math
from typing import NamedTuple

from forest_sim.actuator import inlet_flow, outlet_flow, port_pressures
from forest_sim.integrator import Simulation, Triple
from forest_sim.line import Port, is_shut, meet
from forest_sim.parameters import Axis, PlantParameters
from forest_sim.plant import AxisState, Ports, Transmission, ports_at, supply_draw, transmissions
from forest_sim.supply import saturation

SPEED_BANDWIDTH = 25.0  # [Hz]


class Motion(NamedTuple):
    """Positions, speeds and efforts of three joints or actuators."""

    position: Triple
    speed: Triple
    effort: Triple


class SpeedEstimate(NamedTuple):
    """Memory of the speed estimators: last sampled positions and filtered speeds, joints then actuators."""

    positions: tuple[float, ...]
    speeds: tuple[float, ...]


class Measurement(NamedTuple):
    """One sample of every sensor."""

    joints: Motion
    actuators: Motion
    pressures: tuple[float, ...]
    flows: tuple[float, float]
    supply_pressure: float
    supply_flow: float
    supply_saturation: float
    case_drain_flow: float


def at_rest(simulation: Simulation, p: PlantParameters) -> SpeedEstimate:
    """Return estimators that have seen the machine stand still at this state."""
    return SpeedEstimate(_positions(simulation, p), (0.0,) * 6)


def measure(
    simulation: Simulation, estimate: SpeedEstimate, p: PlantParameters, dt: float
) -> tuple[SpeedEstimate, Measurement]:
    """Sample every sensor, `dt` [s] after the last sample. Thesis table 4.2."""
    plant = simulation.plant
    estimate = _estimate_speeds(estimate, _positions(simulation, p), dt)
    parts = (p.swing, p.boom, p.stick), _transmissions(simulation, p), ports_at(simulation.spools, p)
    states = plant.swing, plant.boom, plant.stick
    axes = tuple(zip(states, *parts, strict=True))
    draw = supply_draw(plant, parts[2])
    forces = tuple(_force(state, axis, t) for state, axis, t, _ in axes)
    torques = tuple(force * t.arm for force, (_, _, t, _) in zip(forces, axes, strict=True))
    return estimate, Measurement(
        joints=Motion(_triple(estimate.positions[:3]), _triple(estimate.speeds[:3]), _triple(torques)),
        actuators=Motion(_triple(estimate.positions[3:]), _triple(estimate.speeds[3:]), _triple(forces)),
        pressures=tuple(
            value
            for state, axis, t, ports in axes
            for value in _pressures(state, axis, t, ports, plant.supply.pressure)
        ),
        flows=(plant.swing.flow_1, plant.stick.flow_1),
        supply_pressure=plant.supply.pressure,
        supply_flow=draw.flow,
        supply_saturation=saturation(draw.flow, plant.supply.pressure, p.supply),
        case_drain_flow=_case_drain_flow(plant.swing, p.swing),
    )


def true_joints(simulation: Simulation, p: PlantParameters) -> Motion:
    """Return the joints' true angles [rad], rates [rad/s] and actuator torques [N m]."""
    plant = simulation.plant
    torques = (
        _force(state, axis, t) * t.arm
        for state, axis, t in zip(
            (plant.swing, plant.boom, plant.stick),
            (p.swing, p.boom, p.stick),
            _transmissions(simulation, p),
            strict=True,
        )
    )
    return Motion(
        (plant.swing.angle, plant.boom.angle, plant.stick.angle),
        (plant.swing.rate, plant.boom.rate, plant.stick.rate),
        _triple(tuple(torques)),
    )


def _positions(simulation: Simulation, p: PlantParameters) -> tuple[float, ...]:
    plant = simulation.plant
    lengths = (t.position for t in _transmissions(simulation, p))
    return plant.swing.angle, plant.boom.angle, plant.stick.angle, *lengths


def _transmissions(
    simulation: Simulation, p: PlantParameters
) -> tuple[Transmission, Transmission, Transmission]:
    plant = simulation.plant
    return transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)


def _estimate_speeds(estimate: SpeedEstimate, positions: tuple[float, ...], dt: float) -> SpeedEstimate:
    keep = math.exp(-2.0 * math.pi * SPEED_BANDWIDTH * dt)
    speeds = tuple(
        keep * speed + (1.0 - keep) * (new - old) / dt
        for speed, old, new in zip(estimate.speeds, estimate.positions, positions, strict=True)
    )
    return SpeedEstimate(positions, speeds)


def _force(s: AxisState, axis: Axis, t: Transmission) -> float:
    """Return the actuator's pressure force [N; N m], friction not included. Thesis eq. 3.17, 3.19."""
    one, two = port_pressures(t.arm * s.rate, s.pressure_1, s.pressure_2, axis.actuator)
    return axis.actuator.own_displacement_1 * one - axis.actuator.own_displacement_2 * two


def _pressures(
    s: AxisState, axis: Axis, t: Transmission, ports: Ports, supply: float
) -> tuple[float, float, float, float]:
    """Return the pressures [Pa] of port 1 at valve and actuator, then of port 2."""
    one, two = port_pressures(t.arm * s.rate, s.pressure_1, s.pressure_2, axis.actuator)
    valve_1 = _valve_pressure(s.pressure_1, s.flow_1, ports.port_1, supply)
    valve_2 = _valve_pressure(s.pressure_2, -s.flow_2, ports.port_2, supply)
    return valve_1, one, valve_2, two


def _valve_pressure(hose: float, flow: float, port: Port, supply: float) -> float:
    """Return the pressure [Pa] between the spool's edges and the hose; behind shut edges it is the hose's."""
    return hose if is_shut(port) else meet(flow, 0.0, port, supply).pressure


def _case_drain_flow(s: AxisState, axis: Axis) -> float:
    """Return the motor's external leakage [m^3/s]: what goes in and does not come out. Thesis eq. 4.8."""
    u, a = s.rate, axis.actuator
    return inlet_flow(u, s.pressure_1, s.pressure_2, a) - outlet_flow(u, s.pressure_1, s.pressure_2, a)


def _triple(values: tuple[float, ...]) -> Triple:
    return values[0], values[1], values[2]
