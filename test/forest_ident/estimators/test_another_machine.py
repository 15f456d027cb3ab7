"""A crane of another class: no flow meters, no inclinometer, a load-sensing pump, a measured curve."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.output_error.prediction import predict
from forest_ident.refinement import linear_estimates, refinement, refinement_task
from forest_ident.refinement.identification import identify
from forest_ident.refinement.result import unidentified


@pytest.fixture(scope="module")
def loader():
    return load_machine("loader")


@pytest.fixture(scope="module")
def valve(loader):
    return experiment("valve_swing", loader, seed=1)


@pytest.fixture(scope="module")
def creep(loader):
    return experiment("motor_internal", loader, seed=1, longest=5.0)


def test_a_bench_is_judged_by_its_own_meters(loader, valve):
    """The crane has no flow meter: the floor of the bench's is no flow for all that."""
    found = {e.key: e.value for e in identify(loader, [valve], refine=False).linear}
    for way in ("", "backward."):
        assert found[f"swing.valve.{way}deadband_voltage"] == pytest.approx(0.9, abs=0.02)
        gain = found[f"swing.valve.{way}minimum_resistance"]
        assert gain == pytest.approx(loader.swing.valve.minimum_resistance, rel=0.02)


def test_a_load_sensing_pump_is_sought_by_its_margin(loader, valve):
    """No experiment loads it up to the pressure that it keeps at most: that stays as stated, and is said."""
    free = refinement_task.task(loader, valve).free
    assert "pump.margin" in free
    assert "pump.supply_pressure" not in free
    assert (
        "against its end"
        in dict(unidentified(identify(loader, [valve], refine=False)))["pump.supply_pressure"]
    )


@pytest.mark.parametrize("name", ["hose", "damping_boom"])
def test_all_that_is_found_of_a_valve_goes_along(loader, name):
    """What is held at an estimate makes the rest wrong and too sure."""
    found = refinement_task.task(loader, experiment("valve", loader, longest=3.0)).free
    later = refinement_task.task(loader, experiment(name, loader, longest=3.0))
    assert set(found) <= {*later.free, *later.carried}


@pytest.mark.parametrize(("axis", "other"), [("boom", "stick"), ("stick", "boom")])
def test_boom_and_stick_shake_each_other_and_carry_each_others_damping(axis, other):
    """Held at the start's, 40 % off, it asked for stated numbers eight standard deviations away."""
    crane, key = load_machine("c180_hoses"), f"{other}.damping"
    session = experiment(f"damping_{axis}", crane, longest=6.0)
    assert key in refinement_task.task(crane, session).carried
    stiff = with_values(crane, {key: 1.4 * value_of(crane, key)})
    one, two = (predict(m, session)[f"{axis}_pressure_1_actuator"] for m in (crane, stiff))
    assert np.sqrt(np.mean((one - two) ** 2)) > crane.sensors.pressure.noise


def test_a_tilt_without_inclinometer_is_told_by_the_plan(loader, creep):
    tilted = refinement.prepared(loader, creep)
    assert tilted.manipulator.platform_tilt == pytest.approx(experiment_plan.TILT)


def test_the_pressures_that_a_record_began_with_are_sought(loader, creep):
    """Behind a shut valve they last: a transducer's offset of 0.08 MPa would become leakage."""
    tilted, begun = refinement.prepared(loader, creep), {"swing_pressure_1_actuator": 1e5}
    one, other = (predict(tilted, creep, start=by)["swing_pressure_1_actuator"] for by in ({}, begun))
    assert other[0] - one[0] == pytest.approx(1e5)
    of_a_tape = {"manipulator.boom_length": 0.005}  # that the load chart's reach has no room for
    measured = linear_estimates.with_measured_hose(loader, 0)
    _, fit = refinement.refine(measured, creep, EMPTY, errors=of_a_tape)
    assert fit.posterior.slopes is not None
    assert any(key.startswith("start.swing_pressure_1") for key in fit.values)


def test_a_warning_goes_when_a_later_record_tells():
    wide = Estimate("pump.margin", 2e6, 1e6, "Pa", 10.0, "test").checked()
    assert "cannot tell" in wide.warning
    assert wide._replace(standard_error=1e3).checked().warning == ""


def test_a_curve_below_the_meters_floor_leaves_the_overlap_open(loader):
    """The stick's curve has its first knots below the floor, and the file tells them in volts."""
    session = experiment("valve_stick", load_machine("unknown:3:loader"), seed=3)
    found = identify(loader, [session])
    overlap = found.estimates["stick.valve.deadband_voltage"]
    assert "cannot tell" in overlap.warning
    assert overlap.value < loader.stick.valve.curve.voltages[0]
    assert overlap.contains(1.394)


def test_dry_friction_that_the_file_tells_is_no_damping(loader):
    """The search starts here, and the boom's record feels what is held of the stick's damping."""
    session = experiment("damping_boom", loader, longest=15.0)
    found = identify(loader, [session], refine=False).estimates["boom.damping"]
    assert found.value == pytest.approx(loader.boom.damping, rel=0.25)
    assert loader.boom.friction.coulomb_force > 0.0
