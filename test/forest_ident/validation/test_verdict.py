"""The verdict names what is not to be trusted, and why; a machine's own record says trusted."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.cli import fit_tables
from forest_ident.estimators.parameter_estimate import Estimate, unit_of
from forest_ident.measurements.session import Session
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement import data_quality
from forest_ident.refinement.result import Doubt, Refined, Result
from forest_ident.report import machine_writer
from forest_ident.validation.prediction_error import Signal, over_limit
from forest_ident.validation.verdict import BUT_FOR, NOT_TRUSTED, TRUSTED, verdict

C180 = load_machine("c180_hoses")
KEYS = ("boom.damping", "stick.damping", "boom.rod_area")
FIT = Fit({}, {}, 1.0, EMPTY, {}, {}, 1, {})
SESSION = Session("damping_boom", np.arange(3.0), np.zeros((3, 3)), {})


def result_with(tests=(), **changes):
    """Return a result of three dampings, one changed, whose record left some residuals."""
    estimates = {key: Estimate(key, 0.013, 1e-5, unit_of(key), 1.0, "output error") for key in KEYS}
    estimates[KEYS[0]] = estimates[KEYS[0]]._replace(**changes)
    result = Result(C180, C180, estimates=estimates)
    return refined(result, FIT, tests)


def refined(result, fit, tests=()):
    """Return the result with a record of that fit."""
    result.refined = [Refined(SESSION, fit, KEYS[:1], list(tests))]
    why = data_quality.doubt(SESSION, fit, tests, list(result.stated))
    result.doubts = [Doubt(why, KEYS[:1], frozenset(KEYS[:1]))] if why else []
    return result


def left(times, correlation):
    return ResidualTest("boom_resolver", 1e-3, times, 1000, correlation)


def test_white_residuals_at_the_sensors_noise_are_trusted():
    said = verdict(result_with([left(1.1, 0.02)]))
    assert (said.code, said.lines) == (TRUSTED, ["trusted"])


def test_correlated_residuals_above_the_noise_are_a_doubt_of_what_their_record_found():
    said = verdict(result_with([left(2.0, 0.6)]))
    assert said.code == BUT_FOR
    assert said.lines[0] == "trusted but for boom.damping"
    assert "2.0 times the noise of boom_resolver and correlated (0.60)" in said.doubts["boom.damping"]
    assert verdict(result_with([left(2.0, 0.1)])).code == TRUSTED
    assert verdict(result_with([left(1.2, 0.6)])).code == TRUSTED


def test_a_withheld_interval_is_a_doubt_and_most_of_them_are_no_trust():
    result = result_with(withheld=True)
    assert list(verdict(result).doubts) == ["boom.damping"]
    result.estimates = {key: e._replace(withheld=True) for key, e in result.estimates.items()}
    said = verdict(result)
    assert said.code == NOT_TRUSTED
    assert "3 of 3 intervals are withheld" in said.lines[1]


def test_what_is_impossible_or_failed_or_loose_is_a_doubt():
    result = result_with(warning="the data cannot tell it")
    result.impossible, result.failed = ["hose.inertance"], {"damping_stick": ("stick.damping",)}
    assert set(verdict(result).doubts) == {"boom.damping", "hose.inertance", "stick.damping"}


def test_linear_estimates_alone_are_not_trusted():
    result = result_with()
    result.refined = []
    assert verdict(result).lines[:2] == ["not trusted", "linear estimates alone: no residual was tested"]


def signal(wrong):
    measured = np.linspace(0.0, 1.0, 101)
    return Signal("boom", "angle", "rad", measured, measured + wrong)


def test_a_held_out_record_that_is_missed_is_no_trust():
    assert over_limit([signal(0.01)]) == []
    said = verdict(result_with(), [("validation", [signal(0.03)])])
    assert said.code == NOT_TRUSTED
    assert said.lines[1] == "validation: boom angle is 3.0 % off, limit 2 %"


def test_a_held_out_record_that_cannot_be_predicted_is_no_trust():
    said = verdict(result_with(), [("validation", [])])
    assert (said.code, said.lines[1]) == (NOT_TRUSTED, "validation: held out, but it cannot be predicted")
    assert verdict(result_with(), [("motion", [])]).code == TRUSTED
    assert over_limit([signal(np.nan)]) == ["boom angle is nan % off, limit 2 %"]


def test_one_record_that_contradicts_all_others_is_a_stranger_and_two_are_a_model_that_lacks_something():
    good, bad = [left(1.0, 0.0)], [left(40.0, 0.9)]
    records = {"valve": good, "hose": good, "damping_swing": good, "damping_boom": bad}
    assert data_quality.stranger(records) == "damping_boom"
    assert data_quality.stranger({**records, "gravity": bad}) == ""
    assert data_quality.stranger({"valve": good, "damping_boom": bad}) == ""


def test_a_record_that_contradicts_the_others_is_no_trust():
    result = result_with()
    result.stranger = "damping_boom"
    said = verdict(result)
    assert (said.code, said.lines[1][:38]) == (NOT_TRUSTED, "damping_boom: it alone is not explaine")


def test_a_search_that_was_broken_off_is_a_doubt_of_what_it_looked_for():
    said = verdict(refined(result_with(), FIT._replace(converged=False, iterations=20)))
    assert (said.code, list(said.doubts)) == (BUT_FOR, ["boom.damping"])
    assert "broken off after 20 steps" in said.lines[1]


def test_a_record_that_asks_for_more_than_a_person_may_have_told_wrong_is_a_doubt_of_what_it_found():
    result = result_with()
    result.stated = {"boom.rod_area": 1e-5, "stick.rod_area": 1e-5}

    def said(asked):
        return verdict(refined(result, FIT._replace(asked=np.array([0.5, asked]))))

    assert list(said(-12.4).doubts) == ["boom.damping"]
    assert "asks for stick.rod_area 12 standard deviations from what is told" in said(-12.4).lines[1]
    assert said(2.5).code == TRUSTED


@pytest.mark.parametrize("withheld", [False, True])
def test_the_sources_of_a_machine_file_say_so(withheld, tmp_path):
    result = result_with(withheld=withheld)
    machine_writer.write(result, "c180_hoses", tmp_path / "found.yaml", {"stick.damping": 'why "not"'})
    text = (tmp_path / "found.yaml").read_text()
    assert ("95 % interval withheld" in text) == withheld
    assert "not trusted: why 'not'" in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["found.yaml"]


def test_a_doubt_of_a_stated_number_stands_with_it_and_not_in_the_verdict(tmp_path):
    result = result_with()
    stick = "manipulator.stick_mass"
    result.told = {stick: Estimate(stick, 560.0, 9.0, "kg", 1.0, "output error", False, "a reason")}
    result.doubts = [Doubt("a reason", (KEYS[0], stick), frozenset())]
    assert verdict(result).lines[0] == "trusted but for boom.damping"
    machine_writer.write(result, "c180_hoses", tmp_path / "mine.yaml")
    (line,) = [x for x in (tmp_path / "mine.yaml").read_text().splitlines() if "stick_mass" in x]
    assert "542.36 .. 577.64; not trusted: a reason" in line
    assert fit_tables.text_table(result).count("warning: a reason") == 1
