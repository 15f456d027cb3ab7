"""A richer model is kept only if it predicts held-out records better."""

import dataclasses

import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.model_choice import candidates
from forest_ident.model_choice.held_out_comparison import Comparison, compare

PLAIN = load_machine("c180_hoses")
RICH = {c.name: c.add(PLAIN) for c in candidates.CANDIDATES}


@pytest.fixture(scope="module")
def seals_record():
    """A held-out record of a crane whose seals are half as strong again as usual ones."""
    crane = RICH["friction"]
    keys = [
        f"{axis}.friction.{part}_force" for axis in ("boom", "stick") for part in ("breakaway", "coulomb")
    ]
    crane = with_values(crane, {key: 1.5 * value_of(crane, key) for key in keys})
    return experiment("validation", crane, 3, longest=16.0)


def test_physics_that_the_crane_has_are_kept(seals_record):
    found = compare(PLAIN, RICH["friction"], [seals_record])
    assert found.better
    assert 0.3 < found.gain < 1.0


def test_physics_that_the_crane_lacks_are_not_kept(seals_record):
    assert not compare(PLAIN, RICH["hysteresis"], [seals_record]).better
    assert not compare(RICH["friction"], RICH["friction"], [seals_record]).better


def test_a_gain_within_its_error_is_no_gain():
    assert Comparison(0.3, 0.1, 8).better
    assert not Comparison(0.3, 0.2, 8).better
    assert not Comparison(0.01, 0.001, 8).better


def test_without_a_held_out_record_nothing_is_compared():
    with pytest.raises(ValueError, match="no held-out record"):
        compare(PLAIN, dataclasses.replace(PLAIN, name="other"), [])
