"""Residuals: what the machine does beside what its file says, from sums over bins of `BIN`.

Positions and pressures count as their means over a bin, flows as the means of two bins, so that their
differences belong to the same time. x is the swing's angle or a cylinder's length, p an actuator's pressure,
A and C area and capacitance of a port, V the voltage behind the spool's lag.

| residual | of | formula | unit |
|---|---|---|---|
| lost_1, lost_2 | oil that comes, valve shut | (A_1 dx + C_1 dp_1)/dt, (C_2 dp_2 - A_2 dx)/dt | cm^3/s |
| follow | motion | sum of abs(dx + C dp/A - dx by the valve's law) over sum of abs dx | 1 |
| spool | a voltage that moves | mean of abs(V - spool) over mean of abs dV/dt | ms |
| stiff_1, stiff_2 | rocking, valve shut | ln(C found/C of the file), C from A dx against dp | 1 |
| deadband, gain | what the driver has learnt | less the file's; less 1 | V, 1 |
| supply | supply | p_s less what the pump's law gives at the axes' flow | MPa |
| drain | the swing's case drain | less the file's leakage | L/min |
| meter | a flow meter | ln of its volume over A dx and leakage | 1 |
| agree | boom, stick | cylinder's length less that of its joint's angle | mm |
| pair | a port at rest | valve's less actuator's transducer | MPa |
| cold | oil | `WARM` less its temperature | K |

A motor's leakage by the file is taken out of what is lost. A residual without its sensors is NaN.
"""

import math
from typing import NamedTuple

from forest_description.components.valve_characteristic import Direction, opening_at, stroke
from forest_description.geometry.linkage import cylinder_length
from forest_description.types import AXES, Vec3
from forest_ident.diagnosis.machine_numbers import AxisNumbers, Parameters, Port
from forest_ident.diagnosis.readings import NAN, PORTS, Learnt, Readings, Way
from forest_sim.hydraulics.oil_volume import content
from forest_sim.hydraulics.supply import Supply

BIN = 0.1  # [s]
SETTLED = 10.0  # bins of a shut valve, before oil that is lost counts
SPAN = 10.0  # bins of residuals of standing oil, supply and meters
COURSE = 20.0  # bins of `follow`
SHUT = 0.6  # [1] of a deadband, under which a valve is surely shut
MOVES = 0.02  # [1] of full speed, as a mean over `COURSE`
STIRRED = 2.0  # [V] of way of the voltage within `SPAN`
ROCKED = 4e-6  # [m^3] root of the sum of squares of what filled a port, from which its stiffness is told
FILLED = 3e5  # [Pa] under which free air makes a port's capacitance uncertain
FLOWED = 0.04  # [1] of full flow, from which a meter is judged
SURE_DEADBAND, SURE_GAIN = 0.03, 0.05  # [V], [1] spread of what the driver has learnt
WARM = 288.0  # [K] 15 degrees Celsius: oil is colder only before it has warmed
NEAR_LIMIT = 0.8  # [1] of the pump's flow, beyond which its pressure tells nothing
SUPPLY_LOW = 1e6  # [Pa] under which no pump runs

OF_AXIS = (
    *("lost_1", "lost_2", "follow", "spool", "stiff_1", "stiff_2"),
    *("deadband_forward", "gain_forward", "deadband_backward", "gain_backward"),
)
OF_MACHINE = (
    *("supply", "drain", "swing_meter", "stick_meter", "boom_agree", "stick_agree"),
    *(f"{port}_pair" for port in PORTS),
    "cold",
)
NAMES = (*(f"{axis}_{name}" for axis in AXES for name in OF_AXIS), *OF_MACHINE)
COUNT = len(NAMES)
NONE = (NAN,) * COUNT
UNKNOWN = (NAN,) * len(OF_MACHINE)


class Sums(NamedTuple):
    """One axis within a bin."""

    position: float = 0.0
    valve_1: float = 0.0
    at_1: float = 0.0
    valve_2: float = 0.0
    at_2: float = 0.0
    inflow_1: float = 0.0  # [m^3/s] through the valve's law
    inflow_2: float = 0.0
    shut: float = 0.0  # samples
    error: float = 0.0  # [V]
    stir: float = 0.0  # [V]


class Course(NamedTuple):
    """One axis over some bins."""

    lost_1: float = 0.0  # [m^3]
    lost_2: float = 0.0
    standing: float = 0.0  # bins
    rock_1: float = 0.0  # [m^6]
    square_1: float = 0.0
    rock_2: float = 0.0
    square_2: float = 0.0
    off: float = 0.0  # [m; rad]
    gone: float = 0.0
    moving: float = 0.0  # bins
    error: float = 0.0  # [V]
    stir: float = 0.0
    stirred: float = 0.0  # bins


class Axis(NamedTuple):
    """What is remembered of an axis."""

    voltage: float = 0.0  # [V] behind the lag
    sums: Sums = Sums()
    last: Sums = Sums()  # means of the bin before
    course: Course = Course()
    quiet: float = 0.0  # bins for which the valve has been shut
    dx: float = 0.0  # of the last bin


class Machine(NamedTuple):
    """What is remembered of the supply and the meters."""

    time: float = 0.0  # [s] in the bin
    samples: float = 0.0
    primed: int = 0
    supply: float = 0.0  # sums within the bin
    drain: float = 0.0
    flow_1: float = 0.0
    flow_2: float = 0.0
    length_1: float = 0.0
    length_2: float = 0.0
    over_supply: float = 0.0  # sums over `SPAN`
    over_drain: float = 0.0
    over_meter_1: float = 0.0
    over_moved_1: float = 0.0
    over_meter_2: float = 0.0
    over_moved_2: float = 0.0
    over_agree_1: float = 0.0
    over_agree_2: float = 0.0
    bins: float = 0.0


class Residuals(NamedTuple):
    """What is remembered, and the last bin's residuals."""

    axes: tuple[Axis, Axis, Axis] = (Axis(), Axis(), Axis())
    machine: Machine = Machine()
    values: tuple[float, ...] = NONE
    stands: int = 0  # 1: all valves were shut for all of the last bin
    ended: int = 0  # 1: a bin has ended with this sample


def updated(before: Residuals, r: Readings, p: Parameters, dt: float) -> Residuals:
    """Return the residuals after a sample, dt [s] after the last one."""
    axes = (
        _sampled(before.axes[0], 0, r, p, dt),
        _sampled(before.axes[1], 1, r, p, dt),
        _sampled(before.axes[2], 2, r, p, dt),
    )
    m = before.machine
    m = m._replace(
        time=m.time + dt,
        samples=m.samples + 1.0,
        supply=m.supply + r.supply,
        drain=m.drain + r.case_drain,
        flow_1=m.flow_1 + r.flows[0],
        flow_2=m.flow_2 + r.flows[1],
        length_1=m.length_1 + r.lengths[0],
        length_2=m.length_2 + r.lengths[1],
    )
    if m.time < BIN - 0.5 * dt:
        return before._replace(axes=axes, machine=m, values=NONE, ended=0)
    return _bin(axes, m, r, p)


def _sampled(a: Axis, i: int, r: Readings, p: Parameters, dt: float) -> Axis:
    """Return an axis with a sample in its bin."""
    k, known = p.axes[i], r.valves[i]
    follows = 1.0 - math.exp(-dt / k.lag) if k.lag > 0.0 else 1.0
    voltage = a.voltage + follows * (r.voltages[i] - a.voltage)
    at = 4 * i
    valve_1, at_1, valve_2, at_2 = (
        r.pressures[at],
        r.pressures[at + 1],
        r.pressures[at + 2],
        r.pressures[at + 3],
    )
    forward, backward = _edge(k.law.forward, known.forward), _edge(k.law.backward, known.backward)
    is_shut = -SHUT * backward.deadband < voltage < SHUT * forward.deadband
    s = a.sums
    sums = Sums(
        position=s.position + _position(i, r, k),
        valve_1=s.valve_1 + valve_1,
        at_1=s.at_1 + at_1,
        valve_2=s.valve_2 + valve_2,
        at_2=s.at_2 + at_2,
        inflow_1=s.inflow_1
        + _inflow(voltage, forward, k.law.forward, k, k.law.forward.resistance_1, r.supply - valve_1),
        inflow_2=s.inflow_2
        + _inflow(-voltage, backward, k.law.backward, k, k.law.backward.resistance_2, r.supply - valve_2),
        shut=s.shut + (1.0 if is_shut else 0.0),
        error=s.error + abs(voltage - r.spools[i]),
        stir=s.stir + abs(voltage - a.voltage),
    )
    return a._replace(voltage=voltage, sums=sums)


def _position(i: int, r: Readings, k: AxisNumbers) -> float:
    return r.angles[0] if i == 0 else cylinder_length(r.angles[i], k.linkage)


def _edge(file: Direction, known: Way) -> Way:
    """Return deadband and gain as learnt, or the file's."""
    if math.isnan(known.deadband) or math.isnan(known.gain):
        return Way(file.deadband_voltage, 1.0)
    return known


def _inflow(
    voltage: float, way: Way, file: Direction, k: AxisNumbers, resistance: float, drop: float
) -> float:
    """Return the flow [m^3/s] through the supply's edge of a port; NaN without pressures."""
    if voltage <= way.deadband:
        return 0.0 * drop
    as_filed = file.deadband_voltage + way.gain * (voltage - way.deadband)
    opening = opening_at(stroke(as_filed, file), k.law.curve)
    return opening * math.sqrt(max(0.0, drop) / resistance) if drop == drop else NAN


def _bin(axes: tuple[Axis, Axis, Axis], m: Machine, r: Readings, p: Parameters) -> Residuals:
    """Return the residuals at a bin's end."""
    n, dt, first = m.samples, m.time, m.primed == 0
    means = _mean(axes[0].sums, n), _mean(axes[1].sums, n), _mean(axes[2].sums, n)
    swing, values_1 = _axis(axes[0], means[0], p.axes[0], r.valves[0], dt, n, first)
    boom, values_2 = _axis(axes[1], means[1], p.axes[1], r.valves[1], dt, n, first)
    stick, values_3 = _axis(axes[2], means[2], p.axes[2], r.valves[2], dt, n, first)
    after = swing, boom, stick
    m, values = _machine(m, after, means, r, p, dt, first)
    stands = swing.quiet > 0.0 and boom.quiet > 0.0 and stick.quiet > 0.0
    return Residuals(after, m, (*values_1, *values_2, *values_3, *values), int(stands), 1)


def _mean(s: Sums, n: float) -> Sums:
    """Return a bin's means; samples and ways of the voltage stay sums."""
    return Sums(
        position=s.position / n,
        valve_1=s.valve_1 / n,
        at_1=s.at_1 / n,
        valve_2=s.valve_2 / n,
        at_2=s.at_2 / n,
        inflow_1=s.inflow_1 / n,
        inflow_2=s.inflow_2 / n,
        shut=s.shut,
        error=s.error / n,
        stir=s.stir,
    )


AxisValues = tuple[float, ...]


def _axis(
    a: Axis, mean: Sums, k: AxisNumbers, known: Learnt, dt: float, n: float, first: bool
) -> tuple[Axis, AxisValues]:
    """Return an axis at a bin's end, and its residuals in the order of `OF_AXIS`."""
    quiet = a.quiet + 1.0 if mean.shut == n else 0.0
    dx = 0.0 if first else mean.position - a.last.position
    c_1 = _capacitance(0.5 * (mean.at_1 + a.last.at_1), mean.position, k.one)
    c_2 = _capacitance(0.5 * (mean.at_2 + a.last.at_2), mean.position, k.two)
    filled_1, filled_2 = c_1 * (mean.at_1 - a.last.at_1), c_2 * (mean.at_2 - a.last.at_2)
    c = a.course if not first else Course()
    leaks = dt * k.internal_leakage * (mean.at_1 - mean.at_2)
    leaks_1, leaks_2 = (
        leaks + dt * k.external_leakage * mean.at_1,
        dt * k.external_leakage * mean.at_2 - leaks,
    )
    lost = k.one.area * dx + filled_1 + leaks_1, filled_2 - k.two.area * dx + leaks_2
    c, lost_1, lost_2 = _lost(c, lost, quiet, dt)
    rock_1, square_1, stiff_1 = _stiffness(c.rock_1, c.square_1, k.one.area * dx + leaks_1, -filled_1, quiet)
    rock_2, square_2, stiff_2 = _stiffness(c.rock_2, c.square_2, k.two.area * dx - leaks_2, filled_2, quiet)
    c = c._replace(rock_1=rock_1, square_1=square_1, rock_2=rock_2, square_2=square_2)
    predicted_1, predicted_2 = (
        dt * 0.5 * (mean.inflow_1 + a.last.inflow_1),
        dt * 0.5 * (mean.inflow_2 + a.last.inflow_2),
    )
    predicted = predicted_1 / k.one.area - predicted_2 / k.two.area
    took = filled_1 / k.one.area if predicted > 0.0 else -filled_2 / k.two.area
    took = took if predicted != 0.0 else 0.0
    c, follow = _follows(c, dx, dx + took - predicted, full_speed(k), dt)
    c, spool = _spool(c, mean, dt)
    due = c.stirred == 0.0  # once in `SPAN`
    forward, backward = _valve(k.law.forward, known.forward, due), _valve(k.law.backward, known.backward, due)
    values = (lost_1, lost_2, follow, spool, stiff_1, stiff_2, *forward, *backward)
    return Axis(a.voltage, Sums(), mean, c, quiet, dx), values


def full_speed(k: AxisNumbers) -> float:
    """Return a speed near an axis's greatest [m/s; rad/s]: half of 20 MPa over each edge."""
    return math.sqrt(1e7 / k.law.forward.resistance_1) / k.one.area


def _capacitance(pressure: float, position: float, port: Port) -> float:
    """Return C [m^3/Pa]; NaN where free air makes it uncertain."""
    if port.oil.yields == 0:
        return port.wall
    return content(pressure, position, port.oil).capacitance if pressure > FILLED else NAN


def _lost(c: Course, came: tuple[float, float], quiet: float, dt: float) -> tuple[Course, float, float]:
    """Return the oil [cm^3/s] that comes to both ports through a shut valve, once in `SPAN`."""
    if quiet <= SETTLED:
        return c._replace(lost_1=0.0, lost_2=0.0, standing=0.0), NAN, NAN
    lost_1, lost_2, bins = c.lost_1 + came[0], c.lost_2 + came[1], c.standing + 1.0
    if bins < SPAN:
        return c._replace(lost_1=lost_1, lost_2=lost_2, standing=bins), NAN, NAN
    scale = 1e6 / (SPAN * dt)
    return c._replace(lost_1=0.0, lost_2=0.0, standing=0.0), scale * lost_1, scale * lost_2


def _stiffness(rock: float, square: float, volume: float, filled: float, quiet: float) -> Vec3:
    """Return the sums of a port, and ln(C found/C of the file) once a standing axis has rocked enough.

    Args:
        rock: sum of volume times filled [m^6].
        square: of filled squared [m^6].
        volume: that the actuator has pressed out of the port [m^3].
        filled: that the file's C takes for the rise of pressure [m^3].
        quiet: bins since the valve was shut.
    """
    if quiet <= 1.0 or math.isnan(volume * filled):
        return rock, square, NAN
    rock, square = rock + volume * filled, square + filled * filled
    if square < ROCKED * ROCKED:
        return rock, square, NAN
    return 0.0, 0.0, math.log(max(0.05, rock / square))


def _follows(c: Course, dx: float, off: float, fastest: float, dt: float) -> tuple[Course, float]:
    """Return how far the motion is from the predicted one, once in `COURSE`."""
    if math.isnan(off):
        return c._replace(off=0.0, gone=0.0, moving=0.0), NAN
    sum_off, gone, bins = c.off + abs(off), c.gone + max(abs(dx), abs(dx - off)), c.moving + 1.0
    if bins < COURSE:
        return c._replace(off=sum_off, gone=gone, moving=bins), NAN
    moved = gone > MOVES * fastest * COURSE * dt
    return c._replace(off=0.0, gone=0.0, moving=0.0), sum_off / gone if moved else NAN


def _spool(c: Course, mean: Sums, dt: float) -> tuple[Course, float]:
    """Return how long a spool is behind its voltage [ms], once in `SPAN`."""
    error, stir, bins = c.error + mean.error, c.stir + mean.stir, c.stirred + 1.0
    if bins < SPAN:
        return c._replace(error=error, stir=stir, stirred=bins), NAN
    return c._replace(error=0.0, stir=0.0, stirred=0.0), 1e3 * dt * error / stir if stir > STIRRED else NAN


def _valve(file: Direction, known: Way, due: bool) -> tuple[float, float]:
    """Return what a driver that is sure of itself has learnt."""
    sure = due and known.deadband_spread < SURE_DEADBAND and known.gain_spread < SURE_GAIN
    return (known.deadband - file.deadband_voltage, known.gain - 1.0) if sure else (NAN, NAN)


MachineValues = tuple[float, ...]


def _machine(
    m: Machine,
    axes: tuple[Axis, Axis, Axis],
    means: tuple[Sums, Sums, Sums],
    r: Readings,
    p: Parameters,
    dt: float,
    first: bool,
) -> tuple[Machine, MachineValues]:
    """Return the machine at a bin's end, and its residuals in the order of `OF_MACHINE`."""
    n, k = m.samples, p.axes
    demand = _demand(axes[0], k[0], dt) + _demand(axes[1], k[1], dt) + _demand(axes[2], k[2], dt)
    swing, stick = means[0], means[2]
    leaks = k[0].external_leakage * (swing.at_1 + swing.at_2)
    through = k[0].internal_leakage * (swing.at_1 - swing.at_2) + k[0].external_leakage * swing.at_1
    moved_1, moved_2 = k[0].one.area * axes[0].dx / dt, k[2].one.area * axes[2].dx / dt
    supply = m.over_supply + m.supply / n - _supply_pressure(demand, m.supply / n, p.supply)
    meter_1, meter_2 = m.over_meter_1 + m.flow_1 / n, m.over_meter_2 + m.flow_2 / n
    taken_1, taken_2 = m.over_moved_1 + moved_1 + through, m.over_moved_2 + moved_2
    agree_1 = m.over_agree_1 + m.length_1 / n - means[1].position
    agree_2 = m.over_agree_2 + m.length_2 / n - means[2].position
    drain, bins = m.over_drain + m.drain / n - leaks, m.bins + 1.0
    start = Machine(primed=1)
    pairs = (
        *_pairs(swing, axes[0].quiet, k[0]),
        *_pairs(means[1], axes[1].quiet, k[1]),
        *_pairs(stick, axes[2].quiet, k[2]),
    )
    if first:
        return start, UNKNOWN
    if bins < SPAN:
        kept = start._replace(
            over_supply=supply,
            over_drain=drain,
            over_meter_1=meter_1,
            over_moved_1=taken_1,
            over_meter_2=meter_2,
            over_moved_2=taken_2,
            over_agree_1=agree_1,
            over_agree_2=agree_2,
            bins=bins,
        )
        return kept, (NAN, NAN, NAN, NAN, NAN, NAN, *pairs, NAN)
    values = (
        *(
            1e-6 * supply / SPAN,
            6e4 * drain / SPAN,
            _metered(meter_1, taken_1, k[0]),
            _metered(meter_2, taken_2, k[2]),
        ),
        *(1e3 * agree_1 / SPAN, 1e3 * agree_2 / SPAN),
    )
    return start, (*values, *pairs, 0.0 if r.temperature > WARM else WARM - r.temperature)


def _demand(a: Axis, k: AxisNumbers, dt: float) -> float:
    """Return the flow [m^3/s] that an axis takes from the supply."""
    forward = a.voltage > k.law.forward.deadband_voltage and a.dx > 0.0
    backward = -a.voltage > k.law.backward.deadband_voltage and a.dx < 0.0
    return (k.one.area * a.dx if forward else -k.two.area * a.dx if backward else 0.0) / dt


def _supply_pressure(demand: float, pressure: float, s: Supply) -> float:
    """Return the pressure [Pa] of a compensated pump at a flow; NaN of another pump, or near its limit."""
    if s.ideal != 0 or s.rate > 0.0 or s.compensation == 0.0 or pressure < SUPPLY_LOW:
        return NAN
    flow = demand + s.leakage * pressure
    return s.set_pressure - flow / s.compensation if flow < NEAR_LIMIT * s.flow_limit else NAN


def _metered(flow: float, taken: float, k: AxisNumbers) -> float:
    """Return ln of what a meter has read over what an actuator has taken; NaN of little flow."""
    least = SPAN * FLOWED * full_speed(k) * k.one.area
    if math.isnan(flow * taken) or abs(flow) < least or flow * taken <= 0.0:
        return NAN
    return max(-1.0, min(1.0, math.log(flow / taken)))


def _pairs(mean: Sums, quiet: float, k: AxisNumbers) -> tuple[float, float]:
    """Return valve's less actuator's pressures [MPa] of a standing axis, once a second."""
    rests = quiet > SETTLED and quiet % SPAN == 0.0
    one = 1e-6 * (mean.valve_1 - mean.at_1) if rests and k.one.is_open == 1 else NAN
    two = 1e-6 * (mean.valve_2 - mean.at_2) if rests and k.two.is_open == 1 else NAN
    return one, two
