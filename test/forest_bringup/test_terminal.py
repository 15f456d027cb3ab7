"""A person at a terminal: no answer, an answer typed too early, and what a stop leaves behind."""

import os
import pty
import sys
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_bringup.terminal import NOBODY, Question, ask
from forest_ident.measurements.session import SessionError
from forest_study.experiments import experiment_live, thermocouple_calibration
from forest_study.experiments.forest_ident_main import main


@pytest.fixture
def keyboard(monkeypatch):
    """Standard input as a terminal; gives what types there."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, encoding="utf-8") as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield lambda text: os.write(ours, text)
    os.close(ours)


def test_enter_that_was_pressed_before_a_question_does_not_answer_it(keyboard):
    keyboard(b"\n\n")
    question = Question("Now? ")
    assert not question.answered()
    keyboard(b"\n")
    assert question.answered()


def test_the_end_of_the_input_is_told_in_a_sentence(keyboard, monkeypatch):
    question = Question("Now? ")
    keyboard(b"\x04")
    with pytest.raises(SessionError, match=NOBODY):
        question.answered()
    monkeypatch.setattr("builtins.input", _ended)
    with pytest.raises(SessionError, match=NOBODY):
        ask("Now? ")


def _ended(_question):
    raise EOFError


def test_the_baths_are_changed_when_somebody_says_so_and_the_graph_is_watched_meanwhile(
    keyboard, monkeypatch
):
    now = [0.0]
    monkeypatch.setattr(thermocouple_calibration.time, "monotonic", lambda: now[0])
    asked = thermocouple_calibration.Baths(lambda _time: None, sure=False)
    for now[0] in (0.0, 19.9, 20.1, 300.0):
        asked.watch()  # returns: Ctrl-C and a dead recorder are noticed while the question stands
    assert len(asked.marks) == 1
    keyboard(b"\n")
    asked.watch()
    assert len(asked.marks) == 2
    for now[0] in (300.0, 319.9):
        asked.watch()
    now[0] = 320.1
    with pytest.raises(thermocouple_calibration.Recorded):
        asked.watch()


def test_pauses_in_which_a_machine_shuts_its_valves_are_told(tmp_path, monkeypatch, capsys):
    sent = np.cumsum([0, 5_000_000, 99_000_000, 300_000_000, 5_000_000, 150_000_000])
    monkeypatch.setattr(experiment_live, "read_bag", lambda _bag: SimpleNamespace(sent_ns=lambda _: sent))
    experiment_live._warn_of_pauses(tmp_path, 0.1)
    assert "paused 2 times, for up to 0.30 s" in capsys.readouterr().out
    experiment_live._warn_of_pauses(tmp_path, 0.5)
    assert not capsys.readouterr().out


def test_a_volume_that_no_vessel_holds_is_asked_for_again(keyboard, monkeypatch, capsys, tmp_path):
    answers = iter(["much", "-1", "nan", "0.71"])
    monkeypatch.setattr("builtins.input", lambda _question: next(answers))
    assert experiment_live._vessel(tmp_path) == {"case_drain_volume": 0.71e-3}
    assert capsys.readouterr().out.count("allowed: 0 .. 1000 L") == 3
    monkeypatch.setattr("builtins.input", _ended)
    with pytest.raises(SessionError, match=r"the record is whole, write case_drain_volume into .*yaml"):
        experiment_live._vessel(tmp_path)


@pytest.mark.parametrize(("end", "code"), [(KeyboardInterrupt, 130), (SessionError(NOBODY), 1)])
def test_an_experiment_that_was_not_begun_leaves_no_directory(end, code, tmp_path, monkeypatch, capsys):
    def asked(options):
        options.out.mkdir()
        raise end

    monkeypatch.setattr(experiment_live, "run", asked)
    arguments = ("experiment", "damping_boom", "--live", "--out", str(tmp_path / "out"))
    assert main(arguments) == code
    assert not (tmp_path / "out").exists()
    assert "Traceback" not in capsys.readouterr().err
