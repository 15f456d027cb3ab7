"""What a person tells of a crane, with its uncertainty: masses, centres of mass, geometry, areas.

Where no axis sticks they are unknowns of the crane's records, with what is told as prior. Of the variance
S_pp of an estimate p, what was told of a number t with the standard deviation s makes (S_pt/s)^2. Where one
does, none is estimated: each fit tells how its parameters would move with each of them
(`fit_problem.stated_effect`), and the Gaussian estimate carries these moves T from record to record. So an
interval holds what wrong numbers would have made of it:

    variance of a parameter = S_pp + sum over the stated numbers of T_p^2

The uncertainty is the machine file's (`uncertainty`), else the one below. All are halves of 95 % intervals.

| number | default | because |
|---|---|---|
| mass of the stick | 20 % | a drawing leaves out pins, hoses, oil and rotator |
| centre of mass | 0.1 m along, 0.05 m across the link | read off a drawing |
| inertia of boom, stick about the centre of mass | 20 % | the same |
| length | 5 mm | a tape over pins |
| pivot | 3 mm | a rule |
| area | 1 % | a bore read to half a per cent |
| displacement | 2 % | a plate |

Head and boom are estimates like all others: told are only their starts.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.estimators.parameter_estimate import NORMAL_95, Estimate
from forest_ident.measurements.parameter_path import part_of, value_of, with_part, with_values
from forest_ident.measurements.session import SessionError
from forest_ident.output_error.gaussian_estimate import GaussianEstimate
from forest_ident.refinement.refinement_task import INERTIAS, TOLD


class Half(NamedTuple):
    """Half of a 95 % interval: a share of the number, or in its unit."""

    value: float
    relative: bool = False


DEFAULTS = {
    "stick_mass": Half(0.2, relative=True),
    **dict.fromkeys(("boom_x", "stick_x"), Half(0.1)),
    **dict.fromkeys(("boom_y", "stick_y"), Half(0.05)),
    **dict.fromkeys(("base_offset", "boom_length", "stick_length"), Half(0.005)),
    **dict.fromkeys(("pivot_to_base", "pivot_to_rod", "angle_offset"), Half(0.003)),
    **dict.fromkeys(("head_area", "rod_area"), Half(0.01, relative=True)),
    "motor_displacement": Half(0.02, relative=True),
}
INERTIA = 0.2  # of boom's and stick's: half of the 95 % interval


def errors(machine: Machine, stated: Mapping[str, float]) -> dict[str, float]:
    """Return the standard deviation of every stated number, in its unit, by dotted key.

    Args:
        machine: the start.
        stated: half-widths [SI] of the 95 % intervals that its file states, by dotted key.

    Raises:
        SessionError: one is so wide that the number a standard deviation off makes no machine.
    """
    keys = dict.fromkeys(chain(*TOLD.values()))
    found = {key: _half(machine, key, stated) / NORMAL_95 for key in keys}
    for key, error in found.items():
        if key in stated and error > 0.0:
            _demand_machine(machine, key, error)
    return {
        **{key: error for key, error in found.items() if error > 0.0},
        **dict.fromkeys(INERTIAS, INERTIA / NORMAL_95),
    }


def _demand_machine(machine: Machine, key: str, error: float) -> None:
    # Each record is simulated with the number so far off; the load chart has no say in that.
    freed = dataclasses.replace(machine, capacity=None)
    try:
        with_values(freed, {key: value_of(machine, key) + error})
    except MachineError as why:
        raise SessionError(
            f"{key}: its uncertainty is too wide: {error:.4g} more, a standard deviation, makes no machine "
            f"({why}); allowed: a smaller one"
        ) from why


def _half(machine: Machine, key: str, stated: Mapping[str, float]) -> float:
    value = part_of(machine, key)
    if not isinstance(value, float):
        return 0.0
    default = DEFAULTS[key.rpartition(".")[2]]
    return stated.get(key, default.value * (abs(value) if default.relative else 1.0))


def stated_value(machine: Machine, key: str) -> float:
    """Return what is told of a number: the machine's, 1 of a factor."""
    return 1.0 if key in INERTIAS else value_of(machine, key)


def with_inertias(machine: Machine, factors: Mapping[str, float]) -> Machine:
    """Return the machine with the moments of inertia of boom and stick times a factor each."""
    links = machine.manipulator
    now = {name: getattr(links, name) * f for link, f in factors.items() for name in moments(link)}
    return with_part(machine, "manipulator", dataclasses.replace(links, **now)) if now else machine


def moments(link: str) -> tuple[str, ...]:
    """Return the names of a link's moments of inertia in the section `manipulator`."""
    return tuple(f"{link}_{moment}" for moment in ("xx", "yy", "zz", "xy"))


def asked(machine: Machine, found: Mapping[str, float], errors: Mapping[str, float]) -> Floats:
    """Return how far stated numbers are from what is told, in standard deviations; 0 if they were not felt.

    Args:
        machine: as told.
        found: what a fit made of them, by key.
        errors: standard deviations as told, by key.
    """
    away = {key: found[key] - stated_value(machine, key) for key in errors if key in found}
    return np.array([away.get(key, 0.0) / error for key, error in errors.items()])


def shared(e: Estimate, posterior: GaussianEstimate, stated: Mapping[str, float]) -> Estimate:
    """Return an estimate with the share of its variance that stated numbers bring, and which brings most.

    Args:
        e: whose error is that of the posterior.
        posterior: of it and of the stated numbers, where these are unknowns.
        stated: standard deviations as told, by key.
    """
    there = [key for key in stated if key in posterior.names]
    if not there:
        return e
    row = posterior.covariance[posterior.names.index(e.key)]
    moves = [float(row[posterior.names.index(key)]) / stated[key] for key in there]
    share = min(sum(move**2 for move in moves) / float(row[posterior.names.index(e.key)]), 1.0)
    return e._replace(stated=share, most=there[int(np.argmax(np.abs(moves)))])


def with_stated(e: Estimate, known: GaussianEstimate, names: Sequence[str]) -> Estimate:
    """Return an estimate with what stated numbers add to its error, their share, and which adds most.

    Args:
        e: whose error is that of the records.
        known: estimate of all.
        names: of the stated numbers, in the order of the slopes.
    """
    moves = known.moves((e.key,), len(names))[0] * (e.value if e.positive else 1.0)
    added, own = float(moves @ moves), e.standard_error**2
    if added <= 0.0:
        return e
    share = added / (added + own)
    return e._replace(
        standard_error=math.sqrt(added + own), stated=share, most=names[int(np.argmax(np.abs(moves)))]
    )
