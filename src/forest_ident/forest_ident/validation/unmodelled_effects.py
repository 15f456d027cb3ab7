"""Effects that a model lacks, on simulated machines: two questions that the thesis' validation leaves open.

A crane has one effect that its model lacks. Both get the validation's voltages, and the model's prediction is
compared with the readings of the crane's sensors. The cases:

| case | the crane has, and the model lacks |
|---|---|
| none | nothing: what noise and static errors of the sensors leave |
| areas | a rod: the model's cylinders take half the sum of both areas at either port, as a motor does |
| return_edge | port 2's edges a tenth narrower than port 1's; the model's spool is symmetric |
| edge_and_damping | the same, but the model's stick has the damping that suits its driving pressures |
| seals | dry friction in the cylinders, 1.5 bar on the piston at speed, half as much again at rest |
| pendulum | its head hanging from a joint with two axes; the model's head is a point at the tip |

| symbol | name | unit |
|---|---|---|
| driving, return pressure | of the port that the spool connects to the supply, to the tank | Pa |
| out, in | the valve connects port 1, port 2 to the supply | - |
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import scipy

from forest_description.machine import Machine
from forest_description.mechanics.drives import Friction
from forest_description.mechanics.load import Pendulum
from forest_description.types import AXES, Bools
from forest_ident.driving import simulated_experiment
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.parameter_path import SECTIONS, part_of, with_part
from forest_ident.measurements.session import Session, SessionError
from forest_ident.validation.prediction_error import Signal, rms, signals
from forest_sim.sensors.sensor_suite import sensor_suite

NARROWER = 0.9  # area of port 2's edges over that of port 1's
SEAL_PRESSURE, BREAKAWAY = 1.5e5, 1.5  # [Pa] on the piston; over Coulomb's
STRIBECK, SMOOTHING = 0.012, 0.002  # [m/s] as `loader` has them
HEAD = Pendulum(length=0.9, inertia=60.0, damping=250.0)
"""A grapple of the shipped crane's 700 kg within a metre and a half; damping ratio near 0.05."""


class Case(NamedTuple):
    """A crane, and a model that lacks something of it."""

    name: str
    crane: Machine
    model: Machine
    refit: bool = False  # whether the model's damping is fitted to the record first


class Score(NamedTuple):
    """Error of one signal of an axis, while its valve is open one way, or either way."""

    axis: str
    signal: str  # angle, velocity, flow, driving, return
    way: str  # both, out, in
    unit: str
    rms: float
    span: float  # range of what was read meanwhile

    @property
    def nrmse(self) -> float:
        """RMS error over range."""
        return self.rms / max(self.span, 1e-12)


class Answer(NamedTuple):
    """A simulated case."""

    case: Case
    session: Session
    signals: list[Signal]
    scores: list[Score]


def cases(machine: Machine) -> tuple[Case, ...]:
    """Return the cases of a machine; its own head hangs in `pendulum` alone. Thesis section 4.4."""
    own = machine.manipulator.pendulum or HEAD
    base = with_part(machine, "manipulator.pendulum", None)
    return (
        Case("none", base, base),
        Case("areas", base, _with_equal_areas(base)),
        Case("return_edge", _with_narrow_return(base), base),
        Case("edge_and_damping", _with_narrow_return(base), base, refit=True),
        Case("seals", _with_seals(base), base),
        Case("pendulum", with_part(machine, "manipulator.pendulum", own), base),
    )


def answer(case: Case, seed: int = 0, noise: bool = True, longest: float = math.inf) -> Answer:
    """Simulate the validation on a case's crane; return the errors of its model's prediction.

    Args:
        case: of `cases`.
        seed: of the sensors, and of the levels that are drawn by lot.
        noise: whether the sensors are those of the machine's file instead of exact ones.
        longest: time at which it is cut off [s].

    Raises:
        SessionError: the machine has no angles or pressures to compare.
    """
    plan = experiment_plan.plan("validation", case.model, seed, longest)
    suite = sensor_suite(case.crane, noise=noise, seed=seed)
    record = simulated_experiment.run(plan._replace(machine=case.crane), suite)
    session = record if noise else simulated_experiment.marked_exact(record)
    model = _damped_as(case.model, session) if case.refit else case.model
    found = signals(model, session)
    return Answer(case._replace(model=model), session, found, scores(model, session, found))


def scores(model: Machine, session: Session, found: list[Signal]) -> list[Score]:
    """Return the scores of every axis: signals throughout, pressures while the valve is open.

    Args:
        model: whose overlap defines when a valve is open.
        session: that was predicted.
        found: its signals.

    Raises:
        SessionError: an axis has no transducers at the actuator's ports.
    """
    kept: list[Score] = []
    for axis in dict.fromkeys(s.axis for s in found):
        of = {s.name: s for s in found if s.axis == axis}
        whole = np.ones(len(session.time), dtype=bool)
        there = [name for name in ("angle", "velocity", "flow") if name in of]
        kept += [_score(axis, name, "both", [(of[name], whole)]) for name in there]
        if "pressure 1" not in of or "pressure 2" not in of:
            raise SessionError(f"{session.name}: the questions need pressures at both ports of the {axis}")
        out, back = _open(model, session, AXES.index(axis))
        one, two = of["pressure 1"], of["pressure 2"]
        kept += [
            _score(axis, "driving", "both", [(one, out), (two, back)]),
            _score(axis, "return", "both", [(two, out), (one, back)]),
            _score(axis, "driving", "out", [(one, out)]),
            _score(axis, "driving", "in", [(two, back)]),
            _score(axis, "return", "out", [(two, out)]),
            _score(axis, "return", "in", [(one, back)]),
        ]
    return kept


def _open(model: Machine, session: Session, axis: int) -> tuple[Bools, Bools]:
    """Return the rows in which an axis' valve is commanded open, by direction."""
    volts, law = session.voltages[:, axis], model.valve_of(axis).law
    return volts > law.forward.deadband_voltage, volts < -law.backward.deadband_voltage


def _score(axis: str, name: str, way: str, parts: list[tuple[Signal, Bools]]) -> Score:
    measured = np.concatenate([s.measured[rows] for s, rows in parts])
    wrong = measured - np.concatenate([s.predicted[rows] for s, rows in parts])
    size, span = (rms(wrong), float(np.ptp(measured))) if len(measured) else (0.0, 0.0)
    return Score(axis=axis, signal=name, way=way, unit=parts[0][0].unit, rms=size, span=span)


def _damped_as(model: Machine, session: Session) -> Machine:
    """Return the model with the stick's damping that fits its driving pressures best. Thesis eq. 4.11."""

    def machine(log: float) -> Machine:
        return with_part(model, "stick.damping", model.stick.damping * math.exp(log))

    def cost(log: float) -> float:
        of = {s.name: s for s in signals(machine(log), session) if s.axis == "stick"}
        ways = zip((of["pressure 1"], of["pressure 2"]), _open(model, session, 2), strict=True)
        return sum(float(np.sum((s.measured - s.predicted)[rows] ** 2)) for s, rows in ways)

    return machine(float(scipy.optimize.minimize_scalar(cost, bounds=(-4.0, 4.0), options={"xatol": 0.01}).x))


def _with_equal_areas(machine: Machine) -> Machine:
    """Return a machine whose cylinders take the mean of both areas at either port."""
    for axis, drive in zip(AXES[1:], machine.drives[1:], strict=True):
        mean = 0.5 * (drive.head_area + drive.rod_area)
        # A rod as thin as the file's bounds take it.
        equal = dataclasses.replace(drive, head_area=mean * (1.0 + 1e-6), rod_area=mean)
        machine = with_part(machine, axis, equal)
    return machine


def _with_narrow_return(machine: Machine) -> Machine:
    """Return a machine whose valves all have narrower edges at port 2."""
    for section in SECTIONS:
        valve = part_of(machine, section)
        if valve is not None:
            machine = with_part(machine, f"{section}.port_2_area", NARROWER * valve.port_2_area)
    return machine


def _with_seals(machine: Machine) -> Machine:
    """Return a machine whose cylinders have seals with dry friction, in addition to what they have."""
    for axis, drive in zip(AXES[1:], machine.drives[1:], strict=True):
        force = SEAL_PRESSURE * drive.head_area
        own = drive.friction or Friction(0.0, 0.0, STRIBECK, SMOOTHING)
        dry = dataclasses.replace(
            own,
            coulomb_force=own.coulomb_force + force,
            breakaway_force=own.breakaway_force + BREAKAWAY * force,
        )
        machine = with_part(machine, f"{axis}.friction", dry)
    return machine
