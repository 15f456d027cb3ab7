"""Residuals of a fit name the physics that the crane has and the model lacks."""

import functools

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.session import Session
from forest_ident.model_choice import residual_patterns
from forest_ident.model_choice.candidates import CANDIDATES
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement.identification import identify
from forest_ident.refinement.result import Refined, Result

PLAIN = load_machine("c180_hoses")


@functools.cache
def fitted(name, record):
    """Returns the plain model's fit to a record of the crane with one candidate's physics."""
    crane = next((c.add(PLAIN) for c in CANDIDATES if c.name == name), PLAIN)
    return identify(PLAIN, [experiment(record, crane, 5, longest=10.0)])


@pytest.mark.parametrize(("name", "record"), [("friction", "damping_boom"), ("hysteresis", "spool_lag")])
def test_what_the_model_lacks_is_named_with_what_to_try(name, record):
    found = residual_patterns.findings(fitted(name, record))
    assert [(one.record, one.candidate.name) for one in found] == [(record, name)]
    assert found[0].sentence().startswith(f"{record}: ")
    assert found[0].sentence().endswith(f"try `--allow {name}`")


def test_the_size_is_told_over_the_usual_one():
    (refined,) = fitted("friction", "damping_boom").refined
    friction = next(
        one for one in residual_patterns.ranking(PLAIN, refined) if one.candidate.name == "friction"
    )
    assert friction.size == pytest.approx(1.0, abs=0.3)


def test_a_record_that_the_model_explains_names_nothing():
    assert residual_patterns.findings(fitted("nothing", "spool_lag")) == []


def test_a_share_is_told_in_per_cent():
    finding = residual_patterns.Finding("damping_boom", CANDIDATES[0], 0.634, 1.0)
    assert finding.sentence().startswith("damping_boom: 63 % of what the model leaves over looks like dry ")


def test_what_offsets_and_known_numbers_explain_is_taken_out_of_a_row():
    offsets = residual_patterns._offsets([np.array([True, False, True]), np.array([True, True, True])])
    assert [row.tolist() for row in offsets] == [[1, 1, 0, 0, 0], [0, 0, 1, 1, 1]]
    slope = np.array([0.0, 0.0, -1.0, 0.0, 1.0])
    rest = residual_patterns._without(np.array([*offsets, slope, 1e-12 * slope]))
    row = np.array([3.0, 5.0, 1.0, 7.0, 1.0])
    assert rest(row) == pytest.approx([-1.0, 1.0, -2.0, 4.0, -2.0])
    assert rest(4.0 * slope + 2.0) == pytest.approx(np.zeros(5), abs=1e-12)
    assert residual_patterns._without(np.zeros((1, 5)))(row) == pytest.approx(row)


def test_a_number_is_moved_by_a_hundredth_and_zero_by_0_01():
    damping = PLAIN.boom.damping
    assert residual_patterns._moved(PLAIN, "boom.damping") == pytest.approx(1.01 * damping)
    flat = PLAIN.manipulator.platform_tilt
    assert flat == 0.0
    assert residual_patterns._moved(PLAIN, "manipulator.platform_tilt") == 0.01


def left(times, ranked, monkeypatch):
    """What is named of a record so many times above its noise, and how far it is above."""
    tests = [ResidualTest("boom_resolver", 1.0, t, 100, 0.0) for t in times]
    session = Session("damping_boom", np.arange(3.0), np.zeros((3, 3)), {})
    record = Refined(session, Fit({}, {}, 1.0, EMPTY, {}, {}, 1, {}), (), tests)
    monkeypatch.setattr(residual_patterns, "ranking", lambda *_: ranked)
    return residual_patterns.findings(Result(PLAIN, PLAIN, refined=[record])), residual_patterns.times_noise(
        record
    )


def test_the_best_of_a_usual_size_is_named_if_it_explains_three_tenths(monkeypatch):
    def finding(share, size, place=0):
        return residual_patterns.Finding("damping_boom", CANDIDATES[place], share, size)

    usual, strange = finding(0.31, 0.11), finding(0.9, 10.1, 1)
    assert left((1.0, 1.51), [strange, usual, finding(0.3, 1.0, 2)], monkeypatch) == ([usual], 1.51)
    assert left((1.5,), [usual], monkeypatch) == ([], 1.5)
    assert left((9.0,), [finding(0.29, 1.0)], monkeypatch)[0] == []
    assert left((9.0,), [finding(0.9, 0.09)], monkeypatch)[0] == []
    assert left((9.0,), [finding(0.9, 9.9)], monkeypatch)[0] != []
    assert left((), [usual], monkeypatch) == ([], 0.0)
