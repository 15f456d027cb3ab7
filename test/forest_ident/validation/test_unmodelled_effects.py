import json
import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.cli.verbs import main
from forest_ident.measurements.session import Session, SessionError
from forest_ident.validation import unmodelled_effects
from forest_ident.validation.prediction_error import Signal


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


def test_each_case_lacks_one_effect_of_its_size():
    machine = load_machine("c180_hoses")
    cases = {c.name: c for c in unmodelled_effects.cases(machine)}
    assert [(name, c.refit) for name, c in cases.items()] == [
        ("none", False),
        ("areas", False),
        ("return_edge", False),
        ("edge_and_damping", True),
        ("seals", False),
        ("pendulum", False),
    ]
    assert cases["none"].crane == cases["none"].model == machine
    boom = cases["areas"].model.boom
    assert boom.rod_area == pytest.approx(0.5 * (machine.boom.head_area + machine.boom.rod_area))
    assert boom.head_area == pytest.approx(boom.rod_area, rel=1e-5)
    for name in ("return_edge", "edge_and_damping"):
        assert cases[name].crane.valve.port_2_area == pytest.approx(0.9 * machine.valve.port_2_area)
        assert cases[name].model == machine
    for axis in ("boom", "stick"):
        seals, head = getattr(cases["seals"].crane, axis).friction, getattr(machine, axis).head_area
        assert (seals.coulomb_force, seals.breakaway_force) == pytest.approx((1.5e5 * head, 2.25e5 * head))
        assert (seals.stribeck_speed, seals.smoothing_speed) == (0.012, 0.002)
    rubbing = load_machine("loader")
    more = unmodelled_effects._with_seals(rubbing).boom.friction
    assert more.coulomb_force - rubbing.boom.friction.coulomb_force == pytest.approx(
        1.5e5 * rubbing.boom.head_area
    )
    hanging = cases["pendulum"].crane.manipulator.pendulum
    assert (hanging.length, hanging.inertia, hanging.damping) == (0.9, 60.0, 250.0)


def test_scores_are_of_the_port_that_drives_and_of_the_one_that_returns_by_the_way_the_valve_is_open():
    machine, rows = load_machine("c180_hoses"), 4
    edge = machine.valve.law
    volts = np.zeros((rows, 3))
    volts[:, 1] = (
        edge.forward.deadband_voltage + 0.01,
        edge.forward.deadband_voltage - 0.01,
        -edge.backward.deadband_voltage - 0.01,
        -edge.backward.deadband_voltage + 0.01,
    )
    session = Session("validation", np.arange(rows) * 0.005, volts, {})
    one, two = np.array([10.0, 0.0, 20.0, 0.0]), np.array([30.0, 0.0, 50.0, 0.0])
    signals = [
        Signal("boom", "angle", "rad", np.array([0.0, 1.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0, 6.0])),
        Signal("boom", "pressure 1", "Pa", one, one - np.array([1.0, 9.0, 2.0, 9.0])),
        Signal("boom", "pressure 2", "Pa", two, two - np.array([3.0, 9.0, 4.0, 9.0])),
    ]
    found = {(s.signal, s.way): (s.rms, s.span) for s in unmodelled_effects.scores(machine, session, signals)}
    assert found == {
        ("angle", "both"): (1.0, 4.0),
        ("driving", "both"): (pytest.approx(math.sqrt((1.0 + 16.0) / 2.0)), 40.0),
        ("return", "both"): (pytest.approx(math.sqrt((9.0 + 4.0) / 2.0)), 10.0),
        ("driving", "out"): (1.0, 0.0),
        ("driving", "in"): (4.0, 0.0),
        ("return", "out"): (3.0, 0.0),
        ("return", "in"): (2.0, 0.0),
    }
    with pytest.raises(SessionError, match="the questions need pressures at both ports of the boom"):
        unmodelled_effects.scores(machine, session, signals[:2])
