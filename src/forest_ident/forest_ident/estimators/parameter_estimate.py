"""An estimated parameter: value, standard error, 95 % interval, condition number and warning.

| symbol | name |
|---|---|
| s | standard error, in the parameter's unit |
| interval | value ± 1.96 s, 95 %; of a positive quantity value · exp(± 1.96 s/value) |
| condition | condition number of the problem in units in which every column has length 1 |
"""

from __future__ import annotations

import math
from typing import NamedTuple

from forest_description.config import schema
from forest_description.machine import Machine

NORMAL_95 = 1.959963985
ILL_CONDITIONED = 1e6
OVERLOADED = "the valve opened against a load that takes all of the pump's pressure"
LOOSE = 0.2  # of a positive value, of a volt: a parameter with a greater standard error is not identified

EXCITATION = {
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
    "coulomb_force": "the axis at several speeds, slow ones too, both ways",
    "breakaway_force": "the axis started from rest, slowly, both ways, many times",
    "coulomb_torque": "the swing at several speeds, slow ones too, both ways",
    "breakaway_torque": "the swing started from rest, slowly, both ways, many times",
    "hysteresis": "steps of the voltage up and down to the same level, with a spool sensor",
    "dead_time": "steps of the voltage, with a spool sensor read every 5 ms or faster",
    "spool_slew_limit": "steps of the voltage by half the rated one and more, with a spool sensor",
    "share": "starts and stops of boom and stick at low pressure, a transducer at each port",
    "setting": "the load lowered at several speeds and weights, transducers at the actuator",
    "pilot_ratio": "the load lowered at several speeds and weights, transducers at the actuator",
    **dict.fromkeys(("compensator.setting", "control_range", "compensator.minimum_resistance"), OVERLOADED),
    "compensator.response_time": f"{OVERLOADED}, in steps",
    "free_way": "the swing turned round at several speeds, with a resolver at the joint",
    "leakage_conductance": "boom and stick resting for seconds in several poses, their valves shut",
    "stiffness": "a known load hung on the tip, its sag measured from outside; it is taken as stated",
    "head_dead_volume": "the oil's air known: both make it softer; it is taken as stated",
    "rod_dead_volume": "the oil's air known: both make it softer; it is taken as stated",
    "port_volume": "the oil's air known: both make it softer; it is taken as stated",
    "motor_inertia": "the motor weighed or its plate read; it is taken as stated",
    "stribeck_speed": "the axis crept at constant speeds under 10 mm/s; it is taken as stated",
    "head_mass": "boom and stick resting in five or more poses",
    "boom_mass": "boom and stick resting in five or more poses",
    "stick_mass": "the head weighed by itself, or taken off: at rest both pull alike",
    "base_zz": "fast swing starts and stops, boom and stick folded and stretched; it is taken as stated",
}


def excitation_for(key: str) -> str:
    """Return the motion that identifies a parameter."""
    section, _, name = key.rpartition(".")
    own = f"{section.rpartition('.')[2]}.{name}"
    return EXCITATION.get(own, EXCITATION.get(name, "a motion in which it matters"))


class Estimate(NamedTuple):
    """One parameter as estimated from records."""

    key: str  # dotted, of the machine file
    value: float  # [unit]
    standard_error: float  # [unit]
    unit: str
    condition: float  # of the fit that it comes from
    method: str
    positive: bool = True
    warning: str = ""
    initial: bool = True  # of a linear estimate: whether the refinement starts from it
    withheld: bool = False  # whether its interval means nothing: the model does not explain its record
    stated: float = 0.0  # share of its variance that comes from stated numbers
    most: str = ""  # the stated number that most of that comes from

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval [unit]."""
        if self.positive and self.value > 0.0:
            factor = math.exp(min(NORMAL_95 * self.standard_error / self.value, 50.0))
            return self.value / factor, self.value * factor
        reach = NORMAL_95 * self.standard_error
        return self.value - reach, self.value + reach

    @property
    def usable(self) -> bool:
        """Whether the value is a positive number."""
        return math.isfinite(self.value) and self.value > 0.0

    def formatted(self) -> tuple[str, str, str]:
        """Return value and both ends of the interval, in digits that tell them apart."""
        low, high = self.interval
        apart = (high - low) / max(abs(low), abs(high), 1e-300)
        digits = 5 if not 0.0 < apart < 1.0 else min(max(5, 2 - math.floor(math.log10(apart))), 12)
        value, low_text, high_text = (f"{number:.{digits}g}" for number in (self.value, low, high))
        return value, low_text, high_text

    def contains(self, truth: float) -> bool:
        """Tell whether the interval contains a value [unit]."""
        low, high = self.interval
        return low <= truth <= high

    def checked(self) -> Estimate:
        """Return the estimate with a warning if its value is not identified, and which motion would help."""
        motion, text = excitation_for(self.key), ""
        if not (math.isfinite(self.value) and math.isfinite(self.standard_error)):
            text = f"the data hold nothing of {self.key}; it takes {motion}"
        elif is_loose(self.value, self.standard_error, self.positive):
            text = f"the data cannot tell {self.key} (interval too wide); it takes {motion}"
        elif self.condition > ILL_CONDITIONED:
            text = (
                f"{self.key} is told apart from the others only by little (condition number "
                f"{self.condition:.0e}); it takes {motion}"
            )
        return self._replace(warning=text)


def is_positive(key: str) -> bool:
    """Tell whether a parameter is positive, and so estimated by its logarithm."""
    return not key.endswith("deadband_voltage")


def is_loose(value: float, error: float, positive: bool) -> bool:
    """Tell whether a standard error is so great that the value is not identified."""
    return not (math.isfinite(value) and error <= LOOSE * (abs(value) if positive else 1.0))


def unit_of(key: str) -> str:
    """Return the unit of a machine file's number, by its dotted key."""
    return schema.parameters(Machine)[key].unit
