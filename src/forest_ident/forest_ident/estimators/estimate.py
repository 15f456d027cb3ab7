"""What an estimator says: a value with its standard error, interval, condition and doubts.

| symbol | name |
|---|---|
| s | standard error, in the parameter's unit |
| interval | value ± 1.96 s, 95 %; of a positive quantity value · exp(± 1.96 s/value) |
| condition | condition number of the problem in units in which every column has length 1 |
"""

from __future__ import annotations

import math
from typing import NamedTuple

NORMAL_95 = 1.959963985
ILL_CONDITIONED = 1e5
LOOSE = 0.2  # of a positive value, of a volt: a standard error beyond it says that the data cannot tell

MOTION = {
    "deadband_voltage": "slow ramps of the voltage through the overlap, both ways",
    "minimum_resistance": "the valve held at several openings between a fifth and full",
    "port_2_area": "pressures at both ports of the valve with oil flowing through both",
    "spool_bandwidth": "steps of the voltage, with a spool sensor or within 20 ms",
    "turbulent_resistance": "steady flows up to the pump's greatest, pressures at both ends",
    "laminar_resistance": "steady flows in the laminar range, pressures at both ends",
    "inertance": "steps of flow above the meter's floor, meters at both ends",
    "capacitance": "steps of pressure by a third of the supply's, meters at both ends",
    "internal_leakage_resistance": "the crane creeping on a tilted platform, its swing valve shut",
    "external_leakage_resistance": "the swing driven for minutes with its case drain measured",
    "damping": "the axis at several steady speeds, both ways through the same angles",
    "supply_pressure": "an axis held against its end, a transducer in the supply",
    "margin": "oil flowing at several loads, a transducer in the supply",
    "response_time": "steps of flow or load, a transducer in the supply",
    "head_mass": "boom and stick resting in five or more poses",
    "boom_mass": "boom and stick resting in five or more poses",
    "stick_mass": "the head weighed by itself, or taken off: at rest both pull alike",
    "base_zz": "fast starts and stops of the swing, boom and stick folded and stretched; it is taken as told",
}


def motion_for(key: str) -> str:
    """Return the motion that tells a parameter."""
    return MOTION.get(key.rpartition(".")[2], "a motion in which it matters")


class Estimate(NamedTuple):
    """One parameter as the data tell it."""

    key: str  # dotted, of the machine file
    value: float  # [unit]
    standard_error: float  # [unit]
    unit: str
    condition: float  # of the fit that it comes from
    method: str
    positive: bool = True
    warning: str = ""

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval [unit]."""
        if self.positive and self.value > 0.0:
            factor = math.exp(min(NORMAL_95 * self.standard_error / self.value, 50.0))
            return self.value / factor, self.value * factor
        reach = NORMAL_95 * self.standard_error
        return self.value - reach, self.value + reach

    def spelled(self) -> tuple[str, str, str]:
        """Return value and both ends of the interval, in digits that tell them apart."""
        low, high = self.interval
        apart = (high - low) / max(abs(low), abs(high), 1e-300)
        digits = 5 if not 0.0 < apart < 1.0 else min(max(5, 2 - math.floor(math.log10(apart))), 12)
        value, low_text, high_text = (f"{number:.{digits}g}" for number in (self.value, low, high))
        return value, low_text, high_text

    def holds(self, truth: float) -> bool:
        """Tell whether the interval holds a value [unit]."""
        low, high = self.interval
        return low <= truth <= high


def is_loose(value: float, error: float, positive: bool) -> bool:
    """Tell whether a standard error says that the data cannot tell a value."""
    return not (math.isfinite(value) and error <= LOOSE * (abs(value) if positive else 1.0))


def judged(e: Estimate) -> Estimate:
    """Return the estimate with a plain warning if the data cannot tell its value, and what motion would."""
    e, motion = e._replace(warning=""), motion_for(e.key)
    if not (math.isfinite(e.value) and math.isfinite(e.standard_error)):
        return e._replace(warning=f"the data hold nothing of {e.key}; it takes {motion}")
    if is_loose(e.value, e.standard_error, e.positive):
        return e._replace(warning=f"the data cannot tell {e.key} (interval too wide); it takes {motion}")
    if e.condition > ILL_CONDITIONED:
        return e._replace(
            warning=f"{e.key} is told apart from the others only by little (condition number "
            f"{e.condition:.0e}); it takes {motion}"
        )
    return e
