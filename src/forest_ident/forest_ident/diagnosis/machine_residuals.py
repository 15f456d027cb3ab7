"""The machine's residuals: supply, meters and pairs of sensors, from sums over bins.

| residual | of | formula | unit |
|---|---|---|---|
| supply | supply | p_s less what the pump's law gives at the axes' flow and its leakage | MPa |
| drain | the swing's case drain | less the file's leakage at the tank's temperature | L/min |
| meter | a flow meter | ln of its volume over A dx + C dp and leakage | 1 |
| agree | boom, stick | cylinder's length less that of its joint's angle | mm |
| pair | a port at rest | valve's less actuator's transducer | MPa |
| cold | oil | `WARM` less its temperature | K |

A residual without its sensors is NaN.
"""

import math
from typing import NamedTuple

from forest_ident.diagnosis.axis_residuals import SETTLED, SPAN, Axis, Sums
from forest_ident.diagnosis.monitor_readings import NAN, PORTS, Readings
from forest_ident.diagnosis.residual_parameters import AxisNumbers, Parameters, full_speed
from forest_sim.hydraulics.supply import Supply

FLOWED = 0.04  # [1] of full flow, from which a meter is judged
WARM = 288.0  # [K] 15 degrees Celsius: oil is colder only before it has warmed
NEAR_LIMIT = 0.8  # [1] of the pump's flow, beyond which its pressure tells nothing
SUPPLY_LOW = 1e6  # [Pa] under which no pump runs

OF_MACHINE = (
    *("supply", "drain", "swing_meter", "stick_meter", "boom_agree", "stick_agree"),
    *(f"{port}_pair" for port in PORTS),
    "cold",
)
UNKNOWN = (NAN,) * len(OF_MACHINE)
MachineValues = tuple[float, ...]  # in the order of `OF_MACHINE`


class Machine(NamedTuple):
    """What is remembered of the supply and the meters."""

    time: float = 0.0  # [s] in the bin
    samples: float = 0.0
    primed: int = 0
    supply: float = 0.0  # [Pa], as a sum within the bin, like the next ones
    drain: float = 0.0  # [m^3/s]
    flow_1: float = 0.0  # [m^3/s]
    flow_2: float = 0.0
    length_1: float = 0.0  # [m]
    length_2: float = 0.0
    last_1: float = 0.0  # [m^3/s] the meters' means of the bin before
    last_2: float = 0.0
    over_supply: float = 0.0  # sums over `SPAN`
    over_drain: float = 0.0
    over_meter_1: float = 0.0
    over_moved_1: float = 0.0
    over_meter_2: float = 0.0
    over_moved_2: float = 0.0
    over_agree_1: float = 0.0
    over_agree_2: float = 0.0
    bins: float = 0.0


def sampled(m: Machine, r: Readings, dt: float) -> Machine:
    """Return the machine with a sample in its bin, dt [s] after the last one."""
    return m._replace(
        time=m.time + dt,
        samples=m.samples + 1.0,
        supply=m.supply + r.supply,
        drain=m.drain + r.case_drain,
        flow_1=m.flow_1 + r.flows[0],
        flow_2=m.flow_2 + r.flows[1],
        length_1=m.length_1 + r.lengths[0],
        length_2=m.length_2 + r.lengths[1],
    )


def ended(
    m: Machine,
    axes: tuple[Axis, Axis, Axis],
    means: tuple[Sums, Sums, Sums],
    temperature: float,
    thin: float,
    p: Parameters,
    dt: float,
    first: bool,
) -> tuple[Machine, MachineValues]:
    """Return the machine at a bin's end, and its residuals in the order and units of `OF_MACHINE`.

    Args:
        m: the machine, with the bin's samples.
        axes: the axes at the bin's end.
        means: of the axes in the bin.
        temperature: of the oil in the tank [K].
        thin: by `residual_parameters.thinned`.
        p: the file's numbers.
        dt: length of the bin [s].
        first: no bin came before.
    """
    k = p.axes
    pairs = (
        *_pairs(means[0], axes[0].quiet, k[0]),
        *_pairs(means[1], axes[1].quiet, k[1]),
        *_pairs(means[2], axes[2].quiet, k[2]),
    )
    if first:
        return Machine(primed=1, last_1=m.flow_1 / m.samples, last_2=m.flow_2 / m.samples), UNKNOWN
    sums = _summed(m, axes, means, thin, p, dt)
    if sums.bins < SPAN:
        return sums, (NAN, NAN, NAN, NAN, NAN, NAN, *pairs, NAN)
    values = (
        *(
            1e-6 * sums.over_supply / SPAN,
            6e4 * sums.over_drain / SPAN,
            _metered(sums.over_meter_1, sums.over_moved_1, k[0]),
            _metered(sums.over_meter_2, sums.over_moved_2, k[2]),
        ),
        *(1e3 * sums.over_agree_1 / SPAN, 1e3 * sums.over_agree_2 / SPAN),
    )
    cold = 0.0 if temperature > WARM else WARM - temperature
    begun = Machine(primed=1, last_1=sums.last_1, last_2=sums.last_2)
    return begun, (*values, *pairs, cold)


def _summed(
    m: Machine,
    axes: tuple[Axis, Axis, Axis],
    means: tuple[Sums, Sums, Sums],
    thin: float,
    p: Parameters,
    dt: float,
) -> Machine:
    """Return the next bin's machine, whose sums over `SPAN` have this one."""
    n, k = m.samples, p.axes
    swing = means[0]
    demand = _demand(axes[0], k[0], dt) + _demand(axes[1], k[1], dt) + _demand(axes[2], k[2], dt)
    between, outside = thin * k[0].internal_leakage, thin * k[0].external_leakage
    leaks = outside * (swing.at_1 + swing.at_2)
    through = between * (swing.at_1 - swing.at_2) + outside * swing.at_1
    flow_1, flow_2 = m.flow_1 / n, m.flow_2 / n
    return Machine(
        primed=1,
        over_supply=m.over_supply + m.supply / n - _supply_pressure(demand, m.supply / n, thin, p.supply),
        over_drain=m.over_drain + m.drain / n - leaks,
        last_1=flow_1,
        last_2=flow_2,
        over_meter_1=m.over_meter_1 + 0.5 * (flow_1 + m.last_1),
        over_moved_1=m.over_moved_1 + _taken(axes[0], k[0], dt) + through,
        over_meter_2=m.over_meter_2 + 0.5 * (flow_2 + m.last_2),
        over_moved_2=m.over_moved_2 + _taken(axes[2], k[2], dt),
        over_agree_1=m.over_agree_1 + m.length_1 / n - means[1].position,
        over_agree_2=m.over_agree_2 + m.length_2 / n - means[2].position,
        bins=m.bins + 1.0,
    )


def _taken(a: Axis, k: AxisNumbers, dt: float) -> float:
    """Return the flow [m^3/s] that moves an axis and fills its port 1; without pressures the first alone."""
    filled = a.filled if a.filled == a.filled else 0.0
    return (k.one.area * a.dx + filled) / dt


def _demand(a: Axis, k: AxisNumbers, dt: float) -> float:
    """Return the flow [m^3/s] that an axis takes from the supply."""
    forward = a.voltage > k.law.forward.deadband_voltage and a.dx > 0.0
    backward = -a.voltage > k.law.backward.deadband_voltage and a.dx < 0.0
    return (k.one.area * a.dx if forward else -k.two.area * a.dx if backward else 0.0) / dt


def _supply_pressure(demand: float, pressure: float, thin: float, s: Supply) -> float:
    """Return the pressure [Pa] of a compensated pump at a flow; NaN of another pump, or near its limit."""
    if s.ideal != 0 or s.rate > 0.0 or s.compensation == 0.0 or pressure < SUPPLY_LOW:
        return NAN
    flow = demand + thin * s.leakage * pressure
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
