"""An experiment on a simulated machine without a graph, and what a person is told of one."""

from __future__ import annotations

import dataclasses
import math

from forest_description.machine import Machine
from forest_ident.driving import simulated_experiment
from forest_ident.estimators import calibration
from forest_ident.experiments import experiments
from forest_ident.measurements.session import Session
from forest_sim.sensors.sensor_suite import Suite, sensor_suite


def experiment(
    name: str, machine: Machine, seed: int = 0, exact: bool = False, longest: float = math.inf
) -> Session:
    """Return the record of an experiment on a simulated machine.

    Args:
        name: one of `experiments.names`.
        machine: the crane.
        seed: of the sensors' static errors and noise, and of levels drawn by lot.
        exact: whether sensors are exact.
        longest: time at which it is cut off [s].
    """
    if name == calibration.NAME:
        session = calibration.simulated(_suite(machine, seed, exact))
        facts = dict(session.facts)
    else:
        plan = experiments.plan(name, machine, seed, longest)
        suite = _suite(plan.machine, seed, exact)
        session = simulated_experiment.run(name, plan.machine, plan.programme, plan.angles, suite, plan.bench)
        facts = {**plan.facts, **session.facts}
    if exact:
        facts["exact_sensors"] = 1.0
    return dataclasses.replace(session, facts=facts)


def _suite(machine: Machine, seed: int, exact: bool) -> Suite:
    return sensor_suite(machine, noise=not exact, seed=seed)


def duration(name: str, machine: Machine, longest: float = math.inf) -> float:
    """Return how long an experiment takes [s]."""
    if name == calibration.NAME:
        return 2.0 * calibration.EACH
    return experiments.plan(name, machine, 0, longest).programme.duration


def told(name: str, machine: Machine, longest: float = math.inf) -> str:
    """Return what a person must do for an experiment, and within which limits it runs."""
    if name == calibration.NAME:
        return f"{name}\n  by hand: {calibration.SETUP}"
    plan = experiments.plan(name, machine, 0, longest)
    return f"{name}: {plan.programme.duration:.0f} s\n  by hand: {plan.setup}\n  limits: {plan.limits}"
