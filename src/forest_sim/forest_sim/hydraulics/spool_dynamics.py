"""How a spool follows its voltage: at once, with a first-order lag, as a second-order system, or not at all.

| symbol | name | unit |
|---|---|---|
| V | voltage behind the dead time (`command_history`) | V |
| u | what the spool goes for, V behind its play | V |
| b | width of the play, the hysteresis | V |
| x, v | spool position, as the voltage that it stands for; its rate | V, V/s |
| w, zeta | natural frequency (first order: the cut-off); damping ratio | rad/s, 1 |
| S | slew limit of the rate | V/s |

Thesis section 3.2.2 leaves the lag out and names the cut-off, 10 to 15 Hz.

**Play.** u stays while |V - u| <= b/2, and else follows V at that distance. On the way up the
spool lags the voltage by b/2, on the way down it leads by b/2. That is a spool on its centring
spring k with Coulomb friction F, moved slowly: b = 2 F/k (Prandtl's element). The play is taken of
the command, so that the lag stays linear. Breaking away is no harder than sliding: there is no
stick-slip. Dither would make b smaller; give the width that is left.

**Flow forces** push a spool towards its centre by F/k (`flow_force`): it goes for u - F/k. They are
known in the middle of a step (`pushed_spools`).

Under a held voltage u is constant, and a step is the exact solution: of the lag; with a slew limit
of a ramp and the lag in turn, joined where the law changes.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.valve_parameters import Valve
from forest_sim.hydraulics.flow_force import jet_factor


class SpoolLag(NamedTuple):
    """Constants of the law; a frequency of inf follows at once, one of 0 is a stuck spool."""

    frequency: float  # w [rad/s]
    damping: float  # zeta; 0: first order
    play: float = 0.0  # b [V]
    slew: float = math.inf  # S [V/s]
    dead_time: float = 0.0  # [s], see `command_history`
    jet: float = 0.0  # of the flow forces, see `flow_force.jet_factor`; 0: none


class Spool(NamedTuple):
    """Where a spool is, how fast it moves (second order only), and what it goes for."""

    position: float  # [V]
    rate: float  # [V/s]
    target: float = 0.0  # u [V]; without play it is not kept


Spools = tuple[Spool, Spool, Spool]
STUCK = SpoolLag(0.0, 0.0)
SLEWING = 1e-9  # of the limit, under which a rate is on it
HALVINGS = 60
CENTRED = Spool(0.0, 0.0)


def spool_lag(valve: Valve, density: float = 0.0) -> SpoolLag:
    """Return the kernel's constants of a valve's spool in oil of a density [kg/m^3]."""
    bandwidth, slew, centring = valve.spool_bandwidth, valve.spool_slew_limit, valve.centring_force
    return SpoolLag(
        frequency=math.inf if bandwidth is None else 2.0 * math.pi * bandwidth,
        damping=valve.spool_damping or 0.0,
        play=valve.hysteresis or 0.0,
        slew=math.inf if slew is None else slew,
        dead_time=valve.dead_time or 0.0,
        jet=0.0 if centring is None else jet_factor(density, centring),
    )


def spool_after(spool: Spool, voltage: float, time: float, lag: SpoolLag, push: float = 0.0) -> Spool:
    """Return a spool after a time [s] under a held voltage [V] and flow forces that push it by F/k [V].

    Thesis section 3.2.2. Differs: the thesis takes the spool to follow at once; so does a frequency
    of inf.
    """
    if lag.frequency == 0.0:
        return spool
    if lag.play == 0.0 and lag.slew == math.inf and lag.jet == 0.0:
        return _lagging(spool, voltage, time, lag)
    return _driven_spool(spool, voltage, time, lag, push)


def _driven_spool(spool: Spool, voltage: float, time: float, lag: SpoolLag, push: float) -> Spool:
    """Return a spool with play, slew limit or flow forces; not inlined."""
    target = behind_play(spool.target, voltage, lag.play)
    aim = target - push
    after = _slewed(spool, aim, time, lag) if lag.slew < math.inf else _lagging(spool, aim, time, lag)
    return Spool(after.position, after.rate, target)


def behind_play(target: float, voltage: float, play: float) -> float:
    """Return u [V] after the voltage [V] has come to a value, from the u before it [V]."""
    return max(voltage - 0.5 * play, min(voltage + 0.5 * play, target))


def _lagging(spool: Spool, voltage: float, time: float, lag: SpoolLag) -> Spool:
    """Return a spool after a time [s] by its lag alone."""
    if lag.damping == 0.0:
        gap = (
            (spool.position - voltage) * math.exp(-lag.frequency * time) if lag.frequency < math.inf else 0.0
        )
        return Spool(voltage + gap, 0.0)
    return _second_order(spool, voltage, time, lag)


def _second_order(spool: Spool, voltage: float, time: float, lag: SpoolLag) -> Spool:
    """Return the exact solution of x'' + 2 zeta w x' + w^2 (x - V) = 0."""
    w, zeta = lag.frequency, lag.damping
    gap, rate = spool.position - voltage, spool.rate
    decay, split = zeta * w, w * math.sqrt(abs(zeta * zeta - 1.0))
    # c(t) and s(t) solve the equation; both limits meet at zeta = 1.
    fade = math.exp(-decay * time)
    if split * time < 1e-6:
        c, s = fade, fade * time
    elif zeta < 1.0:
        c, s = fade * math.cos(split * time), fade * math.sin(split * time) / split
    else:  # as two decays: cosh and sinh of a long time would overflow
        slow, fast = math.exp((split - decay) * time), math.exp(-(split + decay) * time)
        c, s = 0.5 * (slow + fast), 0.5 * (slow - fast) / split
    return Spool(
        voltage + gap * c + (rate + decay * gap) * s,
        rate * c - (w * w * gap + decay * rate) * s,
    )


def _slewed(spool: Spool, target: float, time: float, lag: SpoolLag) -> Spool:
    """Return a spool whose rate is limited: free, then on the ramp at the limit, then free again.

    The ramp ends where the lag alone is no faster: at a distance of S/w of the first order, of
    2 zeta S/w of the second. From there on the rate falls.
    """
    free = 0.0 if lag.damping == 0.0 else _time_to_limit(spool, target, time, lag)
    if free >= time:
        return _lagging(spool, target, time, lag)
    if free > 0.0:
        spool = _lagging(spool, target, free, lag)
    gap = target - spool.position
    factor = 1.0 if lag.damping == 0.0 else 2.0 * lag.damping
    ramp = max(0.0, abs(gap) / lag.slew - factor / lag.frequency)
    rate = math.copysign(lag.slew, gap)
    if ramp >= time - free:
        return Spool(spool.position + rate * (time - free), 0.0 if lag.damping == 0.0 else rate)
    at_its_end = Spool(spool.position + rate * ramp, rate)
    return _lagging(at_its_end, target, time - free - ramp, lag)


def _time_to_limit(spool: Spool, target: float, time: float, lag: SpoolLag) -> float:
    """Return when a second-order spool reaches its slew limit [s]; `time` or more if not within it.

    Up to its first extremum the free rate is monotone, and no later extremum is greater. So the
    limit is met before it or never, and halving finds where.
    """
    w = lag.frequency
    acceleration = w * w * (target - spool.position) - 2.0 * lag.damping * w * spool.rate
    if abs(spool.rate) >= lag.slew * (1.0 - SLEWING) and spool.rate * acceleration > 0.0:
        return 0.0
    late = min(time, _time_to_extremum(spool.rate, acceleration, lag))
    if abs(_lagging(spool, target, late, lag).rate) <= lag.slew:
        return time
    early = 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (early + late)
        if abs(_lagging(spool, target, middle, lag).rate) < lag.slew:
            early = middle
        else:
            late = middle
    return late


def _time_to_extremum(rate: float, acceleration: float, lag: SpoolLag) -> float:
    """Return when the acceleration of a free second-order spool is zero first [s]; inf: never."""
    if acceleration == 0.0:
        return 0.0
    w, zeta = lag.frequency, lag.damping
    split = w * math.sqrt(abs(zeta * zeta - 1.0))
    # The acceleration obeys the spool's own equation: zero where c(t)/s(t) is this.
    ratio = zeta * w + w * w * rate / acceleration
    if zeta < 1.0:
        return math.atan2(split, ratio) / split
    if ratio <= split:
        return math.inf
    if split < 1e-6 * ratio:
        return 1.0 / ratio
    return 0.5 * math.log((ratio + split) / (ratio - split)) / split
