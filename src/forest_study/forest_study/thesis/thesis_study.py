"""The evaluation of Thesis section 5.2, run anew: figures 5.4 to 5.9 as numbers, and what lies beside them.

| figure | shows | plant | gains made for |
|---|---|---|---|
| 5.4, 5.5 | tip velocity, position | 2 Hz | 2 Hz |
| 5.6, 5.7 | the same | 0.2 Hz | 0.2 Hz |
| 5.8, 5.9 | the same | 2 Hz -20 %, 2 Hz +20 % | 2 Hz |

Errors are true minus wished. A drift is the mean position error over the last period of the sinusoid in y,
seconds after the steps in x and z are over: what is left when the wish has been carried out. A mismatch is
the plant's natural frequency over that of the gains' design, less one.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from forest_control.operator.joystick_sources import THESIS_DURATION
from forest_description.derived.limits import THESIS_START
from forest_description.geometry.kinematics import Links
from forest_description.machine import load_machine
from forest_study.thesis.thesis_plant import STEP, Motion, at_rest, simulate
from forest_study.thesis.thesis_schemes import SCHEMES, Servo, poles, servo

MACHINE = "c180_thesis"
COORDINATES = "xyz"  # of the tip
SINUSOID = 1.18  # of the wish in y [Hz]
MISMATCHES = tuple(round(-0.5 + 0.1 * k, 1) for k in range(11))
BREAK_EVEN_TOLERANCE = 5e-4  # of a mismatch
Metrics = dict[str, float]


class Case(NamedTuple):
    """A plant and the gains that it is driven with."""

    design: float  # natural frequency that the gains are made for [Hz]
    mismatch: float = 0.0
    shaped: bool = True  # with K*; else the pre-loop gain is one


class Quoted(NamedTuple):
    """A number that the thesis' text reads off its figures."""

    figure: str
    scheme: str
    quantity: str
    thesis: float  # [m/s] or [m]


POLES = {2.0: 16.5, 0.2: 11.5}
"""Closed-loop pole [1/s] by the plant's natural frequency [Hz], as read in docs/explanation/equations.md."""
FIGURES: dict[str, tuple[str, tuple[Case, ...]]] = {
    "5.4": ("velocity", (Case(2.0),)),
    "5.5": ("position", (Case(2.0),)),
    "5.6": ("velocity", (Case(0.2),)),
    "5.7": ("position", (Case(0.2),)),
    "5.8": ("velocity", (Case(2.0, -0.2), Case(2.0, 0.2))),
    "5.9": ("position", (Case(2.0, -0.2), Case(2.0, 0.2))),
}
QUOTED = (
    Quoted("5.4", "c", "velocity_error_y", 0.20),
    Quoted("5.4", "d", "velocity_error_y", 0.40),
    Quoted("5.5", "c", "position_error_y", 0.025),
    Quoted("5.5", "d", "position_error_y", 0.065),
    Quoted("5.6", "c", "velocity_error_y", 0.25),
    Quoted("5.6", "d", "velocity_error_y", 0.50),
    Quoted("5.7", "c", "position_error_y", 0.035),
    Quoted("5.7", "d", "position_error_y", 0.075),
)
"""What the text of Thesis section 5.2.2 quotes, at the figures that show it."""


def gains(case: Case) -> Servo:
    """Return the servo gains of a case."""
    made = servo(2.0 * math.pi * case.design, POLES[case.design])
    return made if case.shaped else made._replace(pre_loop_gain=1.0)


@lru_cache(maxsize=512)
def motion(scheme: str, case: Case) -> Motion:
    """Return a scheme's motion in a case: the thesis' input, 10 s from (5.5, 0, 1) m."""
    links = _links()
    made = gains(case)
    natural_frequency = made.natural_frequency * (1.0 + case.mismatch)
    start = at_rest(THESIS_START, links)
    return simulate(SCHEMES[scheme](made, links), natural_frequency, start, links, THESIS_DURATION)


@lru_cache(maxsize=1)
def _links() -> Links:
    return load_machine(MACHINE).manipulator.links


def metrics(run: Motion) -> Metrics:
    """Return a run's peak errors and drifts by axis [m/s], [m]."""
    velocity = np.abs(run.velocity_error).max(axis=0)
    position = np.abs(run.position_error).max(axis=0)
    drift = run.position_error[-round(1.0 / (SINUSOID * STEP)) :].mean(axis=0)
    named = {"velocity_error": velocity, "position_error": position, "drift": drift}
    return {
        f"{name}_{axis}": float(values[i])
        for name, values in named.items()
        for i, axis in enumerate(COORDINATES)
    }


def largest_position_error(scheme: str, case: Case, axes: str = COORDINATES) -> float:
    """Return the largest position error [m] on any of some axes."""
    found = metrics(motion(scheme, case))
    return max(found[f"position_error_{axis}"] for axis in axes)


def figure(number: str) -> dict[str, Any]:
    """Return a figure's numbers: by scheme, of several cases the worst with its sign, and each case alone.

    Thesis section 5.2.1, 5.2.2, 5.2.3.
    """
    shows, cases = FIGURES[number]
    by_case = {case: {name: metrics(motion(name, case)) for name in "cd"} for case in cases}
    result: dict[str, Any] = {
        "shows": shows,
        "natural_frequency_hz": cases[0].design,
        "mismatches": [case.mismatch for case in cases],
    }
    for name in "cd":
        quantities = by_case[cases[0]][name]
        result[name] = {q: max((by_case[case][name][q] for case in cases), key=abs) for q in quantities}
    if len(cases) > 1:
        result["cases"] = {f"{case.mismatch:+.0%}": by_case[case] for case in cases}
    return result


def break_even(axes: str = COORDINATES) -> list[float]:
    """Return the mismatches of the 2 Hz plant at which (c) and (d) have one largest position error.

    By Brent's method between the sweep's neighbours where the difference changes its sign. Beyond them scheme
    (d) is the better. Thesis section 5.2.3.

    Args:
        axes: those that count, the worst of them.
    """

    def difference(mismatch: float) -> float:
        case = Case(2.0, mismatch)
        return largest_position_error("c", case, axes) - largest_position_error("d", case, axes)

    signs = [difference(mismatch) > 0.0 for mismatch in MISMATCHES]
    return [
        float(scipy.optimize.brentq(difference, MISMATCHES[k], MISMATCHES[k + 1], xtol=BREAK_EVEN_TOLERANCE))
        for k in range(len(signs) - 1)
        if signs[k] != signs[k + 1]
    ]


def robustness(scheme: str) -> dict[str, float]:
    """Return the largest position error [m] on any axis at no mismatch and at the worse of +-20 %."""
    nominal = largest_position_error(scheme, Case(2.0))
    wrong = max(largest_position_error(scheme, Case(2.0, mismatch)) for mismatch in (-0.2, 0.2))
    return {"nominal": nominal, "at_20_percent": wrong, "ratio": wrong / nominal}


def sweep() -> list[dict[str, Any]]:
    """Return peak errors and drifts of all schemes over the 2 Hz plant's mismatch."""
    kept = ("velocity_error_y", "position_error_y", "drift_x", "drift_z")
    rows: list[dict[str, Any]] = []
    for mismatch in MISMATCHES:
        row: dict[str, Any] = {"mismatch": mismatch}
        for name in SCHEMES:
            found = metrics(motion(name, Case(2.0, mismatch)))
            row[name] = {quantity: found[quantity] for quantity in kept}
            row[name]["position_error"] = max(found[f"position_error_{axis}"] for axis in COORDINATES)
        rows.append(row)
    return rows


def study() -> dict[str, Any]:
    """Return everything that `study.json` holds; SI units, shares as numbers. Thesis section 5.2."""
    figures = {number: figure(number) for number in FIGURES}
    quoted = [
        {**q._asdict(), "here": here, "deviation": here / q.thesis - 1.0}
        for q in QUOTED
        for here in [figures[q.figure][q.scheme][q.quantity]]
    ]
    return {
        "figures": figures,
        "quoted": quoted,
        "worst_deviation": max(abs(row["deviation"]) for row in quoted),
        "schemes": {
            f"{design:g} Hz": {name: metrics(motion(name, Case(design))) for name in SCHEMES}
            for design in POLES
        },
        "servos": {f"{design:g} Hz": _servo(design) for design in POLES},
        "robustness": {name: robustness(name) for name in SCHEMES},
        "break_even_mismatch": {"any_axis": break_even(), **{axis: break_even(axis) for axis in "xz"}},
        "without_pre_loop_gain": {name: metrics(motion(name, Case(2.0, shaped=False))) for name in "ac"},
        "mismatch_sweep": sweep(),
        "machine": MACHINE,
        "start_tip": list(THESIS_START),
        "duration": THESIS_DURATION,
        "step": STEP,
    }


def _servo(design: float) -> dict[str, Any]:
    """Return gains and closed-loop poles [1/s] of a design, the poles by the plant's mismatch."""
    made = gains(Case(design))
    closed = {f"{m:+.0%}": poles(made, made.natural_frequency * (1.0 + m)) for m in (-0.2, 0.0, 0.2)}
    return {**made._asdict(), "poles": closed}
