"""A richer model is kept only if it predicts held-out records better."""

import dataclasses

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.measurements.session import Session
from forest_ident.model_choice import candidates, held_out_comparison
from forest_ident.model_choice.held_out_comparison import Comparison, compare
from forest_ident.validation.prediction_error import Signal

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


def test_a_gain_is_told_in_per_cent_with_its_standard_error():
    said = "squared errors of the held-out records are"
    assert Comparison(0.123, 0.045, 20).told() == f"{said} 12 % lower (standard error 4 %)"
    assert Comparison(-0.4, 0.1, 20).told() == f"{said} 40 % higher (standard error 10 %)"
    assert Comparison(0.0, 0.0, 20).told() == f"{said} 0 % lower (standard error 0 %)"
    assert [Comparison(gain, 0.0, 9).better for gain in (0.0201, 0.0199)] == [True, False]
    assert [Comparison(gain, 0.1, 9).better for gain in (0.201, 0.199)] == [True, False]


def test_a_single_block_tells_no_error(monkeypatch):
    session = Session("validation", np.arange(500) * 0.005, np.zeros((500, 3)), {})

    def told(machine, _session):
        off = np.full(500, 0.5 if machine == "richer" else 1.0)
        return [Signal("boom", "flow", "1", np.zeros(500), off)]

    monkeypatch.setattr(held_out_comparison, "signals", told)
    found = compare("poorer", "richer", [session])  # 2.5 s: a block of 2 s, and a rest that does not count
    assert (found.gain, found.blocks, found.better) == (0.75, 1, False)


def test_without_a_held_out_record_nothing_is_compared():
    with pytest.raises(ValueError, match="no held-out record"):
        compare(PLAIN, dataclasses.replace(PLAIN, name="other"), [])


def test_a_gain_and_its_error_are_mean_and_standard_error_of_the_blocks(monkeypatch):
    """The richer model errs half as much in every second block of 1 s."""
    rows = np.arange(800)
    session = Session("validation", rows * 0.005, np.zeros((800, 3)), {})

    def told(machine, _session):
        off = np.where((rows // 200) % 2, 0.5, 1.0) if machine == "richer" else np.ones(800)
        return [Signal("boom", name, "1", np.zeros(800), off) for name in ("angle", "flow")]

    monkeypatch.setattr(held_out_comparison, "signals", told)
    monkeypatch.setattr(held_out_comparison, "BLOCK", 1.0)
    found = compare("poorer", "richer", [session])
    gains = [0.0, 0.75, 0.0, 0.75]
    assert (found.gain, found.blocks) == (pytest.approx(np.mean(gains)), 4)
    assert found.error == pytest.approx(0.75 / np.sqrt(3.0) / 2.0)
