"""From sessions to a machine: calibration, linear estimates, refinement, and the choice of what is kept.

Order: calibration, the thesis' linear estimates (from which the refinement starts), the refinement experiment
by experiment with one Gaussian estimate. Sessions named "validation" or "motion" are held out.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.estimators import calibration, linkage_estimate
from forest_ident.estimators.parameter_estimate import (
    Estimate,
    excitation_for,
    is_loose,
    is_positive,
    unit_of,
)
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.parameter_path import (
    part_of,
    value_of,
    valve_section,
    with_directions,
    with_part,
    with_values,
)
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY, GaussianEstimate
from forest_ident.refinement import (
    data_quality,
    experiment_check,
    linear_estimates,
    pooling,
    possible_numbers,
    refinement,
    stated_numbers,
)
from forest_ident.refinement.refinement_task import INERTIAS, task
from forest_ident.refinement.result import Doubt, Refined, Result
from forest_ident.refinement.workload import Workload

HELD_OUT = ("validation", "motion")
# Standard errors and volts by which an axis' valve must differ to get its own section.
OWN_VALVE = (4.0, 0.01)

ALIKE = 1.05  # of a standard error: a record that is made for a number, and knows it as well, tells it
FLOW_GAINS = frozenset({"swing_flow.g", "stick_flow.g"})
OWED = 0.1  # share of a variance: more of it from what is doubtful is a doubt

Progress = Callable[[str, float], None]


def identify(
    start: Machine,
    sessions: Sequence[Session],
    progress: Progress = lambda _text, _share: None,
    refine: bool = True,
    stated: Mapping[str, float] = MappingProxyType({}),
) -> Result:
    """Return the machine that the sessions identify.

    Args:
        start: the machine as known until then.
        sessions: in any order.
        progress: called with what is being done and the share that is done.
        refine: whether the simulator refines the linear estimates.
        stated: half-widths [SI] of the 95 % intervals that the start's file states, by dotted key.

    Raises:
        SessionError: a session does not hold its experiment.
    """
    order = experiment_plan.names(start)
    used = [s for s in sessions if s.name in order and s.name not in HELD_OUT]
    used.sort(key=lambda s: order.index(s.name))
    result = Result(start, _prepared(start, used))
    result.held_out = [s for s in sessions if s.name in HELD_OUT]
    _calibrate(result, used)
    result.remarks += [data_quality.cut_off(session) for session in used if not session.whole]
    for session in used:
        experiment_check.demand(start, session)
    for session in result.held_out:
        experiment_check.demand_machine(start, session)
    result.stated = _measured_linkages(result, used, stated_numbers.errors(start, stated))
    for session in used:
        progress(f"{session.name}: linear estimates", 0.0)
        with data_quality.evaluated(session):
            _estimate_linearly(result, session)
    result.known = _of_offsets([*_offsets_of_file(start, used), *result.calibration])
    if refine:
        _refine_all(result, used, progress)
    progress("done", 1.0)
    result.stranger = data_quality.stranger({r.session.name: r.tests for r in result.refined})
    _conclude(result)
    return result


def _refine_all(result: Result, used: Sequence[Session], progress: Progress) -> None:
    """Refine by one session after the other; one that cannot be does not lose what the others told."""
    work = [s for s in used if task(result.machine, s) is not None]
    workload = Workload(result.machine, work)
    for place, session in enumerate(work):

        def simulated(session: Session = session, place: int = place) -> None:
            count = workload.count(place)
            progress(f"{session.name}: refinement, simulation {count}", workload.share(place))

        try:
            with data_quality.evaluated(session):
                _refine(result, session, simulated)
        except SessionError as error:
            result.remarks.append(f"{error}; its linear estimates stay")
            wanted = task(result.machine, session)
            result.failed[session.name] = wanted.free if wanted else ()


def _prepared(start: Machine, sessions: Sequence[Session]) -> Machine:
    """Return the start with the sections that are estimated: measured hoses, valves by direction."""
    machine = start
    if all(session.name == "calibration" for session in sessions):
        return machine
    for axis in range(3):
        machine = linear_estimates.with_measured_hose(machine, axis)
        machine = with_directions(machine, valve_section(machine, axis))
    return with_directions(machine, "valve")


def _calibrate(result: Result, sessions: Sequence[Session]) -> None:
    for session in sessions:
        if session.name == "calibration":
            result.calibration += calibration.calibrate(result.start, session)
        if session.name == "valve":
            gain = calibration.meter_gain(session, linear_estimates.floor(result.start))
            if gain is not None:
                result.calibration.append(gain)
                if why := calibration.disagreement(result.start, gain):
                    result.doubts.append(Doubt(why, (), FLOW_GAINS))
    if not any(session.is_exact for session in sessions):
        updated = calibration.updated(result.start, result.calibration)
        result.machine = with_part(result.machine, "sensors.calibration", updated)


def _measured_linkages(
    result: Result, used: Sequence[Session], stated: Mapping[str, float]
) -> dict[str, float]:
    """Set the linkages to what lengths over angles tell; return the errors of stated numbers with theirs.

    A linkage that a person has told more closely stays, as does one whose estimate is no linkage.
    """
    errors = dict(stated)
    for axis in AXES[1:]:
        found = [e for e in linkage_estimate.pivots(result.start, used) if e.key.startswith(axis)]
        closer = {e.key: e.standard_error for e in found if e.standard_error < stated.get(e.key, 0.0)}
        if not found or len(closer) < len(found):
            continue
        pivots = {e.key.partition(".")[2]: e.value for e in found}
        try:
            drive = dataclasses.replace(getattr(result.machine, axis), **pivots)
        except MachineError as error:
            result.remarks.append(
                f"{axis}: its linkage stays as stated; lengths over angles tell another: {error}"
            )
            continue
        result.machine = with_part(result.machine, axis, drive)
        result.linear += found
        errors |= closer
    return errors


def _of_offsets(offsets: Sequence[calibration.Offset]) -> GaussianEstimate:
    """Return the transducers' offsets as prior of the first fit; the last of a unit counts."""
    units = {o.channel: o for o in offsets if o.unit == "Pa" and math.isfinite(o.offset_error)}
    found = list(units.values())
    if not found:
        return EMPTY
    names = tuple(f"{o.channel}.b" for o in found)
    spread = np.array([max(o.offset_error, 1.0) for o in found])
    return GaussianEstimate(names, np.array([o.offset for o in found]), np.diag(spread**2))


def _offsets_of_file(start: Machine, sessions: Sequence[Session]) -> list[calibration.Offset]:
    """Return the transducers' offsets in the start's file, with the error of a sample's noise."""
    part = start.sensors.pressure
    if part is None or any(s.is_exact for s in sessions):
        return []
    error = part.noise or part.full_scale * (part.accuracy or 1e-4)
    return [
        calibration.Offset(
            channel=name, offset=bias, offset_error=error, gain=gain, gain_error=0.0, unit="Pa"
        )
        for name, (gain, bias) in calibration.lines(start).items()
        if noise_model.KIND[name].unit == "Pa"
    ]


def _estimate_linearly(result: Result, session: Session) -> None:
    """Add a session's linear estimates, and set the machine to those that are identified."""
    corrected = calibration.corrected(session, result.machine)
    found = linear_estimates.estimates(result.machine, corrected)
    result.linear += found
    values = {e.key: e.value for e in found if e.initial and e.usable and not _is_loose(e)}
    result.machine = with_values(result.machine, values)


def _is_loose(e: Estimate) -> bool:
    return is_loose(e.value, e.standard_error, is_positive(e.key))


def _refine(result: Result, session: Session, progress: Callable[[], None]) -> None:
    """Refine the result by one session."""
    known = result.known
    done = refinement.refine(result.machine, session, known, progress, result.stated)
    if done is None:
        return
    work, fit = done
    tests = data_quality.residual_tests(result.start, session, fit)
    explained = data_quality.is_explained(tests)
    result.refined.append(Refined(session, fit, work.free, tests))
    result.remarks += data_quality.not_explained(session, tests)
    told = [key for key in result.stated if key in fit.values and key not in known.names]
    doubts = _doubts(result, result.refined[-1], known, told)
    result.doubts += doubts
    if session.kind == "deadband" and not _takes_own_valve(result, session.own_axis, fit):
        return
    found = [key for key in work.free if not explained or _tells(fit.posterior, known, key)]
    for key in found:
        e = _estimate(key, fit, result.stated)._replace(positive=is_positive(key), withheld=not explained)
        result.estimates[key] = e
    for key in told if explained else ():
        why = next((doubt.reason for doubt in doubts if key in doubt.keys), "")
        result.told[key] = _estimate(key, fit, result.stated)._replace(positive=False, warning=why)
    # A record of the crane hangs on stated numbers: it must not move what the rigs told without them, nor
    # tell what it is not made for: friction that it takes for damping, the next record could not forget. One
    # that the model does not explain moves nothing.
    posterior = fit.posterior
    if session.on_crane:
        untold = [key for key in work.carried if key not in known.names]
        posterior = known.taken(posterior.without(*untold), found)
    result.known = posterior if explained else known.without(*work.free)
    _update(result)


def _estimate(key: str, fit: Fit, stated: Mapping[str, float]) -> Estimate:
    e = Estimate(
        key=key,
        value=fit.values[key],
        standard_error=fit.errors[key],
        unit="1" if key in INERTIAS else unit_of(key),
        condition=fit.condition,
        method="output error",
    )
    return stated_numbers.shared(e, fit.posterior, stated)


def _doubts(result: Result, record: Refined, known: GaussianEstimate, told: Sequence[str]) -> list[Doubt]:
    """Return the doubts of a record: its own, else what it owes to doubtful ones.

    Args:
        result: with the doubts of earlier records.
        record: as it was fitted.
        known: before it.
        told: stated numbers that it is the first to tell.
    """
    keys = (*record.free, *told)
    why = data_quality.doubt(record.session, record.fit, record.tests, list(result.stated))
    if why:
        new = {name for name in record.fit.posterior.names if name not in known.names}
        return [Doubt(why, keys, frozenset({*keys, *new}))]
    found = []
    for key in keys:
        for doubt in result.doubts:
            share = record.fit.posterior.owed(key, doubt.told)
            if share > OWED:
                said = f"{100.0 * share:.0f} % of its variance comes from what is doubtful: {doubt.reason}"
                found.append(Doubt(said, (key,), frozenset({key})))
    return found


def _tells(posterior: GaussianEstimate, known: GaussianEstimate, key: str) -> bool:
    """Tell whether a record knows a number as well as it was known, stated numbers counted."""
    return key not in known.names or posterior.spread(key) <= ALIKE * known.spread(key)


def _takes_own_valve(result: Result, axis: str, fit: Fit) -> bool:
    """Tell whether an axis' valve gets its own section: it had one, or it differs from the shared one."""
    own = f"{axis}.valve"
    had_own = part_of(result.start, own) is not None
    shared = own if had_own else "valve"
    differs, joint = False, with_directions(result.machine, shared)
    for key in ("deadband_voltage", "backward.deadband_voltage"):
        value, error = fit.values[f"{own}.{key}"], fit.errors[f"{own}.{key}"]
        away = abs(value - value_of(joint, f"{shared}.{key}"))
        differs |= away > OWN_VALVE[0] * error and away > OWN_VALVE[1]
        estimate = Estimate(
            key=f"{own}.{key}",
            value=value,
            standard_error=error,
            unit="V",
            condition=fit.condition,
            method="joint motion",
            initial=False,
        )
        result.linear.append(estimate)
    if not (differs or had_own):
        return False
    result.machine = with_directions(result.machine, own)
    return True


def _update(result: Result) -> None:
    """Set machine and estimates to the Gaussian estimate."""
    known, values = result.known, {}
    for key, e in result.estimates.items():
        values[key] = known.value(key, e.positive) if key in known.names else e.value
        if key in known.names:
            error = known.of(key)[1] * (values[key] if e.positive else 1.0)  # by its logarithm
            found = e._replace(value=values[key], standard_error=error)
            result.estimates[key] = stated_numbers.with_stated(found, known, list(result.stated)).checked()
    result.machine = possible_numbers.applied(result, values)


def _conclude(result: Result) -> None:
    """Add parameters that only a linear estimator identified; pool the directions of valves."""
    for estimate in result.linear:
        if not estimate.initial or estimate.key in result.estimates:
            continue
        if estimate.key in result.told:
            result.estimates[estimate.key] = result.told[estimate.key].checked()
        elif estimate.usable:
            result.estimates[estimate.key] = estimate.checked()
        else:
            motion = excitation_for(estimate.key)
            result.remarks.append(f"the records hold nothing of {estimate.key}; it takes {motion}")
    _apply_told(result)
    result.machine = pooling.pooled(result)


def _apply_told(result: Result) -> None:
    """Set the machine to the stated numbers as the records have them: the masses go with those alone."""
    values = {key: e.value for key, e in result.told.items()}
    factors = {key.partition(".")[0]: values.pop(key) for key in INERTIAS if key in values}
    result.machine = stated_numbers.with_inertias(possible_numbers.applied(result, values), factors)
