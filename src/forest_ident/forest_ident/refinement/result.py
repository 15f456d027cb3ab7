"""What an identification found, and how it compares with what was told."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from forest_description.config import schema
from forest_description.machine import Machine, MachineError
from forest_description.types import AXES
from forest_ident.estimators import calibration
from forest_ident.estimators.estimate import Estimate
from forest_ident.measurements.parameter_path import value_of
from forest_ident.measurements.session import Session
from forest_ident.output_error.output_error import Fit
from forest_ident.refinement.linear_estimates import First


class Refined(NamedTuple):
    """A session with what the refinement made of it."""

    session: Session
    fit: Fit
    free: tuple[str, ...]


@dataclass
class Result:
    """Everything that an identification found."""

    start: Machine
    machine: Machine
    estimates: dict[str, Estimate] = field(default_factory=dict)
    linear: list[First] = field(default_factory=list)
    refined: list[Refined] = field(default_factory=list)
    calibration: list[calibration.Offset] = field(default_factory=list)
    held_out: list[Session] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def table(result: Result) -> list[tuple[Estimate, float | None]]:
    """Return every estimate with what the start said of it, in the machine file's order."""
    order = list(schema.parameters(Machine))
    keys = sorted(result.estimates, key=order.index)
    return [(result.estimates[key], told(result.start, key)) for key in keys]


def told(machine: Machine, key: str) -> float | None:
    """Return what a machine said of a number: itself, of both directions, or of all axes."""
    own, axis = key.replace("backward.", ""), key.partition(".")[0]
    shared = own.partition(".")[2] if axis in AXES and ".valve." in key else own
    found = (_there(machine, candidate) for candidate in (key, own, shared))
    return next((value for value in found if value is not None), None)


def _there(machine: Machine, key: str) -> float | None:
    try:
        return value_of(machine, key)
    except MachineError:
        return None
