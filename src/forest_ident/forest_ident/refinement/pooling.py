"""Pool the estimates of a valve's two directions into one where they agree."""

import math

import numpy as np

from forest_description.machine import Machine
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.measurements.parameter_path import SECTIONS, part_of, with_part, with_values
from forest_ident.refinement.refinement_task import VALVE
from forest_ident.refinement.result import Result


def pooled(result: Result) -> Machine:
    """Return the machine with one law for both directions of a valve, where they agree.

    A valve that the start describes by direction stays so.
    """
    machine = result.machine
    for section in SECTIONS:
        pairs = [(f"{section}.{part}", f"{section}.backward.{part}") for part in VALVE]
        if not all(key in result.estimates for pair in pairs for key in pair):
            continue
        both = [(result.estimates[one], result.estimates[two]) for one, two in pairs]
        had_two = part_of(result.start, f"{section}.backward") is not None
        if had_two or any(_differ(one, two) for one, two in both):
            continue
        values = {}
        for one, two in both:
            weights = np.array([one.standard_error, two.standard_error]) ** -2.0
            value = float(np.average([one.value, two.value], weights=weights))
            # Not less than the better one's: both directions share the errors of the same sensors.
            error = min(one.standard_error, two.standard_error)
            result.estimates[one.key] = one._replace(value=value, standard_error=error).checked()
            del result.estimates[two.key]
            values[one.key] = value
        machine = with_values(with_part(machine, f"{section}.backward", None), values)
    return machine


def _differ(one: Estimate, two: Estimate) -> bool:
    """Tell whether two estimates differ by more than four standard errors and a least difference."""
    least = 0.005 if not one.positive else 0.003 * one.value
    return abs(one.value - two.value) > max(4.0 * math.hypot(one.standard_error, two.standard_error), least)
