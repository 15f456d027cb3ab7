"""A machine whose numbers nobody told: recorded, identified, driven along a path. Aims of the issue."""

import pytest

pytest.importorskip("llvmlite")

from forest_control.servo.schemes import scheme_named
from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.parameter_path import value_of
from forest_ident.refinement.identification import identify
from forest_ident.report import machine_writer
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import track

UNKNOWN = "unknown:5"


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """What two of its records make of the shipped crane's file."""
    machine = load_machine(UNKNOWN)
    records = [experiment("valve", machine, seed=5), experiment("hose", machine, seed=5, longest=12.0)]
    result = identify(load_machine("c180_hoses"), records)
    return machine_writer.write(result, "c180_hoses", tmp_path_factory.mktemp("unknown") / "identified.yaml")


def rms(model):
    course = path_named("vertical"), 0.5, scheme_named("coordinated")
    return track(*course, load_machine(UNKNOWN), model, adapt=False).total.governed_rms_mm


def test_valve_and_hose_of_a_machine_that_nobody_knows_are_found(identified):
    machine = load_machine(UNKNOWN)
    of_hose = "hose.turbulent_resistance", "hose.inertance", "hose.capacitance"
    for key in ("valve.minimum_resistance", "valve.backward.minimum_resistance", *of_hose):
        assert value_of(identified, key) == pytest.approx(value_of(machine, key), rel=0.01)
    for key in ("valve.deadband_voltage", "valve.backward.deadband_voltage"):
        assert value_of(identified, key) == pytest.approx(value_of(machine, key), abs=0.02)


def test_the_tip_tracks_as_with_the_exact_model(identified):
    assert rms(identified) < 1.3 * rms(load_machine(UNKNOWN))
    assert rms(load_machine("c180_hoses")) > 1.3 * rms(load_machine(UNKNOWN))
