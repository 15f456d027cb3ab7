"""Stated numbers carry an uncertainty: a wrong one is within the intervals of what is found with it."""

import numpy as np
import pytest

from forest_description.machine import load_machine, uncertainties
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators.parameter_estimate import NORMAL_95, Estimate
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.measurements.session import SessionError
from forest_ident.output_error.fit_problem import Channel, Unknown
from forest_ident.output_error.gaussian_estimate import GaussianEstimate
from forest_ident.output_error.output_error import fit
from forest_ident.refinement import stated_numbers
from forest_ident.refinement.identification import identify

C180 = load_machine("c180_hoses")
STICK = "manipulator.stick_mass"
MASSES = ("manipulator.head_mass", "manipulator.boom_mass")
HEAVY = with_values(C180, {STICK: 720.0, "manipulator.head_mass": 850.0})


@pytest.fixture(scope="module")
def found():
    """Masses of a crane whose stick of 720 kg is told as 544 kg, give or take 220 kg."""
    return identify(C180, [experiment("gravity", HEAVY, 3, longest=12.0)], stated={STICK: 220.0})


def test_a_stick_that_is_told_wrong_is_within_the_intervals_of_the_masses(found):
    for key in MASSES:
        e = found.estimates[key]
        assert e.contains(value_of(HEAVY, key)), (key, e.value, e.interval)


def test_the_table_says_how_much_of_an_interval_was_told_and_by_what(found):
    head = found.estimates["manipulator.head_mass"]
    assert head.stated > 0.9
    assert head.most == STICK


def test_a_file_may_state_an_uncertainty_and_it_counts_as_the_default_would(tmp_path):
    file = tmp_path / "weighed.yaml"
    quantity = '{value: 544, unit: kg, source: "weighed", uncertainty: 11}'
    file.write_text(f"based_on: c180_hoses\nmanipulator:\n  stick_mass: {quantity}\n")
    stated = uncertainties(file)
    assert stated == {STICK: 11.0}
    machine = load_machine(file)
    assert stated_numbers.errors(machine, stated)[STICK] == pytest.approx(11.0 / NORMAL_95)
    assert stated_numbers.errors(machine, {})[STICK] == pytest.approx(0.2 * 544.0 / NORMAL_95)


def test_an_uncertainty_that_makes_no_machine_is_refused_by_name():
    wide = {"boom.rod_area": 0.05}
    with pytest.raises(
        SessionError, match=r"boom\.rod_area: its uncertainty is too wide.*head_area.*smaller one"
    ):
        stated_numbers.errors(C180, wide)
    assert stated_numbers.errors(C180, {"boom.rod_area": 0.005})["boom.rod_area"] > 0.0


def test_a_told_number_adds_its_share_to_the_error():
    known = GaussianEstimate(("a",), np.zeros(1), np.array([[16.0]]), np.array([[0.0, 3.0]]))
    e = Estimate("a", 100.0, 4.0, "kg", 1.0, "test", positive=False)
    with_stated = stated_numbers.with_stated(e, known, ["areas", "stick"])
    assert with_stated.standard_error == pytest.approx(5.0)
    assert with_stated.stated == pytest.approx(9.0 / 25.0)
    assert with_stated.most == "stick"


def line(values):
    """Return a slope times the time, plus a told step at its end that no record tells apart."""
    time = np.linspace(0.0, 1.0, 400)
    return {"y": values["slope"] * time + values.get("told", 0.0) * (time > 0.5)}


def test_a_plant_that_answers_with_chance_is_not_taken_for_one_that_feels_a_told_number():
    def sticking(values):  # one event falls to another row as soon as anything differs
        moved = values != {"slope": values["slope"]} or abs(values["slope"] - 2.0) > 1e-9
        return {"y": line(values)["y"] + 0.02 * moved * (np.arange(400) == 200)}

    unknown, channel = Unknown("slope", 2.0, positive=False), Channel("y", 0.01)
    measured = {"y": line({"slope": 2.0})["y"]}
    felt, stuck = (
        fit(model, measured, [channel], [unknown], stated=[{"told": 0.005}]).posterior.slopes
        for model in (line, sticking)
    )
    assert felt is not None
    assert stuck == pytest.approx(felt, rel=0.3)


def test_an_estimate_moves_with_a_told_number_as_a_fit_with_another_one_does():
    generator = np.random.default_rng(4)
    measured = {"y": line({"slope": 2.0})["y"] + generator.normal(0.0, 0.01, 400)}
    unknown, channel = Unknown("slope", 1.0, positive=False), Channel("y", 0.01)
    sd = 0.05
    one = fit(line, measured, [channel], [unknown], stated=[{"told": sd}])
    other = fit(lambda v: line({**v, "told": sd}), measured, [channel], [unknown])
    moved = other.values["slope"] - one.values["slope"]
    assert one.posterior.slopes == pytest.approx(np.array([[moved]]), rel=1e-3)
    left = line({"slope": moved, "told": sd})["y"]
    assert one.stated_noise["y"] == pytest.approx(float(np.sqrt(np.mean(left**2))), rel=0.02)
    again = fit(line, measured, [channel], [unknown], prior=one.posterior, stated=[{}])
    assert again.posterior.slopes == pytest.approx(0.5 * one.posterior.slopes, rel=0.1)  # it does not feel it
