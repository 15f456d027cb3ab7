"""Adaptation of a valve's deadband and gain to its measured motion, by recursive least squares.

The opening that lets a measured flow through at the measured pressure drop is known (`valve_flow`).
So is the voltage that the valve of the machine's file would need for it. The true valve needs, in
either direction,

    V = V_d + d + (1 + k) x

| symbol | name | unit |
|---|---|---|
| V | voltage at which the spool stands, counted along the direction | V |
| V_d | deadband of the machine's file | V |
| x | voltage beyond V_d for the measured flow, from the file's curve | V |
| d | how much wider the deadband is | V |
| k | how much further than that the spool must move: 1/(1 + k) is the gain | - |
| E, i | V - V_d of an open spool; 1 while it is open | V, - |

V is behind the valve's dead time, taken as a lag. All parts pass the same low-pass, so that transients
are no error: behind it E = i d + (1 + k) x.
The regressor holds x as expected from the voltage: the measured x is noisy, which would bias k
downwards.

A shut valve fits no line: no gain explains that nothing flows. Where no flow shows, the driver adds up
how far the actuator is behind its spool:

- While the deadband is unsure, d goes up to where the spool stands, once it is clear that nothing flows:
  beside what is expected, or behind by the gear's play. The servo takes the spool on.
- Behind by more than the position's noise, such an equation tells of d alone.
- Behind by the gear's play, too, d is unsure again, however sure it was.
"""

import math
from typing import NamedTuple

from forest_control.valve.spool_model import left
from forest_control.valve.valve_flow import (
    BANDWIDTH,
    NO_MEASUREMENT,
    AxisMeasurement,
    FlowParameters,
    LowPassed,
    correlated_samples,
    low_passed,
    opening_from_flow,
    opening_variance,
)
from forest_description.hydraulics.valve_characteristic import (
    LINEAR,
    Direction,
    ValveLaw,
    voltage_for_opening,
)

DEADBAND_SPREAD = 0.15  # [V] standard deviation of the file's deadband; chosen, not measured
STRETCH_SPREAD = 0.4  # [1] standard deviation of k: the file's gain is known to 40 %; chosen
LEAST_SHARE = 0.3  # [1] of the low-pass' memory in which the spool must have been open; chosen
PURITY = 0.95  # [1] of that, in this one direction and measurable: directions must not mix
MODEL_VOLTS = 0.005  # [V] standard deviation of the valve's law itself; chosen, not measured
MODEL_SHARE = 0.02  # [1] the same as a share of x; chosen, not measured
UNSURE = 0.25  # [1] of the deadband's first variance: above it, d is raised, as above; chosen
CLEAR = 4.0  # [1] standard deviations that a flow, or its absence, must show: one in 30 000 by chance
FINE = 0.35  # [1] of DEADBAND_SPREAD: a noisier flow cannot tell its absence; chosen
BEHIND = 5.0  # [1] of the position's noise, which two samples differ by once in 5000 by chance
LATE = 3.0  # [1] standard deviations of the lag by which a ramp's flow may be late: one in 700 by chance
LAG_SPREAD = 0.006  # [s] by which a spool may be slower or quicker than its file says; chosen


class AdaptationParameters(NamedTuple):
    """Settings of the adaptation, from those of the driver."""

    forgetting_time: float  # [s]
    deadband_range: float  # [V] that d is kept within
    gain_range: float  # the gain is kept within 1/this and this


class DirectionEstimate(NamedTuple):
    """The estimate of one direction; the covariance is relative to what it starts from."""

    deadband: float = 0.0  # d [V]
    stretch: float = 0.0  # k
    p_dd: float = 1.0
    p_dk: float = 0.0
    p_kk: float = 1.0
    behind: float = 0.0  # how far the actuator is behind the spool since no flow shows [m; rad]


class Equation(NamedTuple):
    """E = i d + (1 + k) x of one period, behind the low-pass; all counts along the direction."""

    share: float  # i
    excess: float  # E [V]
    flowing: float  # x by the measured flow [V]
    expected: float  # x by the voltage and what is learnt [V]
    noise: float  # standard deviation of `flowing` [V]
    late: float  # standard deviation of E while the spool ramps: its lag is not known exactly [V]


class ValveEstimate(NamedTuple):
    """State of one axis between periods."""

    forward: DirectionEstimate = DirectionEstimate()
    backward: DirectionEstimate = DirectionEstimate()
    low: LowPassed = LowPassed()
    last: AxisMeasurement = NO_MEASUREMENT
    late: float = 0.0  # spool behind the valve's dead time [V]
    primed: bool = False  # the last period was measured


NO_ESTIMATE = ValveEstimate()


def unmeasured(estimate: ValveEstimate) -> ValveEstimate:
    """Return the state after a period without measurements: what is learnt stays."""
    return ValveEstimate(forward=estimate.forward, backward=estimate.backward)


def updated_estimate(
    estimate: ValveEstimate,
    sample: AxisMeasurement,
    law: ValveLaw,
    flow: FlowParameters,
    a: AdaptationParameters,
    dt: float,
) -> ValveEstimate:
    """Return the state after a period of dt [s]; law: the valve as in the machine's file."""
    if not estimate.primed or underlapped(law):
        return unmeasured(estimate)._replace(last=sample, late=sample.spool, primed=True)
    late = sample.spool + left(flow.dead_time, dt) * (estimate.late - sample.spool)
    sample = sample._replace(spool=late)
    forward, backward = estimate.forward, estimate.backward
    edge, known = (law.forward, forward) if sample.spool > 0.0 else (law.backward, backward)
    flowing = opening_from_flow(estimate.last, sample, law, flow, dt)
    excess = abs(sample.spool) - edge.deadband_voltage
    low = low_passed(estimate.low, flowing, sample.spool, excess, known.deadband, dt)
    share = abs(low.mark_2)
    if share > LEAST_SHARE and share > PURITY * low.open_2:
        if low.mark_2 > 0.0:
            backward = backward._replace(behind=0.0)
            forward = _update(forward, low, law.forward, law, flow, a, dt)
        else:
            forward = forward._replace(behind=0.0)
            backward = _update(backward, low, law.backward, law, flow, a, dt)
    return ValveEstimate(forward=forward, backward=backward, low=low, last=sample, late=late, primed=True)


def underlapped(law: ValveLaw) -> bool:
    """Tell whether both directions are open at the centre: such a valve is not learnt."""
    return law.forward.deadband_voltage + law.backward.deadband_voltage < 0.0


def estimated_law(law: ValveLaw, estimate: ValveEstimate) -> ValveLaw:
    """Return the valve with the learnt deadbands and gains; its rated voltages may exceed the amplifier's."""
    return law._replace(
        forward=_learnt(law.forward, estimate.forward), backward=_learnt(law.backward, estimate.backward)
    )


def _learnt(edge: Direction, way: DirectionEstimate) -> Direction:
    deadband = edge.deadband_voltage + way.deadband
    span = (1.0 + way.stretch) * (edge.rated_voltage - edge.deadband_voltage)
    return edge._replace(deadband_voltage=deadband, rated_voltage=deadband + span)


def gain(way: DirectionEstimate) -> float:
    """Return how much faster than by its file a valve is beyond its deadband."""
    return 1.0 / (1.0 + way.stretch)


def deadband_spread(way: DirectionEstimate) -> float:
    """Return the standard deviation of the deadband [V]."""
    return DEADBAND_SPREAD * math.sqrt(way.p_dd)


def gain_spread(way: DirectionEstimate) -> float:
    """Return the standard deviation of the gain."""
    return STRETCH_SPREAD * math.sqrt(way.p_kk) * gain(way) ** 2


def _update(
    way: DirectionEstimate,
    low: LowPassed,
    edge: Direction,
    law: ValveLaw,
    flow: FlowParameters,
    a: AdaptationParameters,
    dt: float,
) -> DirectionEstimate:
    """Return the estimate after one more equation."""
    seen = _equation(way, low, edge, law, flow, dt)
    volts_per_speed = (edge.rated_voltage - edge.deadband_voltage) * low.gradient_2
    way = way._replace(behind=_behind(way, seen, dt / volts_per_speed))
    noise = BEHIND * flow.position_noise
    stands = way.behind > noise + flow.play
    if way.p_dd > UNSURE and not _shows(seen):
        return _searched(way, seen, stands, a)
    x = seen.expected if way.behind <= noise else 0.0
    if stands:
        way = way._replace(p_dd=UNSURE)
    return _bounded(_least_squares(way, seen, max(0.0, x), a, dt), edge, a)


def _equation(
    way: DirectionEstimate, low: LowPassed, edge: Direction, law: ValveLaw, flow: FlowParameters, dt: float
) -> Equation:
    sign = math.copysign(1.0, low.mark_2)
    share, excess = sign * low.mark_2, sign * low.excess_2
    span = edge.rated_voltage - edge.deadband_voltage
    return Equation(
        share=share,
        excess=excess,
        flowing=share * _file_voltage(sign * low.opening_2 / share, sign, edge, law),
        expected=(excess - share * way.deadband) / (1.0 + way.stretch),
        noise=span * math.sqrt(opening_variance(low, flow, dt)),
        # The stages' difference is the low-pass' own rate of change.
        late=LAG_SPREAD * BANDWIDTH * abs(low.excess_1 - low.excess_2),
    )


def _shows(seen: Equation) -> bool:
    """Tell whether something flows, or its absence could not be told."""
    return seen.flowing >= CLEAR * seen.noise or seen.noise >= FINE * DEADBAND_SPREAD


def _behind(way: DirectionEstimate, seen: Equation, way_per_volt: float) -> float:
    """Return how far the actuator is behind its spool [m; rad]; a flow that shows has caught up."""
    if _shows(seen):
        return 0.0
    missed = seen.expected - seen.flowing - LATE * seen.late
    return max(0.0, way.behind + missed * way_per_volt)


def _searched(
    way: DirectionEstimate, seen: Equation, stands: bool, a: AdaptationParameters
) -> DirectionEstimate:
    """Return the estimate with d where the spool stands, once it is clear that nothing flows.

    That is so at once beside much that is expected, and by and by once the actuator `stands`. A joint that
    goes backwards falls through its play, and tells no more at once than one that stands. A first search,
    from which nothing is learnt yet, goes on until a flow shows.
    """
    goes_on = way.p_dd == 1.0 and way.deadband > 0.0
    clear = seen.expected - max(0.0, seen.flowing) > CLEAR * (seen.noise + seen.late)
    if goes_on or clear or stands:
        return way._replace(deadband=min(a.deadband_range, max(way.deadband, seen.excess / seen.share)))
    return way


def _least_squares(
    way: DirectionEstimate, seen: Equation, x: float, a: AdaptationParameters, dt: float
) -> DirectionEstimate:
    """Return recursive least squares' next estimate, with forgetting, for the regressor (i, x)."""
    model, slope = MODEL_VOLTS + MODEL_SHARE * abs(seen.flowing), 1.0 + way.stretch
    variance = (seen.noise * seen.noise + model * model) * slope * slope + seen.late * seen.late
    variance *= correlated_samples(dt)
    error = seen.excess - seen.share * way.deadband - slope * seen.flowing
    i = seen.share
    f_d, f_k = i * DEADBAND_SPREAD, x * STRETCH_SPREAD
    g_d, g_k = way.p_dd * f_d + way.p_dk * f_k, way.p_dk * f_d + way.p_kk * f_k
    total = variance + f_d * g_d + f_k * g_k
    forget = math.exp(dt / a.forgetting_time)
    return way._replace(
        deadband=way.deadband + DEADBAND_SPREAD * g_d / total * error,
        stretch=way.stretch + STRETCH_SPREAD * g_k / total * error,
        p_dd=forget * (way.p_dd - g_d * g_d / total),
        p_dk=forget * (way.p_dk - g_d * g_k / total),
        p_kk=forget * (way.p_kk - g_k * g_k / total),
    )


def _bounded(way: DirectionEstimate, edge: Direction, a: AdaptationParameters) -> DirectionEstimate:
    """Return the likeliest estimate within its ranges; its covariance is never wider than at the start.

    What its range takes from the gain, the deadband makes up for. Else d would fall for ever while a valve
    lets nothing through and k is at its end.
    """
    lowest = -min(a.deadband_range, max(0.0, edge.deadband_voltage))
    stretch = max(1.0 / a.gain_range - 1.0, min(a.gain_range - 1.0, way.stretch))
    moved = way.p_dk / way.p_kk * (stretch - way.stretch) * DEADBAND_SPREAD / STRETCH_SPREAD
    s_d, s_k = 1.0 / math.sqrt(max(1.0, way.p_dd)), 1.0 / math.sqrt(max(1.0, way.p_kk))
    return way._replace(
        deadband=max(lowest, min(a.deadband_range, way.deadband + moved)),
        stretch=stretch,
        p_dd=way.p_dd * s_d * s_d,
        p_dk=way.p_dk * s_d * s_k,
        p_kk=way.p_kk * s_k * s_k,
    )


def _file_voltage(opening: float, sign: float, edge: Direction, law: ValveLaw) -> float:
    """Return x [V] for an opening along the direction; a straight curve is straight beyond its ends, too."""
    if law.curve.sort == LINEAR:
        return opening * (edge.rated_voltage - edge.deadband_voltage)
    if opening <= 0.0:
        return 0.0
    return abs(voltage_for_opening(sign * opening, law)) - edge.deadband_voltage
