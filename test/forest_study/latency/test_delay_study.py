"""Claims about late links in the closed loop: what they cost, and that nothing runs away."""

import json

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_study import cli
from forest_study.closed_loop.link_model import Quality
from forest_study.latency import delay_study
from forest_study.latency.delay_study import RELEASE, score, session

C180 = load_machine("c180_hoses")


def test_a_perfect_link_is_no_link_and_a_late_joystick_is_late_by_its_delay():
    exact, late = (session("joystick", Quality(d), C180) for d in (0.0, 0.2))
    shift = round(0.2 / delay_study.PERIOD)
    moving = slice(shift + 100, round(RELEASE / delay_study.PERIOD))
    assert np.abs(late.tip[moving] - exact.tip[moving.start - shift : moving.stop - shift]).max() < 2e-3
    assert score(late).stop_s == pytest.approx(score(exact).stop_s + 0.2, abs=0.02)


def test_a_link_that_loses_too_much_stops_the_crane_and_repeats():
    one, same = (session("joystick", Quality(0.02, 0.05, 0.97), C180, seed=4) for _ in range(2))
    assert np.array_equal(one.tip, same.tip)
    assert np.isfinite(one.tip).all()
    assert (np.abs(one.commands).max(axis=1) == 0.0).mean() > 0.2


def test_bad_arguments_end_with_one_sentence(tmp_path, capsys):
    assert cli.main(["delay", "--loss", "2", "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err.strip() == "forest-study: delay: loss is 2.0; allowed: 0 .. 1"
    assert not (tmp_path / "out").exists()


def test_the_command_writes_numbers_and_a_picture(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(delay_study, "DELAYS", (0.0,))
    assert cli.main(["delay", "--machine", "c180_hoses", "--out", str(tmp_path / "out")]) == 0
    report = json.loads((tmp_path / "out" / "delay.json").read_text())
    assert report["joystick"][0]["rms_mm"] < 5.0
    assert (tmp_path / "out" / "delay.png").stat().st_size > 10000
    assert "| 0 | " in capsys.readouterr().out
