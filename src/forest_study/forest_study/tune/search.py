"""The search: the least error on the plants that are hardest, among gains that are robust enough.

| symbol | name | unit |
|---|---|---|
| w, w_0 | mean of the greatest quarter of a row's errors, by the gains and by the rule's | mm; m/s |
| J | mean of ln(w/w_0) over errors and rows of the matrix | 1 |
| M | greatest 1/(1 + L) of the joints' loops | 1 |

w is the error's conditional value at risk: a mean over all plants lets few pay for many. Both sides have
their own greatest quarter. That of the changes plant by plant would be above 0 for any gains, by chance
alone: a plant that slips at another moment errs by some per cent more or less.

Powell's COBYQA (scipy) minimises J with M bounded: it needs no derivative, as few runs as a quadratic model
asks for, and keeps bounds. It is deterministic: a search that was stopped takes the same way again, by the
runs that are kept.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from forest_control.config.controller_settings import Settings
from forest_description.types import Floats
from forest_study.tune.bench import Bench, Row
from forest_study.tune.gains import BOUNDS, point_of, settings_of
from forest_study.tune.robustness import Opened, allowed, sensitivity

ERRORS = ("cross_track_rms_mm", "governed_rms_mm", "velocity_rms")
WORST = 0.25  # [1] of the plants that count
STOPPED = 10.0  # [1] of the rule's error: what a run counts that does not end
FIRST, LAST = 0.5, 0.02  # [unit of a point] radius of the search: half of a typical gain; a hundredth


class Tried(NamedTuple):
    """Gains that were tried."""

    settings: Settings
    cost: float  # J
    sensitivity: float  # M


def cost(ours: Sequence[Row], rule: Sequence[Row]) -> float:
    """Return J; runs that did not end with the rule's gains are left out."""
    told = []
    for name in dict.fromkeys(one["row"] for one in rule):
        both = [(a["figures"], b["figures"]) for a, b in zip(ours, rule, strict=True) if b["row"] == name]
        ended = [(a or {key: STOPPED * b[key] for key in ERRORS}, b) for a, b in both if b]
        if ended:
            told += [
                math.log(_worst(a[key] for a, _ in ended) / _worst(b[key] for _, b in ended))
                for key in ERRORS
            ]
    return float(np.mean(told)) if told else math.inf


def _worst(errors: Iterable[float]) -> float:
    """Return w."""
    rising = sorted(errors)
    return float(np.mean(rising[-math.ceil(WORST * len(rising)) :]))


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
