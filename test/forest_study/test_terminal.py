"""A person at a terminal: no answer, an answer typed too early, and what a stop leaves behind."""

import os
import pty
import sys

import pytest

pytest.importorskip("rclpy")

from forest_ident.session import SessionError
from forest_study import experiment_live
from forest_study.ident_cli import main
from forest_study.terminal import NOBODY, Question, ask


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
    monkeypatch.setattr(experiment_live.time, "monotonic", lambda: now[0])
    baths = experiment_live._Baths(lambda _time: None, sure=False)
    for now[0] in (0.0, 19.9, 20.1, 300.0):
        baths.watch()  # returns: Ctrl-C and a dead recorder are noticed while the question stands
    assert len(baths.marks) == 1
    keyboard(b"\n")
    baths.watch()
    assert len(baths.marks) == 2
    for now[0] in (300.0, 319.9):
        baths.watch()
    now[0] = 320.1
    with pytest.raises(experiment_live._Recorded):
        baths.watch()


def test_a_volume_that_no_vessel_holds_is_asked_for_again(keyboard, monkeypatch, capsys, tmp_path):
    answers = iter(["much", "-1", "nan", "0.71"])
    monkeypatch.setattr("builtins.input", lambda _question: next(answers))
    assert experiment_live._vessel(tmp_path) == {"case_drain_volume": 0.71e-3}
    assert capsys.readouterr().out.count("allowed: 0.001 .. 1000 L") == 3
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
