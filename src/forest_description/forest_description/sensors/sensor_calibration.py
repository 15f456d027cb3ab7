"""What the calibration of the machine's sensors found, unit by unit: offsets and gains.

| symbol | name | unit |
|---|---|---|
| y, x | reading, true value | the sensor's |
| g | ``gain`` | 1 |
| b | ``offset``: reading at no pressure, no flow, melting ice, less the true value | the sensor's |

A unit reads y = g x + b; a thermocouple y − 273.15 K = g (x − 273.15 K) + b. A unit that is None
was not
calibrated: its error lies somewhere within the accuracy of its kind.
"""

from dataclasses import dataclass

from forest_description.config.parameter import ParameterSet, component, parameter

ICE_POINT = 273.15  # [K]


@dataclass(frozen=True)
class CalibratedPressure(ParameterSet):
    """A pressure transducer, calibrated against the atmosphere. Thesis section 4.3.1."""

    offset: float = parameter("Pa", -1e7, 1e7, "reading at atmospheric pressure")
    gain: float = parameter("1", 0.5, 2.0, "change of the reading over that of the pressure")


@dataclass(frozen=True)
class CalibratedFlow(ParameterSet):
    """A flow meter, calibrated against the other one. Thesis section 4.3.1."""

    offset: float = parameter("m3/s", -0.01, 0.01, "reading less gain times flow")
    gain: float = parameter("1", 0.5, 2.0, "change of the reading over that of the flow")


@dataclass(frozen=True)
class CalibratedTemperature(ParameterSet):
    """A thermocouple, calibrated in melting ice and boiling water. Thesis section 4.3.1."""

    offset: float = parameter("K", -50.0, 50.0, "reading in melting ice less its 273.15 K")
    gain: float = parameter("1", 0.5, 2.0, "change of the reading over that of the temperature")


Unit = CalibratedPressure | CalibratedFlow | CalibratedTemperature


@dataclass(frozen=True)
class Calibration(ParameterSet):
    """Every unit that can be calibrated; None: it was not. Thesis section 4.3.1."""

    swing_pressure_1_valve: CalibratedPressure | None = component()
    swing_pressure_1_actuator: CalibratedPressure | None = component()
    swing_pressure_2_valve: CalibratedPressure | None = component()
    swing_pressure_2_actuator: CalibratedPressure | None = component()
    boom_pressure_1_valve: CalibratedPressure | None = component()
    boom_pressure_1_actuator: CalibratedPressure | None = component()
    boom_pressure_2_valve: CalibratedPressure | None = component()
    boom_pressure_2_actuator: CalibratedPressure | None = component()
    stick_pressure_1_valve: CalibratedPressure | None = component()
    stick_pressure_1_actuator: CalibratedPressure | None = component()
    stick_pressure_2_valve: CalibratedPressure | None = component()
    stick_pressure_2_actuator: CalibratedPressure | None = component()
    supply_pressure: CalibratedPressure | None = component()
    swing_flow: CalibratedFlow | None = component()
    stick_flow: CalibratedFlow | None = component()
    tank_temperature: CalibratedTemperature | None = component()
    pump_temperature: CalibratedTemperature | None = component()
    motor_temperature: CalibratedTemperature | None = component()


def line_of(unit: Unit) -> tuple[float, float]:
    """Return a unit's gain [1] and its reading at a true value of zero [the sensor's, K for temperatures]."""
    zero = ICE_POINT * (1.0 - unit.gain) if isinstance(unit, CalibratedTemperature) else 0.0
    return unit.gain, unit.offset + zero
