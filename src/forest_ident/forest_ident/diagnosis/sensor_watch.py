"""Each sensor by itself: is it there, and does it still jitter?

A sensor that jittered while the machine stood, and that gives the same number to the last bit for `STILL`
windows, is frozen. One that reads exactly zero, as a transducer at the end of its range, is not judged.
The controller sees a frozen resolver of a moving joint sooner, and stops; this sees every sensor, later.
"""

import math
from typing import NamedTuple

LIVELY = 20.0  # windows of a standing machine in which a sensor changed, until it is known to jitter
STILL = 4.0  # windows without a change
GONE = 2.0  # windows without a reading


class Sensor(NamedTuple):
    """What is remembered of a sensor."""

    last: float = math.nan
    changes: float = 0.0  # in this window
    read: float = 0.0  # readings in this window
    lively: float = 0.0  # windows
    still: float = 0.0
    gone: float = 0.0
    was_there: float = 0.0  # 1 once it has been read


UNSEEN = Sensor()


def heard(s: Sensor, reading: float) -> Sensor:
    """Return a sensor after a sample: its reading in any unit, NaN for none."""
    if math.isnan(reading):
        return s
    changed = 0.0 if reading == s.last else 1.0
    return s._replace(last=reading, changes=s.changes + changed, read=s.read + 1.0, was_there=1.0)


def judged(s: Sensor, stands: bool) -> Sensor:
    """Return a sensor at a window's end; stands: the machine stood for all of it."""
    if s.read == 0.0:
        return s._replace(changes=0.0, read=0.0, gone=s.gone + 1.0)
    lively, still = s.lively, 0.0
    if s.changes > 0.0:
        lively += 1.0 if stands else 0.0
    elif s.last != 0.0:
        still = s.still + 1.0
    return s._replace(changes=0.0, read=0.0, lively=lively, still=still, gone=0.0)


def is_frozen(s: Sensor) -> bool:
    """Tell whether a sensor repeats its last reading."""
    return s.lively >= LIVELY and s.still >= STILL


def is_missing(s: Sensor, fitted: int) -> bool:
    """Tell whether a sensor that was there, or that the machine file has (fitted: 1), gives no readings."""
    return s.gone >= GONE and (s.was_there > 0.0 or fitted == 1)
