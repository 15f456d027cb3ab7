"""Records and the calibration that a machine file tells: readings put right, predictions as they would read.

| symbol | name | unit |
|---|---|---|
| y, x | reading, true value | the channel's |
| g, b | gain and reading at zero of the unit, from the file | 1, the channel's |

A reading that stands at an end of its range says no more than that; it is left as it is, since the estimators
take it as censored. What is compared with readings is therefore better turned into a reading (`as_read`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from forest_description.components.sensor_calibration import line_of
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.experiments import test_rig
from forest_ident.measurements.session import Session
from forest_ident.output_error.noise_model import KIND


def lines(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return g and b of every unit whose calibration a machine's file tells. Thesis section 4.3.1."""
    told = machine.sensors.calibration
    units = {name: getattr(told, name, None) for name in KIND}
    return {name: line_of(unit) for name, unit in units.items() if unit is not None}


def corrected(session: Session, machine: Machine) -> Session:
    """Return a session with x = (y - b)/g in place of y, but where a reading stands at its end."""
    readings = dict(session.readings)
    for name, (gain, bias) in lines(machine).items():
        if name in readings:
            y = readings[name]
            stands = np.isin(np.abs(y), _ends(machine, name))
            readings[name] = np.where(stands, y, (y - bias) / gain)
    return dataclasses.replace(session, readings=readings)


def as_read(columns: Mapping[str, Floats], machine: Machine) -> dict[str, Floats]:
    """Return predicted columns as the machine's calibrated units would read them, y = g x + b."""
    told = lines(machine)
    return {name: told[name][0] * x + told[name][1] if name in told else x for name, x in columns.items()}


def _ends(machine: Machine, name: str) -> list[float]:
    """Return where a channel's readings stand when the truth is beyond."""
    part = getattr(test_rig.meters(machine), KIND[name].name, None)
    names = ("full_scale",) if KIND[name].name == "pressure" else ("lowest", "highest")
    found = [float(getattr(part, end)) for end in names if part is not None]
    return [0.0, *found] if KIND[name].name == "pressure" else found
