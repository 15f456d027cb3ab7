"""Run an experiment on a simulated machine without a graph: scripted operator, plant and sensors.

It does what the graph in lockstep does, much faster: row k is step k + 1, and with exact sensors voltages and
states are the same to the last bit, what is derived of them to rounding. With noise they are not: the
operator sees the true angles here, and the sensors draw in another order. The oil warms as it does in
`forest_sim.simulation.open_loop`; a bench's is kept at one temperature by its cooler.
"""

import dataclasses
import math

import numpy as np

from forest_description.machine import Machine
from forest_description.types import ZERO, Vec3
from forest_ident.estimators import calibration
from forest_ident.experiments import excitation, experiment_plan
from forest_ident.experiments.experiment_plan import Plan
from forest_ident.measurements.readings import Columns, joint_places, read, true_columns
from forest_ident.measurements.session import Session
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_readings import surroundings
from forest_sim.sensors.sensor_suite import Suite, sensor_suite
from forest_sim.solver.compiled_plant import FlatPlant
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.oil_temperature import WarmingOil, parameters_at

SUBSTEPS = 5


def experiment(
    name: str, machine: Machine, seed: int = 0, exact: bool = False, longest: float = math.inf
) -> Session:
    """Return the record of an experiment on a simulated machine.

    Args:
        name: one of `experiment_plan.names`.
        machine: the crane.
        seed: of the sensors' static errors and noise, and of levels drawn by lot.
        exact: whether sensors are exact.
        longest: time at which it is cut off [s].
    """
    if name == calibration.NAME:
        session = calibration.simulated(sensor_suite(machine, noise=not exact, seed=seed))
    else:
        plan = experiment_plan.plan(name, machine, seed, longest)
        session = run(plan, sensor_suite(plan.machine, noise=not exact, seed=seed))
    return marked_exact(session) if exact else session


def marked_exact(session: Session) -> Session:
    """Return a session that says that its sensors were exact."""
    return dataclasses.replace(session, metadata={**session.metadata, "exact_sensors": 1.0})


def duration(name: str, machine: Machine, longest: float = math.inf) -> float:
    """Return how long an experiment takes [s]."""
    if name == calibration.NAME:
        return 2.0 * calibration.EACH
    return experiment_plan.plan(name, machine, 0, longest).programme.duration


def instructions(name: str, machine: Machine, longest: float = math.inf) -> str:
    """Return what a person must do for an experiment, and within which limits it runs."""
    if name == calibration.NAME:
        return f"{name}\n  by hand: {calibration.SETUP}"
    plan = experiment_plan.plan(name, machine, 0, longest)
    return f"{name}: {plan.programme.duration:.0f} s\n  by hand: {plan.setup}\n  limits: {plan.limits}"


def run(plan: Plan, suite: Suite) -> Session:
    """Return the record of a plan's experiment, read by the suite's sensors."""
    trace = _Trace(plan.machine, plan.angles, plan.bench)
    trace.advance(ZERO)  # before the graph's first step
    state = excitation.START
    count = round(plan.programme.duration / PERIOD)
    voltages = np.zeros((count, 3))
    for k in range(count):
        state, volts = excitation.step(state, trace.angles(), plan.programme, PERIOD)
        voltages[k] = volts
        if k + 1 < count:
            trace.advance(volts)
    true = {channel: column[1:] for channel, column in trace.columns().items()}
    sampled = read(true, suite, PERIOD, plan.name)
    readings = {channel: column for channel, column in sampled.items() if not np.isnan(column).all()}
    metadata = dict(plan.metadata)
    if not plan.bench and "case_drain" in true:
        metadata["case_drain_volume"] = float(np.sum(true["case_drain"]) * PERIOD)
    return Session(
        name=plan.name,
        time=PERIOD * np.arange(count, dtype=np.float64),
        voltages=voltages,
        readings=readings,
        metadata=metadata,
    )


class _Trace:
    """A machine under way, and all its states until then."""

    def __init__(self, machine: Machine, angles: Vec3, bench: bool) -> None:
        self._machine, self._bench = machine, bench
        p = plant_parameters(machine)
        self._oil = WarmingOil(machine.oil, PERIOD) if machine.oil and not bench else None
        temperature = machine.oil.reference_temperature if machine.oil else 313.15
        self._flat, self._joints = FlatPlant(), joint_places(p)
        self._flat.lay_out(equilibrium(angles, p))
        self._flat.set_parameters(p)
        self._rows = [self._flat.state.copy()]
        self._plants = [(0, p, temperature)]  # first row, plant, temperature [K]

    def angles(self) -> Vec3:
        """Return the joint angles [rad]."""
        swing, boom, stick = self._flat.state[self._joints].tolist()
        return swing, boom, stick

    def advance(self, volts: Vec3) -> None:
        """Move on by a period."""
        self._flat.advance(volts, PERIOD / SUBSTEPS, SUBSTEPS)
        self._rows.append(self._flat.state.copy())
        oil, p = self._oil, self._plants[-1][1]
        if oil is not None and oil.has_warmed(lambda: self._flat.simulation, p):
            p = parameters_at(self._machine, oil.temperature)
            self._flat.set_parameters(p)
            self._plants.append((len(self._rows), p, oil.temperature))

    def columns(self) -> Columns:
        """Return the true value of every channel over the run."""
        states, around = np.array(self._rows), surroundings(self._machine)
        plants = [plant for plant in self._plants if plant[0] < len(states)]
        ends = [first for first, _, _ in plants[1:]] + [len(states)]
        parts = [
            true_columns(states[first:end], p, around._replace(temperatures=(t, t, t)), self._bench)
            for (first, p, t), end in zip(plants, ends, strict=True)
        ]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
