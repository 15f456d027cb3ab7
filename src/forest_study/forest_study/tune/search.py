"""The search: the least error on the seeds' least favourable plants, among gains that are robust enough.

| symbol | name | unit |
|---|---|---|
| e, e_0 | RMS of an error (`ERRORS`) with the gains, and with the rule's, on the same plant | mm; m/s |
| c | mean of ln(e/e_0) over the errors, for each plant of each row of the matrix | 1 |
| J | mean of the greatest quarter of c (conditional value at risk): a mean lets few plants pay for many | 1 |
| M | greatest 1/(1 + L) of the joints' loops | 1 |

Powell's COBYQA (scipy) minimises J with M bounded: it needs no derivative, as few runs as a quadratic model
asks for, and keeps bounds. It is deterministic: a search that was stopped takes the same way again, by the
runs that are kept.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from forest_control.config.controller_settings import Settings
from forest_description.types import Floats
from forest_study.tune.bench import Bench, Row
from forest_study.tune.gains import BOUNDS, point_of, settings_of
from forest_study.tune.robustness import Opened, allowed, sensitivity

ERRORS = ("cross_track_rms_mm", "governed_rms_mm", "velocity_rms")
WORST = 0.25  # [1] of the plants count: those that the gains favour least
STOPPED = math.log(10.0)  # c of a run that does not end: as if ten times the error
FIRST, LAST = 0.5, 0.02  # [unit of a point] radius of the search: half of a typical gain; a hundredth


class Tried(NamedTuple):
    """Gains that were tried."""

    settings: Settings
    cost: float  # J
    sensitivity: float  # M


def cost(ours: Sequence[Row], rule: Sequence[Row]) -> float:
    """Return J; runs that did not end with the rule's gains are left out."""
    told = sorted(
        _change(one["figures"], other["figures"]) if one["figures"] else STOPPED
        for one, other in zip(ours, rule, strict=True)
        if other["figures"]
    )
    return float(np.mean(told[-math.ceil(WORST * len(told)) :])) if told else math.inf


def _change(ours: Mapping[str, float], rule: Mapping[str, float]) -> float:
    """Return c of a plant from both figures."""
    return sum(math.log(ours[name] / rule[name]) for name in ERRORS) / len(ERRORS)


def search(
    bench: Bench, plants: Sequence[Opened], seeds: range, trials: int, said: Callable[[int, Tried], None]
) -> list[Tried]:
    """Return the gains that were tried, the rule's first.

    Args:
        bench: plants and their runs.
        plants: the joints' plants.
        seeds: of the plants.
        trials: how many gains are tried at most.
        said: is called with the number of trials so far, and the last one.
    """
    first = point_of(bench.machine)
    rule = settings_of(first)
    reference, found = bench.run(rule, seeds), list[Tried]()

    def tried(point: Floats) -> float:
        settings = settings_of(point.tolist())
        one = Tried(settings, cost(bench.run(settings, seeds), reference), sensitivity(plants, settings))
        found.append(one)
        said(len(found), one)
        return one.cost

    def robust(point: Floats) -> float:
        return min(1e3, sensitivity(plants, settings_of(point.tolist())))

    limit = scipy.optimize.NonlinearConstraint(robust, -math.inf, allowed(plants, rule))
    options: dict[str, Any] = {"maxfev": trials, "initial_tr_radius": FIRST, "final_tr_radius": LAST}
    scipy.optimize.minimize(
        tried, np.array(first), method="COBYQA", bounds=BOUNDS, constraints=[limit], options=options
    )
    return found


def best(found: Sequence[Tried], limit: float) -> Tried:
    """Return the gains of the least cost among those that are robust; the first is the rule's, which is."""
    return min((one for one in found if one.sensitivity <= limit), key=lambda one: one.cost)
