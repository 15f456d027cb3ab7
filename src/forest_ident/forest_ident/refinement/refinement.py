"""Refine parameters through the simulator: an output-error fit for each experiment.

What earlier experiments found is the prior of the next fit, with its covariance. So everything is refined
together without one huge problem: a crane's motion may still correct what the bench found of the valve,
within the bench's interval. `refinement_task` names the parameters and channels of each experiment.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.estimators import calibration
from forest_ident.estimators.parameter_estimate import is_positive
from forest_ident.experiments import experiment_plan, rigs
from forest_ident.measurements import sample_mask
from forest_ident.measurements.parameter_path import value_of, with_directions, with_part, with_values
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Channel, Columns, Fit, Unknown
from forest_ident.output_error.gaussian_estimate import GaussianEstimate, widened
from forest_ident.output_error.output_error import fit
from forest_ident.output_error.prediction import ROUGH, STEP, Offsets, predict, redrawn
from forest_ident.output_error.search import Model
from forest_ident.refinement import extension_keys
from forest_ident.refinement.refinement_task import INERTIAS, START, Task, is_parameter, stated_keys, task

UNKNOWN = 0.4  # prior standard deviation of what no experiment has estimated yet: relative, or volts
BEGUN = 0.1  # standard deviation, as `UNKNOWN`, from which a search begins with a number
FINE = 1e-5  # difference on a rig, as `UNKNOWN`: nothing sticks there, and a valve next to shut bends much
SETTLED = 0.25  # [s] after a change of voltage
START_NOISE = 1e4  # [Pa] by which pressures drift while the mean of the start is taken
ANGLES = tuple(f"{axis}.angle" for axis in AXES)


def refine(
    machine: Machine,
    session: Session,
    known: GaussianEstimate,
    progress: Callable[[], None] = lambda: None,
    errors: Mapping[str, float] = MappingProxyType({}),
) -> tuple[Task, Fit] | None:
    """Return what a session makes of its parameters, through the simulator; None if it finds none.

    Args:
        machine: with the values to start from.
        session: the record.
        known: what earlier experiments found.
        progress: called after every simulation.
        errors: standard deviation of every stated number, by key; those that a record does not feel do not
            move it.
    """
    work = task(machine, session)
    if work is None:
        return None
    # The load chart moves nothing, and would refuse lengths that are moved a little to feel their errors.
    machine = dataclasses.replace(machine, capacity=None)
    if session.kind == "deadband":
        machine = with_directions(machine, f"{session.own_axis}.valve")
    unknowns = [*_unknowns(machine, session, work, known), *_start_pressures(machine, session, work, known)]
    channels = _channels(machine, session, work)
    # Static errors stay, the noise of the means that a session starts from is its own.
    noise = {name: noise_model.start_noise(machine, session, name) for name in ANGLES}
    corrected = calibration.corrected(session, machine)

    def driven_by(inputs: Session, step: float = STEP) -> Model:
        return lambda values: _predicted(machine, inputs, values, step)

    felt = stated_keys(machine, session)
    moved = [
        {key: stated_value(machine, key) + error} if key in felt else {} for key, error in errors.items()
    ]
    again = () if session.on_rig else [driven_by(one, ROUGH) for one in redrawn(machine, corrected)]
    done = fit(
        driven_by(corrected),
        _measured(session, channels),
        channels,
        unknowns,
        progress,
        prior=widened(known, noise),
        redrawn=again,
        stated=moved,
        rough=driven_by(corrected, ROUGH),
    )
    rounded = extension_keys.rounding(done.values)
    return work, done._replace(posterior=widened(done.posterior, rounded))


def _channels(machine: Machine, session: Session, work: Task) -> list[Channel]:
    """Return the channels that count.

    Raises:
        SessionError: there is none.
    """
    sensed = dataclasses.replace(machine, sensors=rigs.meters(machine)) if session.on_rig else machine
    channels = noise_model.channels(sensed, session, work.channels)
    if not channels:
        wanted = ", ".join(work.channels)
        raise SessionError(
            f"{session.name}: no sensor reads all the time and moves; it takes one of {wanted}"
        )
    return channels


def _measured(session: Session, channels: Sequence[Channel]) -> Columns:
    """Return what the channels read; NaN where it does not count."""
    measured = sample_mask.fresh({c.name: session.column(c.name) for c in channels})
    if not session.on_rig:
        return sample_mask.without_start(measured, session)
    floor = max((c.floor for c in channels), default=0.0)
    settled = SETTLED if session.kind == "valve" else 0.0
    return sample_mask.while_open(measured, session, settled, floor)


def _unknowns(machine: Machine, session: Session, work: Task, known: GaussianEstimate) -> list[Unknown]:
    """Return parameters and nuisances with their priors; exact sensors have no static errors.

    A record of the crane passes on only what it is made for.
    """
    found = []
    for key in (*work.free, *work.carried):
        positive = is_positive(key)
        # An overlap that a curve in volts hides stays near its start, or it would leave the curve behind.
        linear = not extension_keys.is_extension(key)  # it begins with a linear estimate
        spread = math.inf if key in work.free and positive and linear else UNKNOWN
        unknown = Unknown(
            key=key,
            start=value_of(machine, key),
            prior=spread,
            positive=positive,
            own=session.on_crane and key in work.carried,
            begun=linear and (session.on_crane or key in work.free) and not _is_known(known, key),
        )
        usual = FINE if session.on_rig else unknown.difference
        difference = extension_keys.COARSE.get(key.rpartition(".")[2], usual)
        rounded = extension_keys.rounding({key: unknown.start}).get(key, 0.0)
        found.append(unknown._replace(difference=difference, rounded=rounded))
    if "rig.load" in work.nuisances:
        found.append(Unknown(f"rig.load.{session.name}", _load(session), math.inf, begun=True))
    for name in () if session.is_exact else work.nuisances:
        if name == "tilt":
            sd = noise_model.accuracy(machine, session, "inclinometer") or 0.01
            found.append(Unknown(name, 0.0, sd, positive=False))
        elif name == "oil.offset" and session.temperature() is not None and machine.oil is not None:
            sd = noise_model.accuracy(machine, session, "thermocouple") / math.sqrt(3.0)
            found.append(Unknown(name, 0.0, max(sd, 0.01), positive=False, difference=0.1))
        elif name in ANGLES and (sd := noise_model.accuracy(machine, session, "resolver")) > 0.0:
            found.append(Unknown(name, 0.0, sd, positive=False))
    return found


def _is_known(known: GaussianEstimate, key: str) -> bool:
    """Tell whether earlier records tell a number well enough for a search to begin with."""
    return key in known.names and known.of(key)[1] < BEGUN


def _start_pressures(
    machine: Machine, session: Session, work: Task, known: GaussianEstimate
) -> list[Unknown]:
    """Return the pressures at the start of a crane's record: behind a shut valve they last for long."""
    found: list[Unknown] = []
    for name in work.channels if session.on_crane else ():
        if "_pressure_" not in name or not session.has(name):
            continue
        offset = noise_model.channel(machine, session, name).offset
        if f"{name}.b" in known.names:  # calibrated: the record is corrected by that
            _, offset = known.of(f"{name}.b")
        spread = math.hypot(offset, START_NOISE)
        found.append(
            Unknown(
                key=f"{START}{name}.{session.name}",
                start=0.0,
                prior=spread,
                positive=False,
                difference=START_NOISE,
                own=True,
            )
        )
    return found


def _load(session: Session) -> float:
    """Return R_L [Pa s/m^3] of a bench's load from pressures and flow, to start from."""
    one, two = session.pressures("swing", "actuator")
    flow = session.column("swing_flow")
    return float((one - two) @ flow / (flow @ flow))


def prepared(machine: Machine, session: Session) -> Machine:
    """Return the machine as it stood in a session: on its rig, or with its platform tilted as read."""
    if session.on_rig:
        return experiment_plan.plan(session.name, machine).machine
    if session.name != "motor_internal":
        return machine
    if session.has("platform_roll"):
        tilt = float(np.mean(session.column("platform_roll")))
    else:
        tilt = session.metadata.get("platform_tilt", machine.manipulator.platform_tilt)
    return with_part(machine, "manipulator.platform_tilt", tilt)


def stated_value(machine: Machine, key: str) -> float:
    """Return what is told of a number: the machine's, 1 of a factor."""
    return 1.0 if key in INERTIAS else value_of(machine, key)


def with_inertias(machine: Machine, factors: Mapping[str, float]) -> Machine:
    """Return the machine with the moments of inertia of boom and stick times a factor each."""
    links = machine.manipulator
    moments = {
        name: getattr(links, name) * factor
        for link, factor in factors.items()
        for name in (f"{link}_{moment}" for moment in ("xx", "yy", "zz", "xy"))
    }
    return with_part(machine, "manipulator", dataclasses.replace(links, **moments)) if moments else machine


def _predicted(
    machine: Machine, session: Session, values: Mapping[str, float], step: float
) -> Mapping[str, Floats]:
    """Return what the machine with these values would have read."""
    own = {key: value for key, value in values.items() if is_parameter(key)}
    factors = {name.partition(".")[0]: values[name] for name in INERTIAS if name in values}
    model = prepared(with_inertias(with_values(machine, own), factors), session)
    load = values.get(f"rig.load.{session.name}")
    if load is not None:
        model = with_values(model, {rigs.LOAD_KEY: load * rigs.DISPLACEMENT**2})
    if "tilt" in values:
        key = "manipulator.platform_tilt"
        model = with_values(model, {key: value_of(model, key) + values["tilt"]})
    offsets = Offsets(*(values.get(name, 0.0) for name in (*ANGLES, "oil.offset")))
    start = {key.split(".")[1]: value for key, value in values.items() if key.startswith(START)}
    return predict(model, session, offsets, start, step)
