"""Leave out estimates that no machine file may hold: one impossible number must not cost all others."""

import dataclasses
import math
from collections.abc import Mapping

from forest_description.config import schema
from forest_description.config.parameter import MachineError, Parameter, parameter_of
from forest_description.machine import Machine
from forest_ident.estimators.parameter_estimate import excitation_for
from forest_ident.measurements.parameter_path import part_of, with_values
from forest_ident.refinement.result import Result, value_in


def applied(result: Result, values: Mapping[str, float]) -> Machine:
    """Return the result's machine with some numbers; what is impossible is left out, with a remark.

    Args:
        result: whose estimates and Gaussian estimate lose what is impossible.
        values: in SI, by dotted key.
    """
    machine = result.machine
    allowed = {key: _allowed(machine, key) for key in values}
    possible = {key: v for key, v in values.items() if allowed[key].low <= v <= allowed[key].high}
    for key in values.keys() - possible.keys():
        machine = _without(result, machine, key, values[key], f"outside {allowed[key].range}")
    try:
        return with_values(machine, possible)
    except MachineError:  # together they contradict each other: those that do not come first
        for key, value in possible.items():
            machine = _with(result, machine, key, value)
    return machine


def _allowed(machine: Machine, key: str) -> Parameter:
    """Return what a number may be in the sort of component that the machine has there."""
    section, _, name = key.rpartition(".")
    part = part_of(machine, section)
    fields = dataclasses.fields(part) if dataclasses.is_dataclass(part) else ()
    own = next((parameter_of(field) for field in fields if field.name == name), None)
    return own or schema.parameters(Machine)[key]


def _with(result: Result, machine: Machine, key: str, value: float) -> Machine:
    try:
        return with_values(machine, {key: value})
    except MachineError as error:
        return _without(result, machine, key, value, str(error))


def _without(result: Result, machine: Machine, key: str, value: float, why: str) -> Machine:
    """Return the machine with a number as stated before."""
    before = value_in(result.start, key)
    kept = "left out" if before is None else f"{before:.5g} is kept as stated"
    number = f"{value:.5g}" if math.isfinite(value) else "no number"
    remark = f"{key}: found {number}, which is impossible ({why}); {kept}; it takes {excitation_for(key)}"
    result.remarks.append(remark)
    result.estimates.pop(key, None)
    result.told.pop(key, None)
    result.impossible.append(key)
    if key in result.known.names:
        result.known = result.known.without(key)
    return machine if before is None else with_values(machine, {key: before})
