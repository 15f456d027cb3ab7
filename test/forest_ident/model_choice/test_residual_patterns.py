"""Residuals of a fit name the physics that the crane has and the model lacks."""

import functools

import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.model_choice import residual_patterns
from forest_ident.model_choice.candidates import CANDIDATES
from forest_ident.refinement.identification import identify

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
