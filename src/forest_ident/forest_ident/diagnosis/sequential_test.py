"""One residual over time: is it still what it was, and what the machine file allows?

Page's cumulative sum, two-sided, of what a residual z is away from its reference r:

    d = min(CLIP, |z - r|/sigma),   g = max(0, g + d - k)  by the sign of z - r,   alarm: g > h

| symbol | name |
|---|---|
| r | mean of the first `LEARN` residuals, but no further from 0 than a healthy machine may be (tolerance) |
| sigma | spread of z of one healthy machine |
| k | slack, in sigma: what a healthy machine drifts |
| h | threshold, from healthy hours at a stated rate of false alarms |

Before r is learnt, z counts by how far it is beyond the tolerance. What is far off already at the start, as
with a wrong machine file, is therefore seen by the same sum. `CLIP` lets no single value raise an alarm.
Source: Page, Continuous inspection schemes, Biometrika 41, 1954.
"""

import math
from typing import NamedTuple

CLIP = 4.0  # [1] sigma
HIGHEST = 4.0  # [1] of h, beyond which a sum does not grow: what has healed is soon forgotten


class Limits(NamedTuple):
    """What is allowed to one residual."""

    spread: float  # sigma [the residual's]
    slack: float  # k [1]
    threshold: float  # h [1]
    tolerance: float  # [the residual's]
    learn: float  # residuals that make r; 0: r is 0


class Test(NamedTuple):
    """The sums of one residual."""

    seen: float = 0.0  # residuals until now
    mean: float = 0.0  # of the first ones
    high: float = 0.0  # g above
    low: float = 0.0  # g below


NEW = Test()


def tested(before: Test, z: float, p: Limits) -> Test:
    """Return the sums [1] after a residual z, in the unit of the limits' spread; NaN leaves them."""
    if math.isnan(z):
        return before
    seen, mean = before.seen + 1.0, before.mean
    if before.seen < p.learn:
        mean += (z - mean) / seen
    centre = mean if seen > p.learn else z
    reference = max(-p.tolerance, min(p.tolerance, centre))
    d = max(-CLIP, min(CLIP, (z - reference) / p.spread))
    most = HIGHEST * p.threshold
    high, low = before.high + d - p.slack, before.low - d - p.slack
    return Test(seen, mean, max(0.0, min(most, high)), max(0.0, min(most, low)))


def score(test: Test, p: Limits) -> float:
    """Return the greater sum over the threshold [1], with its side's sign: an alarm from 1 on."""
    return (test.high if test.high >= test.low else -test.low) / p.threshold
