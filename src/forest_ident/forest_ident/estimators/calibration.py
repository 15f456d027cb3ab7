"""Calibration of the sensors before the first experiment. Thesis section 4.3.1.

| sensor | against | estimates |
|---|---|---|
| pressure transducers | atmosphere: pump off, lines vented | offset |
| flow meters | each other, in series on the valve's rig | gain of the second over the first |
| thermocouples | melting ice, then boiling water | offset and gain |

A gauge transducer shows nothing below zero. With an offset below zero it reads zero but for the noise that
reaches above. Readings of zero are censored: they count with the probability of a value below zero.

With the calibration in the machine file, readings are corrected, x = (y - b)/g with gain g and offset b. A
reading at an end of its range is left as it is: the estimators take it as censored. So a prediction that is
compared with readings is better turned into a reading (`as_read`).
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.sensors.sensor_calibration import (
    CalibratedFlow,
    CalibratedPressure,
    CalibratedTemperature,
    Calibration,
    line_of,
)
from forest_description.types import Floats
from forest_ident.estimators.parameter_estimate import NORMAL_95
from forest_ident.experiments import rigs
from forest_ident.measurements.readings import read
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error.fit_problem import Unknown
from forest_ident.output_error.noise_model import KIND, channel
from forest_ident.output_error.output_error import fit
from forest_sim.sensors.sensor_suite import Suite

NAME = "calibration"
NEAR = 25.0  # [K] a thermocouple may be off; further, it is not in that bath
VENTED = 1e6  # [Pa] a transducer may be off; further, its line is not open to the air
ICE, BOILING = 273.15, 373.15  # [K], at 1013 hPa
ALIKE = (0.5, 2.0)  # gains of a flow meter that a machine file allows
EACH, PERIOD = 20.0, 0.005  # [s] in ice, and in boiling water; of the samples
SETUP = (
    "Pump off, all lines open to the air. The thermocouples in melting ice for 20 s, then in boiling water "
    "for 20 s (write the seconds in ice under ice_until). The flow meters are compared on the valve's rig."
)
UNITS = {"Pa": CalibratedPressure, "m3/s": CalibratedFlow, "K": CalibratedTemperature}


class Offset(NamedTuple):
    """A sensor's offset and gain with their standard errors; an error of 0: not estimated."""

    channel: str
    offset: float
    offset_error: float
    unit: str
    gain: float = 1.0
    gain_error: float = 0.0

    def formatted(self) -> tuple[str, str]:
        """Return offset and gain with their 95 % intervals; "" for one that was not estimated."""
        offset = f"{self.offset:.4g} ± {NORMAL_95 * self.offset_error:.2g} {self.unit}"
        gain = f"{self.gain:.6f} ± {NORMAL_95 * self.gain_error:.1g}"
        return offset if self.offset_error > 0.0 else "", gain if self.gain_error > 0.0 else ""


def updated(machine: Machine, offsets: Sequence[Offset]) -> Calibration | None:
    """Return a machine's calibration with new offsets in place of its own. Thesis section 4.3.1.

    A unit whose offset stayed unknown, because it read zero all the time, keeps its own.
    """
    found: dict[str, Any] = {
        o.channel: UNITS[o.unit](o.offset, o.gain) for o in offsets if math.isfinite(o.offset_error)
    }
    was = machine.sensors.calibration
    if not found:
        return was
    names = [field.name for field in dataclasses.fields(Calibration)]
    return Calibration(**{name: found.get(name, getattr(was, name, None)) for name in names})


def simulated(suite: Suite) -> Session:
    """Return the record of a calibration of a simulated machine's sensors."""
    count = round(2.0 * EACH / PERIOD)
    time = PERIOD * np.arange(count, dtype=np.float64)
    true = {name: np.zeros(count) for name, kind in KIND.items() if kind.name == "pressure"}
    bath = np.where(time < EACH, ICE, BOILING)
    true |= {name: bath for name, kind in KIND.items() if kind.name == "thermocouple"}
    readings = {
        name: y for name, y in read(true, suite, PERIOD, "calibration").items() if np.isfinite(y).all()
    }
    return Session(
        name="calibration",
        time=time,
        voltages=np.zeros((count, 3)),
        readings=readings,
        metadata={"ice_until": EACH},
    )


def calibrate(machine: Machine, session: Session) -> list[Offset]:
    """Return offset and gain of every sensor in a calibration's record. Thesis section 4.3.1.

    Raises:
        SessionError: a transducer was under pressure, or a thermocouple not in its bath.
    """
    found = []
    for name in sorted(session.readings):
        if KIND[name].name == "pressure":
            found.append(_transducer(machine, session, name))
        elif KIND[name].name == "thermocouple":
            found.append(_thermocouple(session, name))
    return found


def _transducer(machine: Machine, session: Session, name: str) -> Offset:
    """Return a pressure transducer's offset, by maximum likelihood with its zero as censoring."""
    y = session.column(name)
    if not abs(float(np.mean(y))) < VENTED:
        raise SessionError(
            f"calibration: {name} reads {1e-6 * float(np.mean(y)):.2f} MPa; allowed: less than "
            f"{1e-6 * VENTED:g} MPa, with the pump off and the lines open to the air"
        )
    if np.ptp(y) == 0.0:
        return Offset(
            channel=name, offset=float(y[0]), offset_error=0.0 if y[0] > 0.0 else math.inf, unit="Pa"
        )
    noise = channel(machine, session, name)._replace(offset=0.0)
    start = float(np.mean(y))

    def model(values: Mapping[str, float]) -> dict[str, Floats]:
        return {name: np.full(len(y), values["offset"])}

    unknown = Unknown("offset", start, positive=False, difference=1.0)
    result = fit(model, {name: y}, [noise], [unknown])
    return Offset(
        channel=name, offset=result.values["offset"], offset_error=result.errors["offset"], unit="Pa"
    )


def _thermocouple(session: Session, name: str) -> Offset:
    """Return a thermocouple's offset at the ice point, and its gain between the two baths."""
    y, change = session.column(name), session.metadata.get("ice_until", EACH)
    boiling = session.metadata.get("boiling_from", change)
    ice, water = y[session.time < change - 1.0], y[session.time > boiling + 1.0]
    for bath, rows, point in (("ice", ice, ICE), ("boiling water", water, BOILING)):
        mean = float(np.mean(rows)) if len(rows) > 1 else math.nan
        if not abs(mean - point) < NEAR:
            raise SessionError(
                f"calibration: {name} reads {mean:.1f} K in {bath}; allowed: {point:g} K within {NEAR:g} K, "
                "with ice until ice_until and boiling water from boiling_from in experiment.yaml"
            )
    errors = [float(np.std(part)) / math.sqrt(len(part)) for part in (ice, water)]
    gain = float(np.mean(water) - np.mean(ice)) / (BOILING - ICE)
    return Offset(
        channel=name,
        offset=float(np.mean(ice)) - ICE,
        offset_error=errors[0],
        gain=gain,
        gain_error=math.hypot(*errors) / (BOILING - ICE),
        unit="K",
    )


def meter_gain(session: Session, floor: float) -> Offset | None:
    """Return the gain of the second flow meter over the first, from a rig that has them in series.

    Raises:
        SessionError: they have nothing in common.
    """
    if not session.has("swing_flow", "stick_flow"):
        return None
    one, two = session.column("swing_flow"), session.column("stick_flow")
    calm = np.concatenate([[False], np.abs(np.diff(one)) < 0.002 * np.max(np.abs(one))])
    seen = calm & (np.abs(one) > 3.0 * floor) & (np.abs(two) > 3.0 * floor)
    if seen.sum() < 10:
        return None
    x, y = one[seen], two[seen]
    gain = float(x @ y / (x @ x))
    if not ALIKE[0] <= gain <= ALIKE[1]:
        raise SessionError(
            f"{session.name}: stick_flow reads {gain:.3g} times swing_flow, which is in series with it; "
            f"allowed: {ALIKE[0]:g} to {ALIKE[1]:g}: does a meter stand still, or count in another unit?"
        )
    error = float(np.std(y - gain * x) / math.sqrt(x @ x))
    return Offset(
        channel="stick_flow", offset=0.0, offset_error=0.0, gain=gain, gain_error=error, unit="m3/s"
    )


def disagreement(machine: Machine, gain: Offset) -> str:
    """Return by how much two flow meters differ, if their accuracy in the file does not allow it; else ""."""
    meter, apart = rigs.meters(machine).flow_meter, abs(gain.gain - 1.0)
    told = (meter.accuracy or 0.0) if meter else 0.0
    if apart <= 2.0 * told + NORMAL_95 * gain.gain_error:
        return ""
    return f"the flow meters differ by {100.0 * apart:.2g} %, their file tells {100.0 * told:.2g} % of each"


def lines(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return (g, b) of every unit that the machine file has a calibration of. Thesis section 4.3.1."""
    known = machine.sensors.calibration
    units = {name: getattr(known, name, None) for name in KIND}
    return {name: line_of(unit) for name, unit in units.items() if unit is not None}


def corrected(session: Session, machine: Machine) -> Session:
    """Return a session with x = (y - b)/g in place of y, but for readings at an end of their range.

    Exact sensors need no correction.
    """
    if session.is_exact:
        return session
    readings = dict(session.readings)
    for name, (gain, bias) in lines(machine).items():
        if name in readings:
            y = readings[name]
            at_end = np.isin(np.abs(y), _ends(machine, name))
            readings[name] = np.where(at_end, y, (y - bias) / gain)
    return dataclasses.replace(session, readings=readings)


def as_read(columns: Mapping[str, Floats], machine: Machine) -> dict[str, Floats]:
    """Return predicted columns as the machine's calibrated units would read them, y = g x + b."""
    known = lines(machine)
    return {name: known[name][0] * x + known[name][1] if name in known else x for name, x in columns.items()}


def _ends(machine: Machine, name: str) -> list[float]:
    """Return the ends of a channel's range."""
    part = getattr(rigs.meters(machine), KIND[name].name)
    return [0.0, part.full_scale] if KIND[name].name == "pressure" else [part.lowest, part.highest]
