"""The one law of every sensor: what a channel reads of a true value.

| symbol | name | unit |
|---|---|---|
| x | true value, then what the sensor's lag leaves of it | the channel's |
| tau | time constant of the first-order lag, 0: none | s |
| g, b | gain and static bias of this unit | 1; the channel's |
| sigma, n | standard deviation of a sample; a draw from the standard normal distribution | the channel's; 1 |
| h | play: way that the true value goes, after it turned, before a cable or drum follows | the channel's |

With play, which a lag excludes, x is what the drum shows: within h/2 of the true value, and moved
by nothing but that.

A reading is g x + b + sigma n, at least as large as the floor, in whole steps of the resolution,
between the ends of the range. NaN stands for a missing reading.

A turbine's blades do not tell which way the oil goes. The floor keeps the sign of the true flow, as
a data acquisition that knows the spool's side would; oil at rest reads plus the floor.

Everything here is pure and stays in the subset of Python that `forest_compile.frontend` takes.
"""

import math
from typing import NamedTuple

# How a channel works, in the order in which the worse of two wins.
WORKS = 0
FROZEN = 1  # repeats its last reading
DROPPED = 2  # loses this sample
ABSENT = 3  # is not there
WHOLE = 2.0**53  # from here on every float is a whole number


class SensorModel(NamedTuple):
    """Constants of one sensor; the defaults are those of an exact one."""

    time_constant: float = 0.0
    gain: float = 1.0
    bias: float = 0.0
    noise: float = 0.0
    floor: float = 0.0
    resolution: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    mode: int = WORKS
    play: float = 0.0


class SensorMemory(NamedTuple):
    """What a sensor remembers: what lag or play leaves of the true value, and the last reading."""

    lagged: float
    reading: float


EXACT = SensorModel()


def sample(
    c: SensorModel, s: SensorMemory, true: float, dt: float, normal: float
) -> tuple[SensorMemory, float]:
    """Return a sensor's state and reading, `dt` [s] after the last call; NaN: there is none.

    Thesis table 4.2, section 4.3.2.4: a flow below the meter's floor reads as the floor.

    Args:
        c: the channel.
        s: its state after the last call.
        true: value now, taken to have held since the last call.
        dt: time since then [s].
        normal: draw from the standard normal distribution.
    """
    lagged = true
    if c.time_constant > 0.0:
        lagged = true + (s.lagged - true) * math.exp(-dt / c.time_constant)
    elif c.play > 0.0:
        lagged = max(true - 0.5 * c.play, min(true + 0.5 * c.play, s.lagged))
    if c.mode == FROZEN:
        return SensorMemory(lagged, s.reading), s.reading
    if c.mode != WORKS:
        return SensorMemory(lagged, s.reading), math.nan
    reading = c.gain * lagged + c.bias + c.noise * normal
    if c.floor > 0.0:
        size = max(abs(reading), c.floor)
        reading = -size if lagged < 0.0 else size
    if c.resolution > 0.0:
        steps = reading / c.resolution + 0.5
        if abs(steps) < WHOLE:  # floor() would raise for what is not finite
            reading = c.resolution * math.floor(steps)
    reading = max(c.low, min(c.high, reading))
    return SensorMemory(lagged, reading), reading


def sample_if(
    due: bool, c: SensorModel, s: SensorMemory, true: float, dt: float, normal: float
) -> tuple[SensorMemory, float]:
    """Do as `sample` where a sample is due; between its samples a sensor holds what it read last."""
    if due and c == EXACT:
        return sample_exactly(true)
    if not due and c.mode != ABSENT:
        c = c._replace(mode=FROZEN)
    return sample(c, s, true, dt, normal)


def sample_exactly(true: float) -> tuple[SensorMemory, float]:
    """What `sample` returns of an `EXACT` channel, whose arithmetic changes nothing but the sign of zero."""
    reading = true + 0.0
    return SensorMemory(true, reading), reading
