import numpy as np
import pytest

from forest_description.config.parameter import MachineError
from forest_ident.output_error import search
from forest_ident.output_error.fit_problem import Channel, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import EMPTY, condition_number, inflation
from forest_ident.output_error.output_error import fit

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


def test_what_a_single_event_tells_has_the_error_that_it_scatters_with():
    """Read off the scatter between blocks it would be far too small: the fit made that score nil."""
    away = []
    for seed in range(60):
        y = np.where(np.arange(len(X)) < 5, 2.0, 0.0) + np.random.default_rng(seed).normal(0.0, 0.1, len(X))
        found = fit(pulse, {"y": y}, [Channel("y", 0.1)], [Unknown("size", 1.9)])
        away.append((found.values["size"] - 2.0) / found.errors["size"])
    assert np.std(away) == pytest.approx(1.0, rel=0.3)


def pulse(values):
    return {"y": np.where(np.arange(len(X)) < 5, values["size"], 0.0)}


def test_scatter_between_blocks_counts_the_more_blocks_there_are():
    one, many = np.zeros((100, 1)), np.ones((100, 1))
    one[3] = 1.0
    assert inflation(2.0 * one, one)[0] < 3.0
    assert inflation(2.0 * many, many)[0] == pytest.approx(4.0, rel=0.02)


def test_chance_is_not_taken_for_residuals_that_hang_together():
    scores = np.random.default_rng(2).standard_normal((60, 500))
    factors = inflation(scores, np.ones((60, 500)))
    assert factors.min() == 1.0
    assert factors.mean() < 1.05


def test_derivatives_are_kept_where_the_model_is_nearly_straight():
    calls = []

    def counted(values):
        calls.append(values)
        return decay(values)

    y = decay({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(1).normal(0.0, 0.05, len(X))
    found = fit(counted, {"y": y}, [Channel("y", 0.05)], [Unknown("size", 2.01), Unknown("rate", 3.02)])
    assert found.iterations >= 2
    assert len(calls) <= 1 + 2 + found.iterations


def test_a_search_that_ends_by_its_last_step_says_so(monkeypatch):
    monkeypatch.setattr(search, "ITERATIONS", 1)
    assert not fitted(0.0, 0, Channel("y", 1e-9)).converged
    monkeypatch.undo()
    assert fitted(0.0, 0, Channel("y", 1e-9)).converged


def test_a_search_ends_where_the_cost_does_not_fall_though_the_derivatives_promise_it():
    """A number that the simulator rounds has derivatives over a wide difference, and none over a step."""

    def rounded(values):
        return {"y": 0.024 * np.round(values["late"], 1) * X}

    unknown = Unknown("late", 0.96, difference=0.25)
    assert fit(rounded, {"y": 0.024 * 1.02 * X}, [Channel("y", 0.05)], [unknown]).iterations == 1


def test_a_plant_that_sticks_is_found_by_derivatives_over_more_than_its_steps():
    def sticking(values):
        return decay({"size": values["size"], "rate": np.round(values["rate"], 4)})

    y = decay({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(1).normal(0.0, 0.05, len(X))
    found = fit(sticking, {"y": y}, [Channel("y", 0.05)], [Unknown("size", 1.0), Unknown("rate", 4.00004)])
    assert abs(found.values["rate"] - 3.0) < 3.0 * found.errors["rate"]
    assert found.errors["rate"] < 0.03


def test_a_step_that_the_plant_refuses_counts_as_an_error():
    def line(values):
        return {"y": values["slope"] * X}

    def walled(values):  # beyond 1.015 the plant does something else altogether
        return {"y": line(values)["y"] + 50.0 * (values["slope"] > 1.015)}

    y = 1.1 * X + np.random.default_rng(5).normal(0.0, 0.01, len(X))
    found = fit(walled, {"y": y}, [Channel("y", 0.01)], [Unknown("slope", 1.0)], rough=line)
    assert found.values["slope"] < 1.02
    assert found.errors["slope"] > 0.06
    assert not found.converged


def test_a_derivative_is_taken_downwards_where_no_machine_is_above():
    def bounded(values):
        if values["rate"] > 1.0:
            raise MachineError("allowed: up to 1")
        return {"y": values["rate"] * np.linspace(0.0, 1.0, 400)}

    y = 0.998 * np.linspace(0.0, 1.0, 400) + np.random.default_rng(2).normal(0.0, 1e-3, 400)
    found = fit(bounded, {"y": y}, [Channel("y", 1e-3)], [Unknown("rate", 0.995)])
    assert found.values["rate"] == pytest.approx(0.998, abs=4.0 * found.errors["rate"])


def test_what_no_other_record_feels_keeps_no_search_going():
    """A quarter of the way at each step: the start's pressure goes on for long, and moves nothing else."""

    def steep(values):
        return {"y": np.where(X < 0.5, 4.0 * values["own"], values["size"])}

    def exact(values):
        return {"y": np.where(X < 0.5, values["own"], values["size"])}

    def search(own):
        unknowns = [Unknown("size", 1.0), Unknown("own", 0.5, positive=False, own=own)]
        y = np.where(X < 0.5, 3.0, 1.1)
        return fit(exact, {"y": y}, [Channel("y", 0.05)], unknowns, rough=steep)

    assert search(own=True).values["size"] == pytest.approx(1.1, rel=1e-3)
    assert search(own=True).iterations < search(own=False).iterations


def test_a_search_that_explains_nothing_ends_with_the_gain():
    """What the model lacks leaves far more than noise: no step is worth its simulations."""

    def steep(values):  # its derivatives are five times too great, so that a step goes a fifth of the way
        return {"y": 5.0 * decay(values)["y"]}

    y = decay({"size": 2.0, "rate": 3.0})["y"] + 0.5 * np.sin(40.0 * X)
    unknowns = [Unknown("size", 2.1), Unknown("rate", 3.1)]
    found = fit(decay, {"y": y}, [Channel("y", 1e-3)], unknowns, rough=steep)
    assert found.converged
    assert found.iterations == 1


def test_derivatives_of_a_rough_model_find_the_same():
    def rough(values):
        return {"y": 0.3 + 1.05 * decay(values)["y"]}

    y = decay({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(1).normal(0.0, 0.05, len(X))
    one, other = (
        fit(decay, {"y": y}, [Channel("y", 0.05)], [Unknown("size", 1.8), Unknown("rate", 3.3)], rough=model)
        for model in (None, rough)
    )
    for key, error in one.errors.items():
        assert other.values[key] == pytest.approx(one.values[key], abs=0.1 * error)
        assert other.errors[key] == pytest.approx(error, rel=0.1)


def test_residuals_that_hang_together_widen_the_errors():
    """Noise that holds for 20 rows has a twentieth of the rows' worth."""
    errors = []
    for hold in (1, 20):
        steps = np.random.default_rng(1).normal(0.0, 0.05, len(X) // hold)
        y = decay({"size": 2.0, "rate": 3.0})["y"] + np.repeat(steps, hold)
        unknowns = [Unknown("size", 2.0), Unknown("rate", 3.0)]
        errors.append(fit(decay, {"y": y}, [Channel("y", 0.05)], unknowns, block=50).errors["rate"])
    assert errors[1] > 2.0 * errors[0]


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


def test_noise_of_what_drives_the_model_counts():
    """Four hundred rows have one reading of the input: its noise does not average out among them."""
    rows = np.arange(len(X)) // 400
    true = np.array([1.0, 2.0, 0.5, 1.5, 3.0])

    def driven_by(read):
        return lambda values: {"y": values["gain"] * read[rows]}

    scatter, errors = [], []
    for seed in range(60):
        luck = np.random.default_rng(seed)
        read = luck.normal(true, 0.05)
        again = [driven_by(luck.normal(read, 0.05)) for _ in range(8)]
        y = {"y": 2.0 * true[rows] + luck.normal(0.0, 0.05, len(X))}
        told = [Channel("y", 0.05)], [Unknown("gain", 1.9)]
        blind, found = fit(driven_by(read), y, *told), fit(driven_by(read), y, *told, redrawn=again)
        assert found.values == blind.values
        scatter.append(found.values["gain"] - 2.0)
        errors.append((blind.errors["gain"], found.errors["gain"]))
    blind, found = np.mean(errors, axis=0)
    assert blind < 0.75 * np.std(scatter)  # long blocks see some of it
    assert found == pytest.approx(np.std(scatter), rel=0.25)


@pytest.mark.parametrize("wrong", [0.0, 2.0, -8.0])
def test_a_record_tells_how_far_off_a_stated_number_would_have_to_be(wrong):
    def told(values):
        return {"y": decay(values)["y"] + values.get("told", 1.0) * np.sin(9.0 * X)}

    luck = np.random.default_rng(6).normal(0.0, 1e-3, len(X))
    y = {"y": told({"size": 2.0, "rate": 3.0, "told": 1.0 + 0.01 * wrong})["y"] + luck}
    unknowns, stated = [Unknown("size", 1.9), Unknown("rate", 3.1)], [{}, {"told": 1.01}]
    found = fit(told, y, [Channel("y", 1e-3)], unknowns, stated=stated)
    assert found.asked == pytest.approx([0.0, wrong], abs=0.4)


def test_the_gradient_is_half_the_slope_of_the_cost_static_errors_and_censored_rows_counted():
    unknowns = [Unknown("size", 2.0), Unknown("rate", 3.0)]
    y = np.maximum(decay({"size": 2.1, "rate": 2.9})["y"] + 0.01 * np.sin(40.0 * X), 0.5)  # a meter's floor
    channel = Channel("y", 0.05, offset=0.1, gain=0.1, floor=0.5)
    problem = Problem({"y": y}, [channel], unknowns, 200, EMPTY)
    theta = problem.mean + np.array([0.02, -0.01, 0.03, 0.01])

    def predicted(theta):
        return decay(problem.values(theta))

    at = predicted(theta)
    small = 1e-6 * np.eye(4)
    jacobian = {"y": np.array([(predicted(theta + d)["y"] - at["y"]) / 1e-6 for d in small[:2]])}
    costs = [[problem.cost(theta + s * d, predicted(theta + s * d)) for s in (1.0, -1.0)] for d in small]
    prior = problem.known @ (theta - problem.mean)
    slopes = [(up - down) / 4e-6 for up, down in costs] - prior
    np.testing.assert_allclose(problem.gradient(theta, at, jacobian), slopes, rtol=1e-4)
    np.testing.assert_allclose(problem.normal(theta, at, jacobian)[1], slopes, rtol=1e-4)
