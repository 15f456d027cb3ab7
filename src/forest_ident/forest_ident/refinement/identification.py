"""From sessions to a machine: every estimator that they support, then the refinement, then the verdict.

Order: calibration, the thesis' linear estimates (which start the refinement), the refinement experiment by
experiment with one belief. Sessions named "validation" or "motion" are held out.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from forest_description.config import schema
from forest_description.machine import Machine
from forest_ident.estimators import calibration
from forest_ident.estimators.estimate import Estimate, is_loose, judged, motion_for
from forest_ident.experiments import experiments
from forest_ident.measurements.parameter_path import value_of, with_directions, with_values
from forest_ident.measurements.session import Session
from forest_ident.output_error import noise_model
from forest_ident.output_error.gaussian_estimate import NOTHING, Belief
from forest_ident.output_error.output_error import Fit
from forest_ident.refinement import (
    apply_calibration,
    data_quality,
    linear_estimates,
    mass_check,
    pooling,
    refinement,
)
from forest_ident.refinement.linear_estimates import First
from forest_ident.refinement.result import Refined, Result

HELD_OUT = ("validation", "motion")
OWN_VALVE = (4.0, 0.01)  # standard errors and volts by which a valve must differ to be told on its own


Progress = Callable[[str, float], None]


def identify(
    start: Machine,
    sessions: Sequence[Session],
    progress: Progress = lambda _text, _share: None,
    refine: bool = True,
) -> Result:
    """Return what the sessions tell of the machine.

    Args:
        start: the machine as told until now.
        sessions: in any order.
        progress: called with what is being done and the share that is done.
        refine: whether the simulator refines what the linear estimators found.

    Raises:
        SessionError: a session does not hold its experiment.
    """
    order = experiments.names(start)
    known = [s for s in sessions if s.name in order and s.name not in HELD_OUT]
    known.sort(key=lambda s: order.index(s.name))
    result = Result(start, _prepared(start, known))
    result.held_out = [s for s in sessions if s.name in HELD_OUT]
    _calibrate(result, known)
    result.remarks += [data_quality.cut(session) for session in known if not session.whole]
    for session in known:
        progress(f"{session.name}: linear estimates", 0.0)
        with data_quality.evaluated(session):
            _take_linear(result, session)
    belief = _believed([*_told_offsets(start, known), *result.calibration])
    work = [s for s in known if refine and refinement.task(result.machine, s) is not None]
    for place, session in enumerate(work):
        share, count = place / len(work), [0]

        def told(session: Session = session, share: float = share, count: list[int] = count) -> None:
            count[0] += 1
            part = min(count[0] / 70.0, 1.0) / len(work)
            progress(f"{session.name}: refinement, simulation {count[0]}", share + part)

        with data_quality.evaluated(session):
            belief = _refine(result, session, belief, told)
    progress("done", 1.0)
    _conclude(result)
    return result


def _prepared(start: Machine, sessions: Sequence[Session]) -> Machine:
    """Return the start as the refinement speaks of it: measured hoses, valves told by direction."""
    machine = start
    if not any(session.name != "calibration" for session in sessions):
        return machine
    for axis in range(3):
        machine = linear_estimates.with_measured_hose(machine, axis)
        machine = with_directions(machine, refinement.valve_section(machine, axis))
    return with_directions(machine, "valve")


def _calibrate(result: Result, sessions: Sequence[Session]) -> None:
    floor = linear_estimates.floor(result.start)
    for session in sessions:
        if session.name == "calibration":
            result.calibration += calibration.calibrate(result.start, session)
        if session.name == "valve":
            ratio = calibration.meter_gain(session, floor)
            result.calibration += [ratio] if ratio is not None else []
    if any(session.is_exact for session in sessions):
        return
    sensors = dataclasses.replace(
        result.machine.sensors, calibration=calibration.told(result.start, result.calibration)
    )
    result.machine = dataclasses.replace(result.machine, sensors=sensors)


def _believed(offsets: Sequence[calibration.Offset]) -> Belief:
    """Return the transducers' offsets as what is known before the first fit; the last of a unit counts."""
    units = {o.channel: o for o in offsets if o.unit == "Pa" and math.isfinite(o.offset_error)}
    found = list(units.values())
    if not found:
        return NOTHING
    names = tuple(f"{o.channel}.b" for o in found)
    spread = np.array([max(o.offset_error, 1.0) for o in found])
    return Belief(names, np.array([o.offset for o in found]), np.diag(spread**2))


def _told_offsets(start: Machine, sessions: Sequence[Session]) -> list[calibration.Offset]:
    """Return the transducers' offsets that the start's file tells, known to a sample's noise."""
    part = start.sensors.pressure
    if part is None or any(s.is_exact for s in sessions):
        return []
    return [
        calibration.Offset(
            channel=name,
            offset=bias,
            offset_error=part.noise or part.full_scale * (part.accuracy or 1e-4),
            gain=gain,
            gain_error=0.0,
            unit="Pa",
        )
        for name, (gain, bias) in apply_calibration.lines(start).items()
        if noise_model.KIND[name].unit == "Pa"
    ]


def _take_linear(result: Result, session: Session) -> None:
    """Estimate what a session tells by itself, and go on from there."""
    if session.name == "gravity":
        mass_check.weigh(result, session)
        return
    if not session.is_exact:
        session = apply_calibration.corrected(session, result.machine)
    found = linear_estimates.estimates(result.machine, session)
    result.linear += found
    usable = {f.key: f.value for f in found if f.main and _usable(f) and not _is_loose(f)}
    result.machine = with_values(result.machine, usable)


def _usable(first: First) -> bool:
    return math.isfinite(first.value) and first.value > 0.0


def _is_loose(first: First) -> bool:
    return is_loose(first.value, first.error, not first.key.endswith("deadband_voltage"))


def _refine(result: Result, session: Session, belief: Belief, progress: Callable[[], None]) -> Belief:
    done = refinement.refine(result.machine, session, belief, progress)
    if done is None:
        return belief
    work, fit = done
    result.refined.append(Refined(session, fit, work.free))
    result.remarks += data_quality.unexplained(result.start, session, fit)
    if session.name.startswith("deadband_"):
        return _compare_valve(result, session, belief, fit)
    for key in work.free:
        _note(result, key, fit)
    _follow(result, fit.belief)
    return fit.belief


def _compare_valve(result: Result, session: Session, belief: Belief, fit: Fit) -> Belief:
    """Tell an axis' valve on its own if it is another one; else leave it with the one that all share."""
    axis = session.name.partition("_")[2]
    own = f"{axis}.valve"
    shared = own if getattr(result.start, axis).valve is not None else "valve"
    keys = ("deadband_voltage", "backward.deadband_voltage")
    differs, joint = False, with_directions(result.machine, shared)
    for key in keys:
        away = fit.values[f"{own}.{key}"] - value_of(joint, f"{shared}.{key}")
        error = fit.errors[f"{own}.{key}"]
        differs |= abs(away) > OWN_VALVE[0] * error and abs(away) > OWN_VALVE[1]
        result.linear.append(
            First(
                key=f"{own}.{key}",
                value=fit.values[f"{own}.{key}"],
                error=error,
                condition=fit.condition,
                method="joint motion",
                main=False,
            )
        )
    if not differs and shared in {name.rpartition(".")[0] for name in belief.names}:
        return belief
    if shared != own and not differs:
        own_machine = result.machine
    else:
        own_machine = with_directions(result.machine, own)
    result.machine = own_machine
    if shared == own or differs:
        for key in keys:
            _note(result, f"{own}.{key}", fit)
        _follow(result, fit.belief)
        return fit.belief
    return belief


def _note(result: Result, key: str, fit: Fit) -> None:
    """Enter an estimate; its value is brought up to date in the end."""
    unit = schema.parameters(Machine)[key].unit
    positive = not key.endswith("deadband_voltage")
    estimate = Estimate(
        key=key,
        value=fit.values[key],
        standard_error=fit.errors[key],
        unit=unit,
        condition=fit.condition,
        method="output error",
        positive=positive,
    )
    result.estimates[key] = judged(estimate)


def _follow(result: Result, belief: Belief) -> None:
    """Bring machine and estimates to what is believed now."""
    values = {}
    for key in result.estimates:
        if key in belief.names:
            mean, error = belief.of(key)
            estimate = result.estimates[key]
            value = math.exp(mean) if estimate.positive else mean
            error = error * value if estimate.positive else error
            values[key] = value
            result.estimates[key] = judged(estimate._replace(value=value, standard_error=error))
    result.machine = with_values(result.machine, values)


def _conclude(result: Result) -> None:
    """Add what only a linear estimator told."""
    for first in result.linear:
        if not first.main or first.key in result.estimates:
            continue
        if not _usable(first):
            result.remarks.append(
                f"the records hold nothing of {first.key}; it takes {motion_for(first.key)}"
            )
        else:
            unit = schema.parameters(Machine)[first.key].unit
            result.estimates[first.key] = judged(
                Estimate(
                    key=first.key,
                    value=first.value,
                    standard_error=first.error,
                    unit=unit,
                    condition=first.condition,
                    method=first.method,
                )
            )
    result.machine = pooling.pooled(result)
