"""The result of an identification: estimates beside the start's values, and what stayed unidentified."""

from dataclasses import dataclass, field
from typing import NamedTuple

from forest_description.config import schema
from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.estimators.calibration import Offset
from forest_ident.estimators.parameter_estimate import Estimate, excitation_for
from forest_ident.measurements.parameter_path import hose_section, part_of, valve_section
from forest_ident.measurements.session import Session
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY, GaussianEstimate
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement import extension_keys
from forest_ident.refinement.refinement_task import INERTIAS, LEAKAGE, VALVE

MASSES = tuple(f"manipulator.{name}" for name in ("head_mass", "boom_mass", "stick_mass", "base_zz"))

UNTOLD = (
    *("elasticity.stiffness", "chambers.head_dead_volume", "chambers.rod_dead_volume"),
    *("chambers.port_volume", "backlash.motor_inertia", "friction.stribeck_speed"),
)
"""Numbers of an axis that no experiment tells apart from others."""


class Refined(NamedTuple):
    """A session with the fit of its refinement."""

    session: Session
    fit: Fit
    free: tuple[str, ...]
    tests: list[ResidualTest]


class Doubt(NamedTuple):
    """Why numbers that a record found are doubtful, and all that may be wrong with them."""

    reason: str
    keys: tuple[str, ...]  # that it found
    told: frozenset[str]  # these, and what it was the first to tell: errors of sensors, too


@dataclass
class Result:
    """Estimates, fits and remarks of an identification; `machine` changes on the way."""

    start: Machine
    machine: Machine
    estimates: dict[str, Estimate] = field(default_factory=dict)
    linear: list[Estimate] = field(default_factory=list)
    refined: list[Refined] = field(default_factory=list)
    calibration: list[Offset] = field(default_factory=list)
    doubts: list[Doubt] = field(default_factory=list)
    held_out: list[Session] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    failed: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Records whose refinement failed, with what it was to find."""
    impossible: list[str] = field(default_factory=list)
    """Keys whose estimates no machine file may hold."""
    stranger: str = ""
    """The only record that is not explained, where the others agree with each other."""
    known: GaussianEstimate = EMPTY
    """Mean and covariance of all, and how stated numbers would move it that are no unknowns."""
    stated: dict[str, float] = field(default_factory=dict)
    """Standard deviation of each stated number."""
    told: dict[str, Estimate] = field(default_factory=dict)
    """Stated numbers as the records have them, by key; moments of inertia as factors on what is stated."""


def table(result: Result) -> list[tuple[Estimate, float | None]]:
    """Return every estimate with the start's value, in the machine file's order."""
    order = list(schema.parameters(Machine))
    keys = sorted(result.estimates, key=order.index)
    return [(result.estimates[key], value_in(result.start, key)) for key in keys]


def told_table(result: Result) -> list[tuple[Estimate, float | None]]:
    """Return the stated numbers as the records have them, each with what was stated."""
    pairs = result.told.items()
    return [(e, 1.0 if key in INERTIAS else value_in(result.start, key)) for key, e in pairs]


def value_in(machine: Machine, key: str) -> float | None:
    """Return a machine's value of a number: its own, that of both directions, or that of all axes."""
    own, axis = key.replace("backward.", ""), key.partition(".")[0]
    shared = own.partition(".")[2] if axis in AXES and ".valve." in key else own
    found = (part_of(machine, candidate) for candidate in (key, own, shared))
    return next((value for value in found if isinstance(value, float)), None)


def unidentified(result: Result) -> list[tuple[str, str]]:
    """Return keys that keep the start's value, and what it takes to identify them.

    A mass that rests confirmed within its error is no estimate, but it counts as identified.
    """
    known = {*result.estimates, *result.told, *(estimate.key for estimate in result.linear)}
    return [(key, excitation_for(key)) for key in _wanted(result.start) if key not in known]


def _wanted(machine: Machine) -> tuple[str, ...]:
    """Return the keys of all that identification is asked for on a machine."""
    valves = dict.fromkeys(valve_section(machine, axis) for axis in range(3))
    keys = ["pump.supply_pressure"]
    keys += [f"{section}.{part}" for section in valves for part in VALVE]
    for axis in range(3):
        section, regime = hose_section(machine, axis), machine.drives[axis].flow_regime
        keys += [f"{section}.{part}" for part in (f"{regime}_resistance", "inertance", "capacitance")]
    extended = extension_keys.of_machine(machine)
    keys += [*LEAKAGE, *(f"{axis}.damping" for axis in AXES), *MASSES, *extended]
    untold = [f"{axis}.{part}" for axis in AXES for part in UNTOLD]
    return (*dict.fromkeys(keys), *(key for key in untold if part_of(machine, key) is not None))
