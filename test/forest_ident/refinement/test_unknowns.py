"""Unknowns of a record's fit: where each begins, its prior, its difference, and what is passed on."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.measurements.parameter_path import value_of, with_directions
from forest_ident.measurements.session import Session
from forest_ident.output_error import noise_model
from forest_ident.output_error.gaussian_estimate import EMPTY, GaussianEstimate
from forest_ident.refinement import refinement_task, unknowns
from forest_ident.refinement.refinement_task import Task, task

SMOOTH, STICKING = (with_directions(load_machine(name), "valve") for name in ("c180_hoses", "c180"))
WARM = {"tank_temperature": np.full(300, 315.0)}


def record(name, readings=None, facts=None, rows=300):
    """A record whose axis is driven from 1.25 s on: the start is a mean over 200 rows."""
    volts = np.zeros((rows, 3))
    volts[250:, 1] = 3.0
    return Session(name, np.arange(rows) * 0.005, volts, {**WARM, **(readings or {})}, facts or {})


def found(machine, session, work=None, known=EMPTY):
    work = work or task(machine, session)
    return {u.key: u for u in unknowns.of_record(machine, session, work, known)}


def test_a_free_number_has_no_prior_and_one_that_goes_along_its_own():
    work = Task(("boom.damping", "valve.deadband_voltage"), ("hose.inertance",), ())
    one = found(SMOOTH, record("damping_boom"), work)
    for key in ("boom.damping", "valve.deadband_voltage", "hose.inertance"):
        assert one[key].start == value_of(SMOOTH, key)
        assert (one[key].difference, one[key].rounded, one[key].like) == (1e-5, 0.0, None)
    assert [u.prior for u in one.values()][:3] == [math.inf, 0.4, 0.4]  # an overlap's in volts
    assert [u.positive for u in one.values()][:3] == [True, False, True]
    assert [u.own for u in one.values()][:3] == [False, False, True]  # this record is not made for hoses
    assert [u.begun for u in one.values()][:3] == [True, True, True]


def test_a_search_begins_with_what_no_record_has_told_well():
    work = Task(("boom.damping",), ("hose.inertance", "hose.capacitance"), ())
    spread = np.diag([0.09, 0.11, 0.05]) ** 2
    known = GaussianEstimate(("hose.inertance", "hose.capacitance", "boom.damping"), np.zeros(3), spread)
    crane = found(SMOOTH, record("damping_boom"), work, known)
    assert [u.begun for u in crane.values()][:3] == [False, False, True]
    rig = found(SMOOTH, record("hose", facts={"hose_axis": 0.0}), work)
    assert [u.begun for u in rig.values()][:3] == [True, False, False]
    assert [u.own for u in rig.values()][:3] == [False] * 3


def test_numbers_beyond_the_thesis_begin_with_a_prior_and_a_rounded_one_with_a_coarse_difference():
    one = found(STICKING, record("damping_boom"))
    friction = one["boom.friction.coulomb_force"]
    assert (friction.prior, friction.begun, friction.own, friction.difference) == (0.4, False, False, 1e-2)
    work = Task(("valve.dead_time", "valve.hysteresis"), (), (), nuisances=())
    late, play = found(STICKING, record("spool"), work).values()
    assert late.key == "valve.dead_time"
    assert late.rounded == pytest.approx(1e-3 / math.sqrt(12.0) / value_of(STICKING, "valve.dead_time"))
    assert (late.difference, play.difference, play.rounded) == (0.25, 1e-5, 0.0)  # on a rig nothing sticks


def test_static_errors_have_the_accuracy_of_their_sensors_and_exact_ones_none():
    work = Task((), (), (), nuisances=("swing.angle", "boom.angle", "oil.offset", "tilt"))
    session = record("motor_internal")
    one = found(SMOOTH, session, work)
    assert {key: (u.start, u.positive) for key, u in one.items()} == dict.fromkeys(
        work.nuisances, (0.0, False)
    )
    s = SMOOTH.sensors
    assert one["boom.angle"].prior == pytest.approx(s.resolver.accuracy / math.sqrt(3.0))
    assert one["oil.offset"].prior == pytest.approx(max(s.thermocouple.accuracy / 3.0, 0.01))
    tilt = (s.inclinometer.accuracy / math.sqrt(3.0)) if s.inclinometer else 0.01
    assert one["tilt"].prior == pytest.approx(tilt)
    assert [one[key].difference for key in work.nuisances] == [1e-5, 1e-5, 0.1, 1e-5]
    assert one["boom.angle"].like == ("start.boom_resolver.motor_internal", "boom_resolver")
    assert found(SMOOTH, dataclasses.replace(session, metadata={"exact_sensors": 1.0}), work) == {}
    sticking = found(STICKING, session, work)
    assert [sticking[key].difference for key in work.nuisances] == [1e-2, 1e-2, 0.1, 1e-2]
    assert sticking["boom.angle"].like is None
    bare = dataclasses.replace(SMOOTH, sensors=dataclasses.replace(s, inclinometer=None))
    assert found(bare, session, work)["tilt"].prior == 0.01
    cold = dataclasses.replace(session, readings={})
    assert "oil.offset" not in found(SMOOTH, cold, work)
    assert "oil.offset" not in found(dataclasses.replace(SMOOTH, oil=None), session, work)


def test_a_benchs_load_begins_with_what_pressures_and_flow_tell():
    flow = np.tile([1e-3, -2e-3, 5e-4], 100)
    readings = {
        "swing_flow": flow,
        "swing_pressure_1_actuator": 4e6 + 2e9 * flow,
        "swing_pressure_2_actuator": np.full(300, 4e6),
    }
    session = record("hose", readings, {"hose_axis": 0.0})
    load = found(SMOOTH, session)["rig.load.hose"]
    assert load.start == pytest.approx(2e9)
    assert (load.prior, load.begun, load.positive, load.own) == (math.inf, True, True, False)


def test_the_start_of_a_cranes_record_is_unknown_by_drift_and_what_a_transducer_may_be_off():
    names = ("boom_pressure_1_actuator", "boom_pressure_2_actuator", "boom_flow")
    session = record("damping_boom", {name: np.ones(300) for name in names})
    work = Task((), (), names, nuisances=("boom.angle", "oil.offset"))
    known = GaussianEstimate(("boom_pressure_2_actuator.b",), np.zeros(1), np.array([[3e3**2]]))
    one, two, angle = unknowns.starts(SMOOTH, session, work, known)
    assert [u.key for u in (one, two, angle)] == [
        "start.boom_pressure_1_actuator.damping_boom",
        "start.boom_pressure_2_actuator.damping_boom",
        "start.boom_resolver.damping_boom",
    ]
    offset = noise_model.channel(SMOOTH, session, names[0]).offset
    assert one.prior == pytest.approx(math.hypot(offset, 1e4))
    assert two.prior == pytest.approx(math.hypot(3e3, 1e4))
    assert angle.prior == pytest.approx(noise_model.start_noise(SMOOTH, session, "boom.angle"))
    for u in (one, two, angle):
        assert (u.start, u.positive, u.own) == (0.0, False, True)
    assert [u.difference for u in (one, two, angle)] == [1.0, 1.0, 1e-5]
    assert [u.difference for u in unknowns.starts(STICKING, session, work, EMPTY)] == [1e4, 1e4]
    assert unknowns.starts(SMOOTH, record("hose"), work, EMPTY) == []


def test_a_stated_number_begins_as_told_and_only_the_first_record_passes_it_on():
    felt = {"manipulator.stick_mass": 54.0, "boom.inertia": 0.1}
    known = GaussianEstimate(("boom.inertia",), np.ones(1), np.eye(1))
    mass, inertia = unknowns.stated(SMOOTH, felt, known)
    assert (mass.start, mass.prior, mass.own) == (SMOOTH.manipulator.stick_mass, 54.0, False)
    assert (inertia.start, inertia.prior, inertia.own) == (1.0, 0.1, True)
    assert (mass.difference, inertia.difference) == pytest.approx((54e-5, 1e-6))
    assert not mass.positive
    assert refinement_task.tells_stated(SMOOTH)
    assert not refinement_task.tells_stated(STICKING)
