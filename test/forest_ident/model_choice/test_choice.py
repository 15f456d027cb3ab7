"""Allowed physics are tried one after the other, and kept if held-out records confirm them."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.parameter_path import with_part
from forest_ident.measurements.session import Session, SessionError
from forest_ident.model_choice import candidates, choice, residual_patterns
from forest_ident.model_choice.choice import chosen
from forest_ident.model_choice.held_out_comparison import Comparison
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement.result import Refined, Result
from forest_ident.report import machine_writer

PLAIN = load_machine("c180_hoses")
SEALED = next(c for c in candidates.CANDIDATES if c.name == "friction").add(PLAIN)


@pytest.fixture(scope="module")
def held_out():
    """A record of a crane with dry friction."""
    return [experiment("validation", SEALED, 3, longest=30.0)]


def refined(name, tests=()):
    """Returns a fitted record that tells nothing."""
    session = Session(name, np.arange(3.0), np.zeros((3, 3)), {})
    return Refined(session, Fit({}, {}, 1.0, EMPTY, {}, {}, 1, {}), (), list(tests))


def told(machine, held_out=(), axes=AXES):
    """Returns a fit of the axes' damping records that believes its start."""
    records = [refined(f"damping_{axis}") for axis in axes]
    return Result(machine, machine, held_out=list(held_out), refined=records)


def test_the_confirmed_physics_are_kept_and_the_others_are_not(held_out, tmp_path):
    found = chosen(PLAIN, lambda start: told(start, held_out), ["hysteresis", "friction"])
    assert found.machine == SEALED
    kept, refused = found.remarks
    assert kept.startswith("--allow friction: dry friction, kept: ")
    assert refused.startswith("--allow hysteresis: ")
    assert ", not kept: " in refused
    written = machine_writer.write(found, "c180_hoses", tmp_path / "mine.yaml", {})
    assert written.boom.friction == SEALED.boom.friction
    assert written.swing.friction == SEALED.swing.friction
    assert written.valve == PLAIN.valve


def test_what_the_start_has_is_not_added_again(held_out):
    found = chosen(SEALED, lambda start: told(start, held_out), ["friction"])
    assert found.remarks == ["--allow friction: the start has dry friction already"]


def test_friction_is_added_on_the_axes_of_which_a_record_tells_alone(monkeypatch):
    monkeypatch.setattr(choice, "compare", lambda *_machines: Comparison(0.5, 0.1, 20))
    found = chosen(PLAIN, lambda start: told(start, axes=["boom"]), ["friction"])
    assert found.machine == with_part(PLAIN, "boom.friction", SEALED.boom.friction)
    assert found.remarks[0].endswith(
        "; these records cannot tell it of swing and stick: it takes damping_swing and damping_stick"
    )
    untold = chosen(PLAIN, lambda start: told(start, axes=[]), ["friction"])
    assert untold.machine == PLAIN
    assert untold.remarks[0].startswith("--allow friction: dry friction; these records cannot tell it of sw")


def with_stranger(machine, held_out=(), times=400.0):
    """Returns a fit of which one record is not explained, as others are."""
    found = told(machine, held_out)
    found.stranger = "" if machine.boom.friction is not None else "damping_boom"
    found.remarks = ["damping_boom: the model does not explain this record: 1 Pa are left."]
    left = ResidualTest("boom_resolver", times * 1e-3, times, 1000, 0.9)
    found.refined = [refined(f"damping_{axis}", [left] if axis == "boom" else []) for axis in AXES]
    return found


def test_a_record_that_contradicts_the_others_does_not_take_the_allowed_physics_their_turn(held_out):
    assert chosen(PLAIN, lambda start: with_stranger(start, held_out), ["friction"]).machine == SEALED


def test_a_stranger_by_far_that_looks_like_no_physics_is_refused_and_another_is_kept(monkeypatch):
    with pytest.raises(SessionError, match=r"damping_boom: the model does not explain .* leave this one out"):
        chosen(PLAIN, with_stranger, [])
    assert chosen(PLAIN, lambda start: with_stranger(start, times=150.0), []).stranger == "damping_boom"
    named = residual_patterns.Finding("damping_boom", candidates.CANDIDATES[0], 0.8, 1.0)
    monkeypatch.setattr(residual_patterns, "findings", lambda _result: [named])
    assert chosen(PLAIN, with_stranger, []).remarks[-1] == named.sentence()


def test_a_model_that_cannot_be_fitted_or_compared_is_not_kept_and_says_why():
    short = Session("validation", np.arange(3.0), np.zeros((3, 3)), {})

    def identify(machine):
        if machine.boom.friction is not None:
            raise SessionError("damping_boom: it cannot be evaluated")
        return told(machine, [short])

    best = chosen(PLAIN, identify, ["friction", "pendulum"])
    assert best.machine == PLAIN
    friction, pendulum = best.remarks
    assert friction == "--allow friction: dry friction, not kept: damping_boom: it cannot be evaluated"
    assert pendulum.startswith("--allow pendulum: a head that hangs, not kept: validation: too short")
