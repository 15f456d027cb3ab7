"""Refine parameters through the simulator: an output-error fit for each experiment.

What earlier experiments found is the prior of the next fit, with its covariance. So everything is refined
together without one huge problem: a crane's motion may still correct what the bench found of the valve,
within the bench's interval. `refinement_task` names the parameters and channels of each experiment.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.estimators import calibration
from forest_ident.experiments import experiment_plan, rigs
from forest_ident.measurements import sample_mask
from forest_ident.measurements.parameter_path import value_of, with_directions, with_part, with_values
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Channel, Columns, Fit
from forest_ident.output_error.gaussian_estimate import GaussianEstimate, widened
from forest_ident.output_error.output_error import fit
from forest_ident.output_error.prediction import ROUGH, STEP, Offsets, predict, redrawn
from forest_ident.output_error.search import Model
from forest_ident.refinement import extension_keys, stated_numbers, unknowns
from forest_ident.refinement.refinement_task import (
    INERTIAS,
    START,
    Task,
    is_parameter,
    stated_keys,
    task,
    tells_stated,
)
from forest_ident.refinement.stated_numbers import stated_value, with_inertias
from forest_ident.refinement.unknowns import ANGLES

SETTLED = 0.25  # [s] after a change of voltage


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
    told = tells_stated(machine)
    exact = told and session.on_crane  # changes, too, must be the exact model's
    felt = {key: errors[key] for key in stated_keys(machine, session) if key in errors}
    wanted = unknowns.of_record(machine, session, work, known) + unknowns.starts(
        machine, session, work, known
    )
    wanted += unknowns.stated(machine, felt, known) if told else []
    moved = [{key: stated_value(machine, key) + felt[key]} if key in felt else {} for key in errors]
    channels = _channels(machine, session, work)
    # Static errors stay, the noise of the means that a session starts from is its own.
    noise = {} if told else {name: noise_model.start_noise(machine, session, name) for name in ANGLES}
    corrected = calibration.corrected(session, machine)

    def driven_by(inputs: Session, step: float = STEP) -> Model:
        return lambda values: _predicted(machine, inputs, values, step)

    step = STEP if exact else ROUGH
    again = () if session.on_rig else [driven_by(one, step) for one in redrawn(machine, corrected)]
    done = fit(
        driven_by(corrected),
        _measured(session, channels),
        channels,
        wanted,
        progress,
        prior=widened(known, noise),
        redrawn=again,
        stated=() if told else moved,
        rough=None if exact else driven_by(corrected, ROUGH),
        # Next to a curve's first knots derivatives by an overlap tell more than the record does.
        near=session.on_rig and all(machine.valve_of(axis).curve is None for axis in range(3)),
    )
    if told:
        done = done._replace(asked=stated_numbers.asked(machine, done.values, errors))
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
