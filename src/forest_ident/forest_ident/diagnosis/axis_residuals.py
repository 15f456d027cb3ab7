"""An axis' residuals: its motion, its oil and its valve, from sums over bins of 0.1 s.

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

A motor's leakage is the file's at the temperature of the tank's oil, where there is a thermometer: hot oil
leaks four times as much. A residual without its sensors is NaN.
"""

import math
from typing import NamedTuple

from forest_description.geometry.linkage import cylinder_length
from forest_description.hydraulics.valve_characteristic import Direction, opening_at, stroke
from forest_ident.diagnosis.monitor_readings import NAN, Learnt, Readings, Way
from forest_ident.diagnosis.residual_parameters import AxisNumbers, Parameters, Port, full_speed
from forest_sim.hydraulics.oil_volume import content

SETTLED = 10.0  # bins of a shut valve, before oil that is lost counts
SPAN = 10.0  # bins of residuals of standing oil, supply and meters
COURSE = 20.0  # bins of `follow`
SHUT = 0.6  # [1] of a deadband, under which a valve is surely shut
MOVES = 0.02  # [1] of full speed, as a mean over `COURSE`
STIRRED = 2.0  # [V] of way of the voltage within `SPAN`
ROCKED = 4e-6  # [m^3] root of the sum of squares of what filled a port, from which its stiffness is told
COHERENT = 0.3  # [1] correlation of both, under which the pressure has other causes than the motion
FILLED = 3e5  # [Pa] under which free air makes a port's capacitance uncertain
HOT = 2.5  # [1] of a motor's leakage in its file: from there the driver, which knows no other, learns wrong
SURE_DEADBAND, SURE_GAIN = 0.03, 0.05  # [V], [1] spread of what the driver has learnt

OF_AXIS = (
    *("lost_1", "lost_2", "follow", "spool", "stiff_1", "stiff_2"),
    *("deadband_forward", "gain_forward", "deadband_backward", "gain_backward"),
)
AxisValues = tuple[float, ...]  # in the order of `OF_AXIS`


class Sums(NamedTuple):
    """One axis within a bin."""

    position: float = 0.0  # [rad; m]
    valve_1: float = 0.0  # [Pa] at the valve's port, and at the actuator's
    at_1: float = 0.0
    valve_2: float = 0.0
    at_2: float = 0.0
    inflow_1: float = 0.0  # [m^3/s] through the valve's law
    inflow_2: float = 0.0
    shut: float = 0.0  # samples
    error: float = 0.0  # [V]
    stir: float = 0.0  # [V]


class Rock(NamedTuple):
    """One port of a standing axis that rocks: sums over bins [m^6]."""

    product: float = 0.0  # of what the actuator has pressed out, and what that should fill
    pressed: float = 0.0  # squares of the first
    filled: float = 0.0  # squares of the second


class Course(NamedTuple):
    """One axis over some bins."""

    lost_1: float = 0.0  # [m^3]
    lost_2: float = 0.0
    standing: float = 0.0  # bins
    rock_1: Rock = Rock()
    rock_2: Rock = Rock()
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
    filled: float = 0.0  # [m^3] of port 1, in the last bin; NaN where it is not known


def sampled(a: Axis, i: int, r: Readings, p: Parameters, dt: float) -> Axis:
    """Return axis i with a sample in its bin, dt [s] after the last one."""
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


def mean_of(s: Sums, n: float) -> Sums:
    """Return the means of a bin of n samples; samples and ways of the voltage stay sums."""
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


def ended(
    a: Axis, mean: Sums, k: AxisNumbers, known: Learnt, thin: float, dt: float, n: float, first: bool
) -> tuple[Axis, AxisValues]:
    """Return an axis at a bin's end, and its residuals in the order and units of `OF_AXIS`.

    Args:
        a: the axis, with the bin's samples.
        mean: means of the bin, by `mean_of`.
        k: the file's numbers.
        known: what the driver has learnt.
        thin: by `residual_parameters.thinned`.
        dt: length of the bin [s].
        n: samples of the bin.
        first: no bin came before.
    """
    quiet = a.quiet + 1.0 if mean.shut == n else 0.0
    dx = 0.0 if first else mean.position - a.last.position
    c_1 = _capacitance(0.5 * (mean.at_1 + a.last.at_1), mean.position, k.one)
    c_2 = _capacitance(0.5 * (mean.at_2 + a.last.at_2), mean.position, k.two)
    filled_1, filled_2 = c_1 * (mean.at_1 - a.last.at_1), c_2 * (mean.at_2 - a.last.at_2)
    c = a.course if not first else Course()
    between, outside = dt * thin * k.internal_leakage, dt * thin * k.external_leakage
    leaks_1 = between * (mean.at_1 - mean.at_2) + outside * mean.at_1
    leaks_2 = between * (mean.at_2 - mean.at_1) + outside * mean.at_2
    lost = k.one.area * dx + filled_1 + leaks_1, filled_2 - k.two.area * dx + leaks_2
    c, lost_1, lost_2 = _lost(c, lost, quiet, dt)
    rock_1, stiff_1 = _stiffness(c.rock_1, k.one.area * dx + leaks_1, -filled_1, quiet)
    rock_2, stiff_2 = _stiffness(c.rock_2, k.two.area * dx - leaks_2, filled_2, quiet)
    c = c._replace(rock_1=rock_1, rock_2=rock_2)
    predicted_1, predicted_2 = (
        dt * 0.5 * (mean.inflow_1 + a.last.inflow_1),
        dt * 0.5 * (mean.inflow_2 + a.last.inflow_2),
    )
    predicted = predicted_1 / k.one.area - predicted_2 / k.two.area
    took = filled_1 / k.one.area if predicted > 0.0 else -filled_2 / k.two.area
    took = took if predicted != 0.0 else 0.0
    learns = k.internal_leakage == 0.0 or thin < HOT
    c, follow = _follows(c, dx, dx + took - predicted if learns else NAN, full_speed(k), dt)
    c, spool = _spool(c, mean, dt)
    due = c.stirred == 0.0 and learns  # once in `SPAN`
    one, two = _valve(k.law.forward, known.forward, due), _valve(k.law.backward, known.backward, due)
    values = (lost_1, lost_2, follow, spool, stiff_1, stiff_2, *one, *two)
    return Axis(a.voltage, Sums(), mean, c, quiet, dx, filled_1), values


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


def _stiffness(rock: Rock, volume: float, filled: float, quiet: float) -> tuple[Rock, float]:
    """Return the sums of a port, and ln(C found/C of the file) once a standing axis has rocked enough.

    Where pressure moves without the actuator, as in one that its friction holds, nothing is told.

    Args:
        rock: the sums before.
        volume: that the actuator has pressed out of the port [m^3].
        filled: that the file's C takes for the rise of pressure [m^3].
        quiet: bins since the valve was shut.
    """
    if quiet <= 1.0 or math.isnan(volume * filled):
        return rock, NAN
    product, pressed = rock.product + volume * filled, rock.pressed + volume * volume
    square = rock.filled + filled * filled
    if square < ROCKED * ROCKED:
        return Rock(product, pressed, square), NAN
    told = product > COHERENT * math.sqrt(pressed * square)
    return Rock(), math.log(product / square) if told else NAN


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
