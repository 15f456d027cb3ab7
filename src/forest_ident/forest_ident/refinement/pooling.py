"""Valves told once where both directions agree: two estimates of one number become one."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.estimators.estimate import Estimate, judged
from forest_ident.measurements.parameter_path import with_values
from forest_ident.refinement.result import Result

LAW = ("deadband_voltage", "minimum_resistance")


def pooled(result: Result) -> Machine:
    """Return the machine with valves told once where both directions agree and the start tells them once."""
    machine = result.machine
    for section in ("valve", *(f"{axis}.valve" for axis in AXES)):
        pairs = [(f"{section}.{part}", f"{section}.backward.{part}") for part in LAW]
        if not all(key in result.estimates for pair in pairs for key in pair):
            continue
        both = [(result.estimates[one], result.estimates[two]) for one, two in pairs]
        if any(_apart(one, two) for one, two in both) or _told_twice(result.start, section):
            continue
        values = {}
        for one, two in both:
            weights = np.array([one.standard_error, two.standard_error]) ** -2.0
            value = float(np.average([one.value, two.value], weights=weights))
            # Not less than the better one's: both directions share the errors of the same sensors.
            error = min(one.standard_error, two.standard_error)
            result.estimates[one.key] = judged(one._replace(value=value, standard_error=error))
            del result.estimates[two.key]
            values[one.key] = value
        machine = with_values(_once(machine, section), values)
    return machine


def _apart(one: Estimate, two: Estimate) -> bool:
    least = 0.005 if not one.positive else 0.003 * one.value
    return abs(one.value - two.value) > max(4.0 * math.hypot(one.standard_error, two.standard_error), least)


def _told_twice(machine: Machine, section: str) -> bool:
    axis, _, _ = section.rpartition(".")
    valve = getattr(machine, axis).valve if axis else machine.valve
    return valve is not None and valve.backward is not None


def _once(machine: Machine, section: str) -> Machine:
    axis, _, _ = section.rpartition(".")
    if not axis:
        return dataclasses.replace(machine, valve=dataclasses.replace(machine.valve, backward=None))
    drive = getattr(machine, axis)
    drive = dataclasses.replace(drive, valve=dataclasses.replace(drive.valve, backward=None))
    return dataclasses.replace(machine, **{axis: drive})
