"""Stated numbers carry an uncertainty: a wrong one is within the intervals of what is found with it."""

import re

import numpy as np
import pytest

from forest_description.machine import load_machine, uncertainties
from forest_ident.cli import fit_tables
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators.parameter_estimate import NORMAL_95, Estimate
from forest_ident.measurements.parameter_path import value_of, with_directions, with_values
from forest_ident.measurements.session import SessionError
from forest_ident.output_error.fit_problem import Channel, Fit, Unknown
from forest_ident.output_error.gaussian_estimate import EMPTY, GaussianEstimate
from forest_ident.output_error.output_error import fit
from forest_ident.refinement import refinement, stated_numbers
from forest_ident.refinement.identification import identify
from forest_ident.refinement.refinement_task import INERTIAS
from forest_ident.report import machine_writer

C180 = load_machine("c180_hoses")
STICK, BASE = "manipulator.stick_mass", "manipulator.base_offset"
MASSES = ("manipulator.head_mass", "manipulator.boom_mass")
HEAVY = with_values(C180, {STICK: 720.0, "manipulator.head_mass": 850.0})
WRONG = {STICK: 590.0, "boom.head_area": 1.006 * C180.boom.head_area, "manipulator.boom_x": 1.95}


def factored(machine, factor):
    return stated_numbers.with_inertias(machine, {"boom": factor})


@pytest.fixture(scope="module")
def found():
    """What 12 s of a crane tell of which a stick, an area, a centre and moments of inertia are told wrong."""
    crane = factored(with_values(C180, WRONG), 1.06)
    return identify(C180, [experiment("gravity", crane, 3, longest=12.0)])


def test_a_stick_that_is_told_wrong_by_far_is_within_the_intervals_of_the_masses():
    record = experiment("gravity", HEAVY, 3, longest=12.0)
    estimates = identify(C180, [record], stated={STICK: 220.0}).estimates
    for key in MASSES:
        e = estimates[key]
        assert e.contains(value_of(HEAVY, key)), (key, e.value, e.interval)


def test_a_crane_that_does_not_stick_tells_its_stated_numbers(found):
    told = {key: e for key, e in found.told.items() if key not in INERTIAS}
    assert told.keys() | INERTIAS == found.stated.keys() - {"swing.motor_displacement", BASE}
    for key, e in told.items():
        assert e.contains(WRONG.get(key, value_of(C180, key))), (key, e.value, e.interval)
    assert found.told["boom.inertia"].contains(1.06)
    assert set(found.told) <= set(found.known.names)  # later records take them along
    assert found.told[STICK].standard_error < 0.3 * found.stated[STICK]
    assert found.told[STICK].value == pytest.approx(WRONG[STICK], rel=0.02)  # told as 544


def test_the_file_holds_them_with_the_masses_that_go_with_them(found, tmp_path):
    machine = machine_writer.write(found, "c180_hoses", tmp_path / "found.yaml")
    assert value_of(machine, STICK) == pytest.approx(found.told[STICK].value, rel=1e-8)
    factor = found.told["boom.inertia"].value
    assert abs(factor - 1.0) > 1e-3
    for one in (machine, found.machine):
        assert one.manipulator.boom_zz == pytest.approx(factor * C180.manipulator.boom_zz, rel=1e-8)
        assert one.stick.rod_area == pytest.approx(found.told["stick.rod_area"].value, rel=1e-8)
    line = next(x for x in (tmp_path / "found.yaml").read_text().splitlines() if "boom_zz" in x)
    assert re.search(r"95 % interval \d+.*variance from stated numbers", line)


def test_the_table_says_how_much_of_an_interval_was_told_and_by_what(found):
    rows = fit_tables.text_table(found).partition("stated numbers as the records have them")[2]
    (row,) = [row for row in rows.splitlines() if row.startswith(f"  {STICK} ")]
    e = found.told[STICK]
    assert f"{100.0 * e.stated:.0f} %" in row
    assert row.endswith(f"kg ({e.most})")
    assert found.told["manipulator.boom_x"].stated > 0.9 > 0.1 > found.told["boom.pivot_to_base"].stated


def test_a_share_is_what_wrong_stated_numbers_would_have_made_of_a_variance():
    """A reading of a + t, noise 4, with t told to 3 and u, that nothing feels, to 5."""
    rows = np.array([[25.0, -9.0, 0.0], [-9.0, 9.0, 0.0], [0.0, 0.0, 25.0]])
    known = GaussianEstimate(("a", "t", "u"), np.zeros(3), rows)
    e = Estimate("a", 100.0, 5.0, "kg", 1.0, "test", positive=False)
    a, t = (stated_numbers.shared(e._replace(key=key), known, {"u": 5.0, "t": 3.0}) for key in ("a", "t"))
    assert (a.standard_error, a.stated, a.most) == (5.0, pytest.approx(9.0 / 25.0), "t")
    assert (t.stated, t.most) == (pytest.approx(1.0), "t")  # it is known by what was told alone


@pytest.mark.parametrize(("name", "told"), [("c180_hoses", True), ("c180", False)])
def test_stated_numbers_are_unknowns_where_no_axis_sticks(monkeypatch, name, told):
    """Where one does they move the estimates: its derivatives are not as fine as they need."""
    machine, asked = with_directions(load_machine(name), "valve"), {}

    def fit(_model, _measured, _channels, unknowns, _progress, **rest):
        asked.update(rest, unknowns={u.key: u for u in unknowns})
        return Fit({STICK: value_of(machine, STICK) + 109.0}, {}, 1.0, EMPTY, {}, {}, 1, {})

    monkeypatch.setattr(refinement, "fit", fit)
    record = experiment("gravity", machine, 3, longest=4.0)
    _, done = refinement.refine(machine, record, EMPTY, errors={STICK: 54.5})
    unknowns = asked["unknowns"]
    assert (STICK in unknowns, "start.boom_resolver.gravity" in unknowns) == (told, told)
    assert len(asked["stated"]) == (0 if told else 1)
    assert (asked["rough"] is None) == told  # changes are the exact model's
    like = ("start.boom_resolver.gravity", "boom_resolver") if told else None
    assert unknowns["boom.angle"].like == like  # a start that is no unknown has no derivative
    if told:
        assert unknowns[STICK].difference == pytest.approx(1e-5 * 54.5)
        assert unknowns["boom.angle"].difference == pytest.approx(1e-5)
        assert done.asked == pytest.approx([2.0])


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
    small = known._replace(covariance=1e-8 * known.covariance, slopes=1e-4 * known.slopes)
    assert stated_numbers.with_stated(
        e._replace(standard_error=4e-4), small, ["areas", "stick"]
    ).standard_error == pytest.approx(5e-4)
    positive = stated_numbers.with_stated(
        e._replace(positive=True, standard_error=400.0), known, ["areas", "stick"]
    )
    assert positive.standard_error == pytest.approx(500.0)  # slopes are of its logarithm
    assert stated_numbers.with_stated(e, known._replace(slopes=None), ["areas", "stick"]) == e


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
