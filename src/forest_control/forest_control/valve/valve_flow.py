"""A valve's opening from its flow: from motion, compression and leakage at the measured pressure drops.

| symbol | name | unit |
|---|---|---|
| V, V_d | voltage at which the spool stands, along its direction; deadband of the machine's file | V |
| Q_1, Q_2 | flow through the valve into port 1, out of port 2: displacement, compression, leakage | m^3/s |
| A_1, A_2 | displacement of port 1, 2 | m^2; m^3/rad |
| S, N | `valve_driver`'s, of the orifices whose flow is known, with the drops measured at the valve | |
| y | actuator speed, mean of Q_1/A_1 and Q_2/A_2 weighted by the orifices' shares of S | m/s; rad/s |

The opening is y sqrt(S / N). Behind a compensator the inlet's flow counts alone, at the drop that is kept
over its edge as long as the pump leaves more. Flows, openings and V count along the positive direction here.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.valve_characteristic import ValveLaw

BANDWIDTH = (
    2.0 * math.pi * 10.0
)  # [rad/s] of both stages of the low-pass, 10 Hz; chosen: a jump must be learnt in time
CUBED_BANDWIDTH = BANDWIDTH**3  # [rad^3/s^3] of the low-pass' noise (`opening_variance`), computed once
EMPTY = 1e5  # [Pa] port pressure below which anti-cavitation checks may feed it past the valve
ABOVE_SUPPLY = 1.1  # [1] of the supply pressure: above, a port's relief valve may open
LEAST_DROP = 0.02  # [1] of the supply pressure: a smaller drop at an orifice is the transducers' noise


class Yielding(NamedTuple):
    """The oil between a valve's edge and its actuator: C = fixed + growing x at the actuator's position x."""

    fixed: float = 0.0  # [m^3/Pa]
    growing: float = 0.0  # [m^3/Pa per m; per rad]


class FlowParameters(NamedTuple):
    """What is known of one actuator beside its valve."""

    displacement_1: float  # [m^2; m^3/rad]
    displacement_2: float
    oil_1: Yielding  # of hose and chamber
    oil_2: Yielding
    internal_leakage: float  # between the ports [m^3/(s Pa)]
    external_leakage: float  # of each port to the case
    position_noise: float  # [m; rad] standard deviation of a sample
    supply_pressure: float  # [Pa]
    dead_time: float = 0.0  # of the valve [s]
    play: float = 0.0  # of the gear between motor and joint [rad]
    metering_drop: float = math.inf  # that a compensator leaves to the edge to the pump [Pa]


class AxisMeasurement(NamedTuple):
    """What is measured of one axis after a period."""

    position: float  # of the actuator [m; rad]
    valve_1: float  # pressures at the valve's ports [Pa]
    valve_2: float
    port_1: float  # at the actuator's
    port_2: float
    supply: float
    spool: float  # [V] mean of the period, from the driver's own voltage


class FlowOpening(NamedTuple):
    """The valve's opening by one period's measurements."""

    opening: float
    gradient: float  # d(opening)/dy [s/m; s/rad]
    known: bool


class LowPassed(NamedTuple):
    """Signals behind the low-pass' first and second stage."""

    opening_1: float = 0.0
    opening_2: float = 0.0
    excess_1: float = 0.0  # V - V_d of an open spool [V]
    excess_2: float = 0.0
    mark_1: float = 0.0  # +1, -1 while it is open and the flow is known
    mark_2: float = 0.0
    open_1: float = 0.0  # 1 while it is open
    open_2: float = 0.0
    gradient_1: float = 0.0
    gradient_2: float = 0.0


NO_MEASUREMENT = AxisMeasurement(
    position=0.0, valve_1=0.0, valve_2=0.0, port_1=0.0, port_2=0.0, supply=0.0, spool=0.0
)


def low_passed(
    old: LowPassed, flow: FlowOpening, spool: float, excess: float, widened: float, dt: float
) -> LowPassed:
    """Return the low-pass a period of dt [s] later.

    Args:
        old: what it was.
        flow: opening by the period's flow.
        spool: V, with its direction's sign [V].
        excess: V - V_d [V].
        widened: what the overlap is known to be wider than V_d [V].
        dt: period [s].
    """
    is_open = excess > widened
    # The flow of a shut valve is noise, which the low-pass must have seen before the valve opens.
    mark = math.copysign(1.0, spool) if is_open and flow.known else 0.0
    share = 1.0 - math.exp(-BANDWIDTH * dt)
    opening = old.opening_1 + share * (flow.opening - old.opening_1)
    beyond = old.excess_1 + share * (mark * excess - old.excess_1)
    marked = old.mark_1 + share * (mark - old.mark_1)
    opened = old.open_1 + share * ((1.0 if is_open else 0.0) - old.open_1)
    gradient = old.gradient_1 + share * (flow.gradient - old.gradient_1)
    return LowPassed(
        opening_1=opening,
        opening_2=old.opening_2 + share * (opening - old.opening_2),
        excess_1=beyond,
        excess_2=old.excess_2 + share * (beyond - old.excess_2),
        mark_1=marked,
        mark_2=old.mark_2 + share * (marked - old.mark_2),
        open_1=opened,
        open_2=old.open_2 + share * (opened - old.open_2),
        gradient_1=gradient,
        gradient_2=old.gradient_2 + share * (gradient - old.gradient_2),
    )


def opening_from_flow(
    last: AxisMeasurement, sample: AxisMeasurement, law: ValveLaw, a: FlowParameters, dt: float
) -> FlowOpening:
    """Return the opening that lets the measured flow through at the measured drops.

    Thesis eq. 3.1, 3.7, 3.14, 4.8. Differs: both orifices are taken at once.
    """
    speed = (sample.position - last.position) / dt
    between = a.internal_leakage * (sample.port_1 - sample.port_2)
    flow_1 = a.displacement_1 * speed + between + a.external_leakage * sample.port_1
    flow_1 += (a.oil_1.fixed + a.oil_1.growing * sample.position) * (sample.port_1 - last.port_1) / dt
    flow_2 = a.displacement_2 * speed + between - a.external_leakage * sample.port_2
    flow_2 -= (a.oil_2.fixed + a.oil_2.growing * sample.position) * (sample.port_2 - last.port_2) / dt
    forward = sample.spool > 0.0
    way = law.forward if forward else law.backward
    drop_1 = sample.supply - sample.valve_1 if forward else sample.valve_1
    drop_2 = sample.valve_2 if forward else sample.supply - sample.valve_2
    known_1, known_2 = _is_known(sample.port_1, drop_1, a), _is_known(sample.port_2, drop_2, a)
    if a.metering_drop < math.inf:
        known_1 = known_1 and forward and drop_1 > a.metering_drop
        known_2 = known_2 and not forward and drop_2 > a.metering_drop
        drop_1 = drop_2 = a.metering_drop
    elif sample.port_1 <= EMPTY and sample.port_2 <= EMPTY:
        # Both empty after a rest: nothing moves yet that a check valve might feed.
        known_1, known_2 = forward, not forward
    s_1 = way.resistance_1 * a.displacement_1**3 if known_1 else 0.0
    s_2 = way.resistance_2 * a.displacement_2**3 if known_2 else 0.0
    force = (a.displacement_1 * drop_1 if known_1 else 0.0) + (a.displacement_2 * drop_2 if known_2 else 0.0)
    if s_1 + s_2 == 0.0 or force <= 0.0:
        return FlowOpening(0.0, 0.0, False)
    y = (s_1 * flow_1 / a.displacement_1 + s_2 * flow_2 / a.displacement_2) / (s_1 + s_2)
    gradient = math.sqrt((s_1 + s_2) / force)
    return FlowOpening(y * gradient, gradient, True)


def _is_known(port: float, drop: float, a: FlowParameters) -> bool:
    """Tell whether pressures [Pa] tell a port's flow: nothing else feeds it, and the drop is not noise."""
    return EMPTY < port < ABOVE_SUPPLY * a.supply_pressure and drop > LEAST_DROP * a.supply_pressure


def opening_variance(low: LowPassed, a: FlowParameters, dt: float) -> float:
    """Return the variance of the low-passed opening.

    White noise of the position, differentiated behind the low-pass of corner w, has the variance
    w^3 dt / 4 times its own.
    """
    noise = a.position_noise * low.gradient_2
    return noise * noise * CUBED_BANDWIDTH * dt / 4.0


def correlated_samples(dt: float) -> float:
    """Return how many samples in a row have mostly the same noise behind the low-pass."""
    return max(1.0, 4.0 / (BANDWIDTH * dt))
