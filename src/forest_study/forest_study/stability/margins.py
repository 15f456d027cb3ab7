"""Gain and phase margins of an open loop L(jw), from its values at many frequencies."""

from typing import NamedTuple

import numpy as np

from forest_description.types import Complexes, Floats


class Margins(NamedTuple):
    """How far a loop is from swinging up; inf and NaN where it never crosses."""

    gain: float  # by which the loop may grow: the least 1/|L| where the phase falls through -180 deg
    gain_frequency: float  # [Hz] there: at which it would swing
    phase: float  # [deg] the least over -180 deg where |L| is 1
    crossover: float  # [Hz] there
    sensitivity: float  # greatest |1/(1 + L)|: how much the loop amplifies a disturbance


def margins(frequency: Floats, loop: Complexes) -> Margins:
    """Return the margins of a loop.

    Args:
        frequency: [n] Hz, rising, close enough that the phase turns by less than a right angle between two.
        loop: [n] L.
    """
    size, phase = np.log(np.abs(loop)), np.degrees(np.unwrap(np.angle(loop)))
    phase -= 360.0 * np.round((phase[0] + 90.0) / 360.0)  # an integrator's, at the lowest frequency
    gain, at = np.inf, np.nan
    for turn in range(-180, int(phase.min()) - 1, -360):
        for place in _crossings(frequency, phase - turn, falling=True):
            possible = float(np.exp(-_between(frequency, size, place)))
            if possible < gain:
                gain, at = possible, place
    least, crossover = np.inf, np.nan
    for place in _crossings(frequency, size):
        over = _between(frequency, phase, place) + 180.0
        if over < least:
            least, crossover = over, place
    return Margins(gain, at, least, crossover, float(np.max(1.0 / np.abs(1.0 + loop))))


def _crossings(frequency: Floats, values: Floats, falling: bool = False) -> list[float]:
    """Return the frequencies [Hz] at which values change their sign, or only fall through zero."""
    before, after = np.signbit(values[:-1]), np.signbit(values[1:])
    places = np.flatnonzero(after & ~before if falling else after != before)
    share = values[places] / (values[places] - values[places + 1])
    logarithm = np.log(frequency)
    found = np.exp(logarithm[places] + share * (logarithm[places + 1] - logarithm[places]))
    return [float(place) for place in found]


def _between(frequency: Floats, values: Floats, place: float) -> float:
    return float(np.interp(np.log(place), np.log(frequency), values))
