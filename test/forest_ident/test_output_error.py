import numpy as np
import pytest

from forest_ident.output_error import Channel, Unknown, condition_number, fit

X = np.linspace(0.0, 1.0, 2000)


def decay(values):
    return {"y": values["size"] * np.exp(-values["rate"] * X)}


def fitted(noise, seed, channel):
    y = decay({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(seed).normal(0.0, noise, len(X))
    return fit(decay, {"y": y}, [channel], [Unknown("size", 1.0), Unknown("rate", 4.0)])


def test_exact_data_give_exact_parameters():
    found = fitted(0.0, 0, Channel("y", 1e-9))
    assert found.values["size"] == pytest.approx(2.0, rel=1e-7)
    assert found.values["rate"] == pytest.approx(3.0, rel=1e-7)


def test_standard_errors_are_the_spread_of_the_estimates():
    found = [fitted(0.05, seed, Channel("y", 0.05)) for seed in range(60)]
    rates = [f.values["rate"] for f in found]
    assert np.mean([f.errors["rate"] for f in found]) == pytest.approx(np.std(rates), rel=0.3)


def test_censored_readings_neither_bias_nor_count_as_seen():
    """Everything below the floor reads as the floor; taken for flow it would slow the decay."""
    channel = Channel("y", 0.01, floor=0.5)
    rates = []
    for seed in range(20):
        y = decay({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(seed).normal(0.0, 0.01, len(X))
        unknowns = [Unknown("size", 1.5), Unknown("rate", 3.5)]
        found = fit(decay, {"y": np.maximum(y, 0.5)}, [channel], unknowns)
        rates.append(found.values["rate"])
    assert np.mean(rates) == pytest.approx(3.0, abs=0.005)
    assert np.isnan(found.residuals["y"]).sum() > 900


def test_a_known_static_error_is_taken_out_of_the_parameters():
    y = decay({"size": 2.0, "rate": 3.0})["y"] + 0.1
    unknowns = [Unknown("size", 1.5), Unknown("rate", 3.5)]
    told = fit(decay, {"y": y}, [Channel("y", 1e-4, offset=0.1)], unknowns)
    untold = fit(decay, {"y": y}, [Channel("y", 1e-4)], unknowns)
    assert told.values["rate"] == pytest.approx(3.0, rel=1e-3)
    assert abs(untold.values["rate"] - 3.0) > 0.1


def test_what_cannot_be_told_apart_has_a_great_condition_number():
    j = np.column_stack([X, X + 1e-7 * X**2])
    assert condition_number(j.T @ j) > 1e5
    assert condition_number(np.eye(2)) == pytest.approx(1.0)
