"""What every sensor reads along a whole run: the true values by channel, and the channels' law on columns.

The scalar laws are `forest_sim.sensors.sensor_readings` (what is true) and
`forest_sim.sensors.sensor_model` (what is read of it); here
both work on all rows of a run at once, a hundred times faster, because a fit asks for them some hundred
times. Tests compare the two.

| array | shape | holds |
|---|---|---|
| states | N, 121 | what `forest_sim.solver.state_recording.STATE` names |
| a column | N | one channel of `forest_sim.sensors.sensor_suite.CHANNELS`, in its unit |
"""

import math
import zlib
from collections.abc import Mapping

import numpy as np
import scipy

from forest_description.geometry.linkage import Linkage
from forest_description.hydraulics.valve_characteristic import (
    POLYNOMIAL,
    SHUT,
    TABLE,
    Curve,
    Direction,
    ValveLaw,
    leakage_at,
)
from forest_description.types import AXES, Floats
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.actuator import inlet_flow, outlet_flow, port_pressures
from forest_sim.hydraulics.compensator import NONE, in_series
from forest_sim.hydraulics.port import port_pressure, with_resistance
from forest_sim.sensors.sensor_model import ABSENT, SensorModel
from forest_sim.sensors.sensor_readings import Surroundings
from forest_sim.sensors.sensor_suite import CHANNELS, Suite
from forest_sim.sensors.signal_processing import SPEED_BANDWIDTH
from forest_sim.solver.state_recording import STATE

Columns = dict[str, Floats]

PLACE = {name: place for place, name in enumerate(STATE)}


def length_and_arm(angle: Floats, linkage: Linkage) -> tuple[Floats, Floats]:
    """Return cylinder lengths and lever arms [m] at joint angles [rad]. Thesis eq. 3.16, App. A."""
    a, b = linkage.pivot_to_base, linkage.pivot_to_rod
    turned = angle + linkage.angle_offset
    length = np.sqrt(a * a + b * b - 2.0 * a * b * np.cos(turned))
    return length, a * b * np.sin(turned) / length


def true_columns(
    states: Floats, p: PlantParameters, around: Surroundings, bench: bool = False, valves: bool = True
) -> Columns:
    """Return the true value of every channel, one column each.

    Args:
        states: of the plant.
        p: the plant; one for all rows.
        around: engine, temperatures and tilt.
        bench: whether the second flow meter sits at the far end of hose 1 instead of at the stick.
        valves: whether the pressures at the valves are wanted, which take the longest.
    """
    of: Columns = {}
    for axis, name in enumerate(AXES):
        of |= _axis_columns(states, p, axis, name, valves)
    of["supply_pressure"] = states[:, PLACE["supply_pressure"]]
    of["swing_flow"] = states[:, PLACE["swing_flow_1"]]
    of["stick_flow"] = states[:, PLACE["stick_flow_1"]]
    rate, p_1, p_2 = _motor_rate(states, p), *(states[:, PLACE[f"swing_pressure_{i}"]] for i in (1, 2))
    entering: Floats = inlet_flow(rate, p_1, p_2, p.swing.actuator)  # type: ignore[arg-type, assignment]
    leaving: Floats = outlet_flow(rate, p_1, p_2, p.swing.actuator)  # type: ignore[arg-type, assignment]
    of["case_drain"] = entering - leaving
    if bench:
        of["stick_flow"] = entering
    tank, pump, motor = around.temperatures
    steady = {"tank_temperature": tank, "pump_temperature": pump, "motor_temperature": motor}
    steady |= {"platform_pitch": around.tilt[0], "platform_roll": around.tilt[1]}
    droops = p.supply.drive.inertia > 0.0
    of["engine_speed"] = (
        states[:, PLACE["pump_speed"]] if droops else np.full(len(states), around.engine_speed)
    )
    return of | {name: np.full(len(states), value) for name, value in steady.items()}


def _motor_rate(states: Floats, p: PlantParameters) -> Floats:
    """Return the rate of the swing's motor [rad/s]: behind a gear with play its own."""
    if p.drive.gear.inertia > 0.0:
        return states[:, PLACE["drive_motor_rate"]]
    return states[:, joint_places(p)[0] + 1]


def joint_places(p: PlantParameters) -> list[int]:
    """Return where `STATE` has the joints' angles; their rates are right behind."""
    links = zip(AXES, p.elastic.links, strict=True)
    return [PLACE[f"{axis}_root_angle" if link.inertia > 0.0 else f"{axis}_angle"] for axis, link in links]


def _axis_columns(states: Floats, p: PlantParameters, place: int, name: str, valves: bool) -> Columns:
    own: Axis = (p.swing, p.boom, p.stick)[place]
    p_1, p_2, q_1, q_2 = (states[:, 6 * place + k] for k in range(2, 6))
    joint = joint_places(p)[place]
    angle, rate = states[:, joint], states[:, joint + 1]
    spool, arm = states[:, PLACE[f"{name}_spool_position"]], np.ones(len(states))
    of: Columns = {f"{name}_resolver": angle, f"{name}_spool": spool}
    if place > 0:
        linkage = p.boom_linkage if place == 1 else p.stick_linkage
        of[f"{name}_transducer"], arm = length_and_arm(angle, linkage)
    if place == 0:
        rate = _motor_rate(states, p)
    one, two = port_pressures(arm * rate, p_1, p_2, own.actuator)  # type: ignore[arg-type]
    of[f"{name}_pressure_1_actuator"], of[f"{name}_pressure_2_actuator"] = one, two  # type: ignore[assignment]
    if valves:
        law, tank, vapour = p.valves[place].law, states[:, PLACE["tank_seen"]], -p.supply.oil.above_vapour
        supply, more = states[:, PLACE["supply_pressure"]] - tank, _metering(states, p, place, name)
        for port, hose, flow in ((1, p_1, q_1), (2, p_2, -q_2)):
            read = tank + valve_pressures(hose - tank, flow, spool, supply, law, port, more)
            of[f"{name}_pressure_{port}_valve"] = np.maximum(vapour, read)
    return of


def _metering(states: Floats, p: PlantParameters, place: int, name: str) -> Floats | None:
    """Return the resistance [Pa s^2/m^6] of a valve's compensator; None without one."""
    compensator = p.valves[place].compensator
    if compensator.sort == NONE:
        return None
    rows = states[:, PLACE[f"{name}_lift_compensator"]].tolist()
    return np.array([in_series(opening, compensator) for opening in rows])


def valve_pressures(
    hose: Floats,
    flow: Floats,
    spool: Floats,
    supply: Floats,
    law: ValveLaw,
    port: int,
    more: Floats | None = None,
) -> Floats:
    """Return the pressure [Pa] between the spool's edges and a hose; behind shut edges it is the hose's.

    Thesis eq. 3.1, 4.1. All pressures are above that of the tank line.

    Args:
        hose: pressure in the hose [Pa].
        flow: from the valve into it [m^3/s].
        spool: position [V].
        supply: P_s [Pa].
        law: the valve.
        port: 1 or 2.
        more: resistance of a compensator in series with the edge to the supply [Pa s^2/m^6].
    """
    metering = np.zeros(len(spool)) if more is None else more
    forward, backward = openings(spool, law.forward, law.curve), openings(-spool, law.backward, law.curve)
    to_supply, to_tank = (forward, backward) if port == 1 else (backward, forward)
    c_supply, c_tank = (
        (law.forward.resistance_1, law.backward.resistance_1)
        if port == 1
        else (law.backward.resistance_2, law.forward.resistance_2)
    )
    pressure = hose.copy()
    leak, fed = leakages(spool, law, port)
    filled, drained = to_supply > SHUT, to_tank > SHUT
    fill = c_supply / np.maximum(to_supply, SHUT) ** 2 + metering
    drain = c_tank / np.maximum(to_tank, SHUT) ** 2
    pressure[filled] = _behind_edge(flow, fill, supply, leak, fed * supply)[filled]
    pressure[drained] = _behind_edge(flow, drain, np.zeros(len(flow)), leak, fed * supply)[drained]
    if law.leakage > 0.0:
        shut = ~(filled | drained)
        pressure[shut] = ((fed * supply - flow) / (2.0 * leak))[shut]
    odd = filled & (drained | (law.load_check != 0))
    for k in np.flatnonzero(odd).tolist():
        ports = valve_ports(float(spool[k]), law)
        here = with_resistance(ports.port_1 if port == 1 else ports.port_2, float(metering[k]))
        pressure[k] = port_pressure(float(hose[k]), float(flow[k]), here, float(supply[k]))
    return pressure


def leakages(spool: Floats, law: ValveLaw, port: int) -> tuple[Floats, Floats]:
    """Return what leaks past a port's edges [m^3/(s Pa)] at spool positions [V]: their mean, the supply's."""
    if law.edge_ratio == 1.0:
        same = np.full(len(spool), law.leakage)
        return same, same
    rows = [leakage_at(float(x), law) for x in spool]
    mean, skew = np.array([row.mean for row in rows]), np.array([row.skew for row in rows])
    return mean, mean + (skew if port == 1 else -skew)


def _behind_edge(flow: Floats, resistance: Floats, source: Floats, leak: Floats, fed: Floats) -> Floats:
    """Return the pressure [Pa] behind one open edge from a source [Pa], what leaks included (`port.meet`)."""
    y = flow - fed + 2.0 * leak * source
    o = 2.0 * y / (1.0 + np.sqrt(1.0 + 8.0 * leak * resistance * np.abs(y)))
    return source - resistance * o * np.abs(o)


def openings(voltage: Floats, way: Direction, curve: Curve) -> Floats:
    """Return u(s) of `valve_characteristic.opening_at` for a column of spool positions [V]."""
    span = way.rated_voltage - way.deadband_voltage
    s = np.clip((voltage - way.deadband_voltage) / span, 0.0, 1.0)
    if curve.sort == POLYNOMIAL:
        ratio = np.polynomial.polynomial.polyval(s, np.array(curve.values))
        return np.where(s > 0.0, 1.0 / np.sqrt(ratio), 0.0)
    if curve.sort == TABLE:
        count = int(np.argmax(np.array(curve.knots) >= 1.0)) + 1
        return np.interp(s, curve.knots[:count], curve.values[:count])
    return s


def read(true: Mapping[str, Floats], suite: Suite, period: float, run: str = "") -> Columns:
    """Return what the suite reads of the true values; NaN throughout where there is no sensor.

    The law is `forest_sim.sensors.sensor_model.sample`. Samples that come rarer than the rows are held.

    Args:
        true: by channel.
        suite: whose channels, seed and period count; its faults do not.
        period: of the rows [s].
        run: name of the run: another one has other noise from the same units.
    """
    count = len(next(iter(true.values())))
    generator = np.random.default_rng([suite.seed, 1, zlib.crc32(run.encode())])
    normal = generator.standard_normal((len(CHANNELS), count))
    every = max(1, round(suite.period / period))
    held = np.arange(count) // every * every
    found: Columns = {}
    for place, name in enumerate(CHANNELS):
        if name in true:
            found[name] = _sampled(true[name], suite.channels[place], period, normal[place])[held]
    return found


def lagged(true: Floats, time_constant: float, period: float) -> Floats:
    """Return what a first-order lag leaves of a column that each row holds from the last one on."""
    if time_constant <= 0.0:
        return true
    return _smoothed(true, math.exp(-period / time_constant), float(true[0]))


def _sampled(true: Floats, c: SensorModel, period: float, normal: Floats) -> Floats:
    """Return one channel's readings. Thesis table 4.2, section 4.3.2.4."""
    if c.mode == ABSENT:
        return np.full(len(true), math.nan)
    kept = lagged(true, c.time_constant, period)
    reading = c.gain * kept + c.bias + c.noise * normal
    if c.floor > 0.0:
        reading = np.where(kept < 0.0, -1.0, 1.0) * np.maximum(np.abs(reading), c.floor)
    if c.resolution > 0.0:
        reading = c.resolution * np.floor(reading / c.resolution + 0.5)
    return np.clip(reading, c.low, c.high)


def speeds(position: Floats, period: float) -> Floats:
    """Return the causal speed estimate of a machine (`signal_processing.estimate_speed`)."""
    keep = math.exp(-2.0 * math.pi * SPEED_BANDWIDTH * period)
    difference = np.diff(position, prepend=position[0]) / period
    return _smoothed(difference, keep, 0.0)


def _smoothed(column: Floats, keep: float, before: float) -> Floats:
    """Return y[n] = (1 - k) x[n] + k y[n-1] of a column, from a value before it on."""
    filtered, _ = scipy.signal.lfilter([1.0 - keep], [1.0, -keep], column, zi=[keep * before])
    return np.asarray(filtered, dtype=np.float64)
