import math
from types import SimpleNamespace

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.online import online_comparison, recursive_least_squares
from forest_ident.report import html_page, identification_report


def test_it_ends_where_least_squares_does():
    generator = np.random.default_rng(6)
    x = np.column_stack([generator.uniform(1.0, 3.0, 2000), np.ones(2000)])
    y = x @ [2.0, -1.0] + generator.normal(0.0, 0.1, 2000)
    e = recursive_least_squares.start((0.0, 0.0), (1e3, 1e3))
    for row, value in zip(x.tolist(), y.tolist(), strict=True):
        e = recursive_least_squares.step(e, (row[0], row[1]), value, 1e-9, 1.0)
    batch = np.linalg.lstsq(x, y, rcond=None)[0]
    assert e.theta == pytest.approx(batch, rel=1e-4)
    expected = 0.1 * np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
    assert recursive_least_squares.spread(e) == pytest.approx(expected, rel=0.1)


def test_it_forgets_and_follows_a_change():
    e = recursive_least_squares.start((0.0, 0.0), (1e3, 1e3))
    for k in range(4000):
        slope, x = (2.0 if k < 2000 else 3.0), 1.0 + (k % 10) / 10.0
        e = recursive_least_squares.step(e, (x, 1.0), slope * x, 0.01, 2.0)
    assert e.theta[0] == pytest.approx(3.0, rel=1e-3)


def test_a_sample_that_is_no_number_changes_nothing():
    e = recursive_least_squares.start((1.0, 2.0), (1.0, 1.0))
    assert recursive_least_squares.step(e, (math.nan, 1.0), 0.0, 0.01, 1.0) == e


def test_without_motion_the_covariance_stays_bounded():
    e = recursive_least_squares.start((1.0, 2.0), (1.0, 1.0))
    for _ in range(5000):
        e = recursive_least_squares.step(e, (0.0, 1.0), 2.0, 0.1, 1.0)
    assert max(e.covariance) <= recursive_least_squares.GREATEST


def test_running_estimates_come_near_the_truth(monkeypatch):
    axis, name = 2, "stick"
    machine = load_machine("c180_hoses")
    session = experiment(f"damping_{name}", machine, seed=4, longest=30.0)
    told = online_comparison.estimates(machine, session)
    truth = {
        "deadband_forward": 1.0,
        "deadband_backward": 1.0,
        "gain_forward": 1.0 / (math.sqrt(machine.valve.minimum_resistance) * 9.0),
        "damping": machine.drives[axis].damping,
    }
    for part, value in truth.items():
        found, spread = told[f"{name}_{part}"], told[f"{name}_{part}_spread"]
        assert abs(found - value) < 4.0 * spread, part
        assert spread < 0.25 * value, part
    monkeypatch.setattr(online_comparison, "estimates", lambda *_: told)
    compared = {c.name: c for c in online_comparison.compare(machine, machine, session)}
    assert set(compared) == {f"{name}_{part}" for part in (*truth, "gain_backward")}
    for part, value in truth.items():
        assert compared[f"{name}_{part}"].offline == pytest.approx(value, rel=1e-12)
        assert compared[f"{name}_{part}"].online == told[f"{name}_{part}"]
    result = SimpleNamespace(start=machine, machine=machine, refined=[SimpleNamespace(session=session)])
    page = html_page.render("online.html", online=identification_report.online(result))
    assert "on line, at its end" in page
    assert f"{compared[f'{name}_damping'].online:.4g} ±" in page
