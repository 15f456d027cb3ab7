import json
import math

import pytest

from forest_description.machine import load_machine
from forest_ident.cli.verbs import main
from forest_ident.validation import unmodelled_effects


@pytest.fixture(scope="module")
def answers():
    return {
        c.name: unmodelled_effects.answer(c, longest=20.0)
        for c in unmodelled_effects.cases(load_machine("c180_hoses"))
    }


def score(answer, axis, signal, way="both"):
    found = [s for s in answer.scores if (s.axis, s.signal, s.way) == (axis, signal, way)]
    assert len(found) == 1
    return found[0]


def test_a_model_that_lacks_nothing_misses_nothing(answers):
    for signal in ("angle", "flow", "driving", "return"):
        assert score(answers["none"], "stick", signal).nrmse < 1e-3


def test_equal_areas_cost_the_angle_too(answers):
    assert score(answers["areas"], "stick", "angle").nrmse > 0.05
    assert score(answers["return_edge"], "stick", "angle").nrmse < 0.05


def test_forces_balance_ties_the_errors_of_both_pressures(answers):
    """A_d dP_d = A_r dP_r: what the model lacks is no force, so neither pressure is off alone."""
    stick = load_machine("c180_hoses").stick
    for way, ratio in (("out", stick.rod_area / stick.head_area), ("in", stick.head_area / stick.rod_area)):
        driving, back = (
            score(answers["return_edge"], "stick", name, way).rms for name in ("driving", "return")
        )
        assert driving / back == pytest.approx(ratio, rel=0.1)


def test_fitted_damping_hides_a_wrong_edge_from_the_driving_pressure(answers):
    before, after = answers["return_edge"], answers["edge_and_damping"]
    assert after.case.model.stick.damping > 1.5 * before.case.model.stick.damping
    assert score(after, "stick", "driving").rms < score(before, "stick", "driving").rms
    assert score(after, "stick", "return").rms > score(before, "stick", "return").rms


def test_the_pendulum_costs_the_swing_most(answers):
    swing, stick = (score(answers["pendulum"], axis, "return").nrmse for axis in ("swing", "stick"))
    assert swing > 2.0 * stick > 0.02


def test_a_valve_that_never_opens_scores_nothing(answers):
    session = answers["none"].session
    shut = unmodelled_effects.scores(
        answers["none"].case.model,
        type(session)(session.name, session.time, 0.0 * session.voltages, session.readings),
        answers["none"].signals,
    )
    assert all(s.rms == 0.0 and math.isfinite(s.nrmse) for s in shut if s.signal == "return")


def test_the_verb_leaves_numbers_and_a_picture(tmp_path, capsys, monkeypatch):
    out, whole = tmp_path / "questions", unmodelled_effects.cases
    monkeypatch.setattr(unmodelled_effects, "cases", lambda machine: whole(machine)[:2])
    assert main(["questions", "--seed", "3", "--out", str(out)]) == 0
    cases = json.loads((out / "questions.json").read_text("utf-8"))["cases"]
    assert list(cases) == ["none", "areas"]
    assert (out / "questions.png").stat().st_size > 10000
    assert "| stick |" in capsys.readouterr().out
    assert main(["questions", "--out", str(out)]) == 1
    assert "exists already" in capsys.readouterr().err
