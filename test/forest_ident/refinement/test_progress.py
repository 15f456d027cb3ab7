"""The time left is true: each record counts by its length and by what it must find."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.cli import fit_command
from forest_ident.measurements.session import Session
from forest_ident.refinement import identification, refinement
from forest_ident.refinement.refinement_task import simulations

C180 = load_machine("c180_hoses")


def record(name, seconds):
    time = 0.005 * np.arange(round(seconds / 0.005))
    return Session(name, time, np.zeros((len(time), 3)), {})


def test_a_records_share_is_its_length_times_the_simulations_it_takes(monkeypatch):
    long, short = record("deadband_boom", 110.0), record("deadband_stick", 11.0)
    told = []
    monkeypatch.setattr(
        refinement,
        "refine",
        lambda m, s, _k, progress, _e: [progress() for _ in range(round(simulations(m, s)))] and None,
    )
    identification.identify(C180, [long, short], lambda text, share: told.append((text, share)))
    shares = [share for text, share in told if text.startswith("deadband_boom: refinement")]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(10.0 / (10.0 * 1.25 + 1.0), rel=0.02)  # its end is not known yet
    assert next(s for text, s in told if "stick: refinement, simulation 1" in text) > 0.9
    assert told[-1] == ("done", 1.0)


def test_what_comes_before_the_simulations_is_not_taken_for_their_pace(monkeypatch, capsys):
    times = iter([0.0, 100.0, 110.0])
    monkeypatch.setattr(fit_command.time, "monotonic", lambda: next(times))
    bar = fit_command.Bar()
    bar("valve: linear estimates", 0.0)
    bar("valve: refinement, simulation 9", 0.5)
    assert " 50 %, 10 s left, valve" in capsys.readouterr().err


def test_a_record_of_both_cylinders_takes_more_simulations_than_one_of_an_axis():
    assert simulations(C180, record("gravity", 60.0)) > 1.1 * simulations(C180, record("damping_boom", 70.0))
    assert simulations(C180, record("validation", 40.0)) == 0.0
