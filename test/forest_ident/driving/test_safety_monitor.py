import dataclasses
import math

import pytest

from forest_description.export.machine_yaml import machine_text
from forest_description.machine import load_machine
from forest_ident.driving import safety_monitor
from forest_ident.driving.safety_monitor import PEAK, Readings, State, bounds, out_of_bounds, step
from forest_ident.experiments import experiment_plan
from forest_ident.experiments.excitation import START
from forest_ident.experiments.excitation import step as excite

C180 = load_machine("c180_hoses")
PLAN = experiment_plan.plan("damping_boom", C180)
BOUNDS = bounds(PLAN, PLAN.programme)
WELL = Readings(PLAN.angles, (5e6, 3e6), 20.7e6, 313.0)
NAN = math.nan


def verdict(seen, seconds=0.05):
    state, reason = State(), ""
    for _ in range(round(seconds / 0.005)):
        state, reason = step(state, seen, BOUNDS, 0.005)
        if reason:
            break
    return reason


@pytest.mark.parametrize(
    ("change", "seconds", "sentence"),
    [
        ({}, 1.0, ""),
        ({"angles": (0.0, math.radians(71.0), -1.5)}, 0.01, "the boom stands at 71.0 deg; allowed"),
        ({"angles": (0.0, 0.5, -2.2)}, 1.0, ""),  # the stick is not driven
        ({"pressures": (4e7, 3e6)}, 0.2, ""),  # a valve that shuts
        ({"pressures": (4e7, 3e6)}, 2.0 * PEAK, "stays at 40.00 MPa; allowed: up to 36.15 MPa"),
        ({"supply": 1e6}, 2.0 * PEAK, "the supply pressure is 1.00 MPa; allowed: 5.17 MPa or more"),
        ({"supply": NAN, "temperature": NAN, "pressures": ()}, 1.0, ""),  # no such sensors
        ({"temperature": 351.0}, 0.01, "the oil is at 351.0 K; allowed: up to 350 K"),
    ],
)
def test_what_stops_an_experiment(change, seconds, sentence):
    said = verdict(WELL._replace(**change), seconds)
    assert sentence in said
    assert bool(said) == bool(sentence)


def test_a_peak_that_passes_is_forgotten():
    state = State()
    for k in range(400):
        state, reason = step(state, WELL._replace(pressures=(4e7 if k % 40 < 30 else 2e7,)), BOUNDS, 0.005)
        assert not reason


@pytest.mark.parametrize("name", ["c180_hoses", "c180_thesis", "loader"])
def test_every_start_is_within_the_bounds_of_its_experiment(name):
    machine = load_machine(name)
    for known in experiment_plan.names(machine)[1:]:
        plan = experiment_plan.plan(known, machine)
        assert not out_of_bounds(plan.angles, bounds(plan, plan.programme)), known


def test_the_swing_goes_about_where_it_stands_and_keeps_from_its_ends():
    plan = experiment_plan.plan("motor_external", C180)
    for stands, room in ((0.7, (-0.5, 1.9)), (2.5, (1.3, math.pi - 0.1))):
        moved = safety_monitor.around(plan.programme, plan, stands)
        assert moved.tracks[0][1:3] == pytest.approx(room)
        assert not out_of_bounds((stands, 0.0, 0.0), bounds(plan, moved))
        _, volts = excite(START._replace(time=2.0), (stands, 0.0, 0.0), moved, 0.005)
        assert volts[0] != 0.0


def test_a_rig_has_no_joints_that_could_be_out_of_bounds():
    plan = experiment_plan.plan("valve", C180)
    assert safety_monitor.monitored_ports(plan) == ("swing_1_actuator", "swing_2_actuator")
    assert not out_of_bounds((99.0, 99.0, 99.0), bounds(plan, plan.programme))


@pytest.mark.parametrize("name", ["valve_stick", "motor_internal"])
def test_a_prepared_machine_can_be_told_to_a_node_as_a_file(name, tmp_path):
    plan, file = experiment_plan.plan(name, load_machine("loader")), tmp_path / "rig.yaml"
    file.write_text(machine_text(plan.machine, "made of the loader's parts"), encoding="utf-8")
    assert load_machine(file) == dataclasses.replace(plan.machine, name="rig")


def test_a_trial_is_cut_off_and_rests_at_its_end():
    plan = experiment_plan.plan("validation", C180, longest=5.0)
    assert plan.programme.duration == 5.0
    assert excite(START._replace(time=4.5), plan.angles, plan.programme, 0.005)[1] == (0.0, 0.0, 0.0)
