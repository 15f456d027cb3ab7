"""The deadband-compensating valve driver's core: it alone knows how a real valve differs from an ideal one.

An ideal valve has no lap, is linear, and always sees the nominal pressure drop; its command is a wished
actuator speed. The real one opens only beyond its deadband, and its flow goes with the root of the pressure
drop that the load leaves:

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| c, v | command of the ideal valve; the actuator speed it asks for | V; m/s, rad/s |
| A_1, A_2 | displacement of port 1, 2 | m^2; m^3/rad |
| F | load: A_1 P_1 - A_2 P_2 from the measured pressures, low-passed | N; N m |
| N | pressure force left for the orifices: A_in P_s - sgn(v) F | N; N m |
| C_1, C_2 | the open valve's resistance in the direction of v, port 1's edge and port 2's | Pa s^2/m^6 |
| S | C_1 A_1^3 + C_2 A_2^3: both orifices' share, reduced to the actuator | N s^2/m^2; N m s^2 |

At steady speed and full opening N = S v^2 (Thesis eq. 3.1 at both ports of 3.14), hence the opening
|v| sqrt(S / N). Beyond the valve, hoses take part of N, a motor leaks, its hoses fill after a rest, and the
spool needs time to cross its overlap; `beyond_valve` allows for these.
"""

import math
from typing import NamedTuple

from forest_description.actuation import displacements, rated_speeds
from forest_description.machine import Machine
from forest_description.valve import ValveLaw, voltage_for_opening

Triple = tuple[float, float, float]
Loads = Triple

LOWEST_SUPPLY = 0.25  # of the idle supply pressure: below, the pump is off or its transducer broken
HIGHEST = 2.0  # of the nominal supply pressure
FILLING = 60.0  # [rad/s] low-pass of the ports' mean pressure
LEAST_PART = 0.1  # of a port's usual root of the drop, taken to remain
LOWEST_PORT = 1e6  # [Pa] below tank: behind a long hose a port may read less than nothing for a moment


class AxisDriver(NamedTuple):
    """What the driver knows of one actuator."""

    displacement_1: float
    displacement_2: float
    rated_speed: float  # at `rated_voltage` of the ideal valve
    valve: ValveLaw
    hose_linear: float = 0.0  # [N s/m; N m s] both hoses' loss that goes with the speed, at the actuator
    hose_square: float = 0.0  # [N s^2/m^2; N m s^2] and with its square
    slip: float = 0.0  # [rad/s per N m] speed that the motor's leakage takes under load
    spool_lag: float = 0.0  # [s]; 0: the spool follows at once


class Settings(NamedTuple):
    """What a user may set; the node's parameters have these names and defaults."""

    compensate: bool = True  # False: commands pass unchanged, for experiments
    beyond_valve: bool = True  # allow for hoses, leakage, filling and the spool's lag, too
    hold_zone: float = 0.02  # [V] commands up to this much leave the spool centred
    load_bandwidth: float = 1.0  # [Hz] of the loads' low-pass
    minimum_drop: float = 0.1  # share of the unloaded pressure force that is taken to remain under any load


class Parameters(NamedTuple):
    """What the driver knows of the machine."""

    axes: tuple[AxisDriver, AxisDriver, AxisDriver]
    supply_pressure: float  # [Pa], the highest that the pump keeps
    idle_pressure: float  # [Pa], the least, while nobody draws; taken where it is not measured
    compensate: bool
    beyond_valve: bool
    hold_zone: float  # [V]
    load_bandwidth: float  # [rad/s]
    minimum_drop: float


class State(NamedTuple):
    """Filtered loads [N m, N, N]; `primed` once the first pressures have arrived."""

    loads: Loads
    primed: bool
    means: Triple = (0.0, 0.0, 0.0)  # [Pa] of both ports
    spools: Triple = (0.0, 0.0, 0.0)  # [V] where the spools should be by now


class Pressures(NamedTuple):
    """What the transducers say [Pa]: at both actuator ports of each axis, and at the pump."""

    port_1: Triple
    port_2: Triple
    supply: float


REST = State((0.0, 0.0, 0.0), False)


def step(
    state: State, command: Triple, pressures: Pressures | None, p: Parameters, dt: float
) -> tuple[State, Triple]:
    """Return the amplifier voltages [V] for commands [V] of ideal valves.

    Args:
        state: what the last step returned; `REST` at first.
        command: wished actuator speeds, swing, boom, stick, as voltages of ideal valves [V].
        pressures: None when no fresh measurement is there: the nominal drop is assumed, as it is for
            pressures that cannot be true.
        p: what the driver knows of the machine.
        dt: time since the last step [s].
    """
    if pressures is not None and not plausible(pressures, p):
        pressures = None
    state = _filter_loads(state, pressures, p, dt)
    supply = pressures.supply if pressures is not None else p.idle_pressure
    volts, spools = [], []
    for i, axis in enumerate(p.axes):
        mean = state.means[i] if pressures is not None and p.beyond_valve and i == 0 else None
        wanted = _axis_voltage(command[i], state.loads[i], mean, supply, axis, p)
        applied, spool = (
            _across_overlap(wanted, state.spools[i], axis, dt) if p.beyond_valve else (wanted, 0.0)
        )
        volts.append(applied)
        spools.append(spool)
    return state._replace(spools=(spools[0], spools[1], spools[2])), (volts[0], volts[1], volts[2])


def _across_overlap(wanted: float, spool: float, axis: AxisDriver, dt: float) -> tuple[float, float]:
    """Return the voltage that takes a lagging spool over its overlap at once, and where it is dt [s] later.

    A first-order spool reaches a voltage just beyond the overlap only after some time constants; asked for
    more, it is there in one period. Outside the overlap the command's lead makes up for the lag.
    """
    if axis.spool_lag == 0.0:
        return wanted, wanted
    share = 1.0 - math.exp(-dt / axis.spool_lag)
    law = axis.valve
    way = law.forward if wanted > 0.0 else law.backward
    before_edge = math.copysign(1.0, wanted) * spool < way.deadband_voltage
    applied = wanted
    if wanted != 0.0 and before_edge:
        ask = spool + (wanted - spool) / share
        applied = max(-way.rated_voltage, min(way.rated_voltage, ask))
    return applied, spool + share * (applied - spool)


def plausible(pressures: Pressures, p: Parameters) -> bool:
    """Tell whether transducers can be believed: a dead one must not open a valve wide."""
    low, high = LOWEST_SUPPLY * p.idle_pressure, HIGHEST * p.supply_pressure
    ports = (*pressures.port_1, *pressures.port_2)
    return low <= pressures.supply <= high and all(-LOWEST_PORT <= port <= high for port in ports)


def _filter_loads(state: State, pressures: Pressures | None, p: Parameters, dt: float) -> State:
    if pressures is None:
        return REST._replace(spools=state.spools)
    measured = tuple(
        a.displacement_1 * p_1 - a.displacement_2 * p_2
        for a, p_1, p_2 in zip(p.axes, pressures.port_1, pressures.port_2, strict=True)
    )
    weight = 1.0 - math.exp(-p.load_bandwidth * dt) if state.primed else 1.0
    loads = tuple(old + weight * (new - old) for old, new in zip(state.loads, measured, strict=True))
    fast = 1.0 - math.exp(-FILLING * dt) if state.primed else 1.0
    means = tuple(
        old + fast * (0.5 * (p_1 + p_2) - old)
        for old, p_1, p_2 in zip(state.means, pressures.port_1, pressures.port_2, strict=True)
    )
    return State((loads[0], loads[1], loads[2]), True, (means[0], means[1], means[2]), state.spools)


def _axis_voltage(
    command: float, load: float, mean: float | None, supply: float, axis: AxisDriver, p: Parameters
) -> float:
    """Return the voltage [V] that one valve's spool shall stand at; mean [Pa]: see `_while_filling`."""
    rated = axis.valve.forward.rated_voltage
    if not p.compensate:
        return max(-rated, min(rated, command))
    # A leaking motor under load must be fed to stand still: that counts as a command, but none is none.
    fed = command + rated * axis.slip * load / axis.rated_speed
    if command == 0.0 or abs(fed) <= p.hold_zone:
        return 0.0
    speed = axis.rated_speed * fed / rated
    opening = required_opening(speed, load, supply, axis, p)
    if mean is not None:
        opening *= _while_filling(math.copysign(1.0, speed) * load, mean, supply, axis)
    return voltage_for_opening(opening, axis.valve)


def _while_filling(opposing: float, mean: float, supply: float, axis: AxisDriver) -> float:
    """Return how much further a motor's valve must open while its hoses are not at their usual pressure.

    The mean of inlet and outlet flow moves the load, and goes with sqrt(P_s - P_in) + sqrt(P_out). Both
    roots are equal when the ports' mean pressure is half the supply's; after a rest it is less.
    """
    half = 0.5 * opposing / axis.displacement_1
    usual = max(LEAST_PART * supply, 0.5 * supply - half)
    floor = LEAST_PART**2 * usual
    inlet, outlet = max(floor, supply - mean - half), max(floor, mean - half)
    return 2.0 * math.sqrt(usual) / (math.sqrt(inlet) + math.sqrt(outlet))


def required_opening(speed: float, load: float, supply: float, axis: AxisDriver, p: Parameters) -> float:
    """Return the opening -1..1 for an actuator speed [m/s; rad/s] against a load [N; N m].

    Thesis eq. 3.1, 3.14.
    """
    inlet = axis.displacement_1 if speed > 0.0 else axis.displacement_2
    nominal = inlet * supply
    opposing = load if speed > 0.0 else -load
    hoses = (axis.hose_linear + axis.hose_square * abs(speed)) * abs(speed)
    drive = max(p.minimum_drop * inlet * p.supply_pressure, nominal - opposing - hoses)
    way = axis.valve.forward if speed > 0.0 else axis.valve.backward
    orifices = way.resistance_1 * axis.displacement_1**3 + way.resistance_2 * axis.displacement_2**3
    return max(-1.0, min(1.0, speed * math.sqrt(orifices / drive)))


def parameters(machine: Machine, settings: Settings) -> Parameters:
    """Return the core's parameters for a machine."""
    return Parameters(
        axes=axis_drivers(machine, settings.beyond_valve),
        supply_pressure=machine.pump.supply_pressure,
        idle_pressure=machine.pump.idle_pressure,
        compensate=settings.compensate,
        beyond_valve=settings.compensate and settings.beyond_valve,
        hold_zone=settings.hold_zone,
        load_bandwidth=2.0 * math.pi * settings.load_bandwidth,
        minimum_drop=settings.minimum_drop,
    )


def axis_drivers(machine: Machine, beyond_valve: bool = True) -> tuple[AxisDriver, AxisDriver, AxisDriver]:
    """Return what a driver knows of a machine's actuators, of the valve alone or of what lies beyond, too."""
    axes = []
    for axis, speed in enumerate(rated_speeds(machine)):
        driver = AxisDriver(*displacements(machine, axis), speed, machine.valve_of(axis).law)
        if beyond_valve:
            linear, square = _hoses(machine, axis)
            driver = driver._replace(
                hose_linear=linear,
                hose_square=square,
                slip=_slip(machine, axis),
                spool_lag=_spool_lag(machine, axis),
            )
        axes.append(driver)
    return axes[0], axes[1], axes[2]


def _spool_lag(machine: Machine, axis: int) -> float:
    bandwidth = machine.valve_of(axis).spool_bandwidth
    return 0.0 if bandwidth is None else 1.0 / (2.0 * math.pi * bandwidth)


def _hoses(machine: Machine, axis: int) -> tuple[float, float]:
    """Return what both hoses take at unit speed, linear and square part. Thesis section 4.3.3."""
    parts = [
        (displacement, machine.line(axis, port).resistance)
        for port, displacement in zip((1, 2), displacements(machine, axis), strict=True)
    ]
    if machine.drives[axis].flow_regime == "laminar":
        return sum(d**2 * resistance for d, resistance in parts), 0.0
    return 0.0, sum(d**3 * resistance for d, resistance in parts)


def _slip(machine: Machine, axis: int) -> float:
    """Return how much slower a load makes an actuator by its leakage [rad/s per N m]; cylinders are tight.

    Half of what leaves port 1 for the case is missing at the mean of both ports. Thesis eq. 4.8.
    """
    if axis != 0:
        return 0.0
    swing, oil = machine.swing, displacements(machine, 0)[0]
    leakage = 1.0 / swing.internal_leakage_resistance + 0.5 / swing.external_leakage_resistance
    return leakage / oil**2
