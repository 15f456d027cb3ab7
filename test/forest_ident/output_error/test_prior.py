"""What is known before an output-error fit pulls it, by as much and to the side that Gauss' formula says."""

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from forest_ident.output_error.fit_problem import Channel, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import (
    EMPTY,
    GaussianEstimate,
    prior_information,
    updated,
    widened,
)
from forest_ident.output_error.output_error import fit

X = np.linspace(0.3, 2.0, 40)
COLUMNS = np.column_stack([X, X**2])
TRUTH = np.array([1.5, -0.8])
# Three names that hang together, none like another; the fit is about two of them, in another order.
NAMES = ("c", "b", "a")
MEAN = np.array([4.0, -1.1, 1.9])
ROOT = np.array([[0.5, 0.0, 0.0], [-0.2, 0.3, 0.0], [0.4, 0.1, 0.2]])
KNOWN = GaussianEstimate(NAMES, MEAN, ROOT @ ROOT.T)


def straight(values):
    return {"y": COLUMNS @ [values["a"], values["b"]]}


def posterior(sigma):
    """Mean and covariance of (a, b, c) by Gauss' formula, all three at once."""
    order = [2, 1, 0]
    before = np.linalg.inv((ROOT @ ROOT.T)[np.ix_(order, order)])
    seen = np.column_stack([COLUMNS, np.zeros(len(X))]) / sigma
    information = seen.T @ seen + before
    wanted = seen.T @ (COLUMNS @ TRUTH / sigma) + before @ MEAN[order]
    return np.linalg.solve(information, wanted), np.linalg.inv(information)


UNKNOWNS = [Unknown("a", 1.0, positive=False), Unknown("b", 1.0, positive=False)]


@pytest.mark.parametrize("sigma", [0.3, 1.0, 3.0])
def test_a_belief_pulls_a_straight_model_as_gauss_says_with_all_that_hangs_together(sigma):
    y = {"y": COLUMNS @ TRUTH}
    found = fit(straight, y, [Channel("y", sigma)], UNKNOWNS, prior=KNOWN)
    mean, covariance = posterior(sigma)
    assert [found.values["a"], found.values["b"]] == pytest.approx(mean[:2], rel=1e-6)
    assert [found.errors["a"], found.errors["b"]] == pytest.approx(np.sqrt(np.diag(covariance))[:2], rel=1e-6)
    places = [found.posterior.names.index(name) for name in ("a", "b", "c")]
    assert found.posterior.mean[places] == pytest.approx(mean, rel=1e-6)
    assert found.posterior.covariance[np.ix_(places, places)] == pytest.approx(covariance, rel=1e-5, abs=1e-9)
    believed = np.linalg.cholesky(np.linalg.inv((ROOT @ ROOT.T)[np.ix_([2, 1], [2, 1])])).T
    whole = np.vstack([COLUMNS / sigma, believed])
    assert found.condition == pytest.approx(np.linalg.cond(whole / np.linalg.norm(whole, axis=0)), rel=1e-4)
    assert min(abs(found.values["a"] - 1.5), abs(found.values["a"] - 1.9)) > 5e-3  # both have a say


def decay(values):
    return {"y": values["size"] * np.exp(-values["rate"] * X)}


@pytest.mark.parametrize(
    ("size", "rate"), [((4.0, 0.2), (1.0, 0.3)), ((0.5, 0.3), (4.0, 0.1)), ((0.7, 0.05), (0.8, 1.5))]
)
def test_a_prior_pulls_a_bent_model_from_afar_to_the_least_of_both_sums(size, rate):
    """Logarithms, several steps from the prior's mean; scipy's least squares as the other opinion."""
    y, sigma = decay({"size": 2.0, "rate": 2.0})["y"], 0.15
    unknowns = [Unknown("size", *size), Unknown("rate", *rate)]

    def residuals(theta):
        said = math.exp(theta[0]) * np.exp(-math.exp(theta[1]) * X)
        pull = [(theta[0] - math.log(size[0])) / size[1], (theta[1] - math.log(rate[0])) / rate[1]]
        return np.append((y - said) / noise, pull)

    found = fit(decay, {"y": y}, [Channel("y", sigma)], unknowns)
    noise = found.noise["y"]
    best = least_squares(residuals, np.log([size[0], rate[0]]), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    errors = np.sqrt(np.diag(np.linalg.inv(best.jac.T @ best.jac)))
    for place, name in enumerate(("size", "rate")):  # relative, and so in the parameter's own unit
        assert found.errors[name] >= 0.9 * errors[place] * found.values[name]
        assert found.errors[name] == pytest.approx(found.posterior.of(name)[1] * found.values[name])
    there = np.log([found.values["size"], found.values["rate"]])
    assert np.all(np.abs(there - best.x) < 0.1 * errors)  # as near as the search goes
    assert np.abs(best.x - np.log(2.0)).max() > errors.max()  # the prior has a say


@pytest.mark.parametrize(("offset", "gain"), [(0.2, 0.0), (0.0, 0.1), (0.3, 0.2)])
@pytest.mark.parametrize("shift", [0.5, -0.3])
def test_static_errors_are_pulled_to_nothing_by_their_accuracies(offset, gain, shift):
    """One channel may be off, the other is not; theta, b and g by scipy's least squares."""
    true = decay({"size": 2.0, "rate": 1.0})["y"]
    read = {"off": 1.1 * true + shift, "plain": true}
    channels = [Channel("off", 0.3, offset=offset, gain=gain), Channel("plain", 0.6)]

    def model(values):
        return dict.fromkeys(read, decay(values)["y"])

    found = fit(model, read, channels, [Unknown("size", 1.5), Unknown("rate", 1.2)])
    noise = found.noise

    def residuals(theta):
        said = math.exp(theta[0]) * np.exp(-math.exp(theta[1]) * X)
        b, g = (theta[2] if offset else 0.0), (theta[-1] if gain else 0.0)
        pull = [b / offset] if offset else []
        pull += [g / gain] if gain else []
        off, plain = (
            (read["off"] - b - (1.0 + g) * said) / noise["off"],
            (read["plain"] - said) / noise["plain"],
        )
        return np.concatenate([off, plain, pull])

    start = [math.log(1.5), math.log(1.2), *([0.0] if offset else []), *([0.0] if gain else [])]
    best = least_squares(residuals, start, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    errors = np.sqrt(np.diag(np.linalg.inv(best.jac.T @ best.jac)))
    names = ["size", "rate", *(["off.b"] if offset else []), *(["off.g"] if gain else [])]
    for name, value, error in zip(names, best.x, errors, strict=True):
        mean, told = found.posterior.of(name)
        assert abs(mean - value) < 0.02 * error, name
        assert told >= 0.99 * error, name


def test_the_cost_counts_what_was_believed_with_its_covariance():
    y = {"y": COLUMNS @ TRUTH}
    problem = Problem(y, [Channel("y", 0.5)], UNKNOWNS, 200, KNOWN)
    theta, said = np.array([2.5, -0.1]), {"y": COLUMNS @ [2.5, -0.1]}
    away = theta - [1.9, -1.1]
    before = np.linalg.inv((ROOT @ ROOT.T)[np.ix_([2, 1], [2, 1])])
    expected = np.sum(((y["y"] - said["y"]) / 0.5) ** 2) + away @ before @ away
    assert problem.cost(theta, said) == pytest.approx(expected, rel=1e-9)


def test_names_keep_their_own_numbers_in_whatever_order_a_fit_has_them():
    start, spread = np.array([9.0, 7.0, 8.0, 6.0]), np.array([5.0, 0.25, math.inf, 1.0])
    mean, information = prior_information(KNOWN, ("a", "x", "y", "c"), start, spread)
    assert mean.tolist() == [1.9, 7.0, 8.0, 4.0]
    of_both = np.linalg.inv((ROOT @ ROOT.T)[np.ix_([2, 0], [2, 0])])
    assert information[np.ix_([0, 3], [0, 3])] == pytest.approx(of_both, rel=1e-9)
    assert information[1].tolist() == [0.0, 16.0, 0.0, 0.0]
    assert information[2].tolist() == [0.0, 0.0, 0.0, 0.0]


def test_what_is_new_joins_and_what_hangs_together_with_it_follows():
    """A fit of b and a new name: c and a move with b by their regression on it."""
    found = np.array([[0.04, -0.01], [-0.01, 0.09]])
    after = updated(KNOWN, ("b", "new"), np.array([-0.9, 3.0]), found)
    before = ROOT @ ROOT.T
    assert after.names == (*NAMES, "new")
    for place, name in ((0, "c"), (2, "a")):
        slope = before[place, 1] / before[1, 1]
        mean, error = after.of(name)
        assert mean == pytest.approx(MEAN[place] + slope * 0.2)
        assert error**2 == pytest.approx(before[place, place] + slope**2 * (0.04 - before[1, 1]))
        assert after.covariance[place, 1] == pytest.approx(slope * 0.04)
        assert after.covariance[place, 3] == pytest.approx(slope * -0.01)
    assert after.of("b") == pytest.approx((-0.9, 0.2))
    assert after.of("new") == pytest.approx((3.0, 0.3))
    assert after.covariance[1, 3] == after.covariance[3, 1] == -0.01


def test_what_chance_moves_gains_its_variance():
    wide = widened(KNOWN, {"b": 0.3, "unheard": 9.0})
    assert wide.covariance - KNOWN.covariance == pytest.approx(np.diag([0.0, 0.09, 0.0]))


def test_residuals_that_hang_together_widen_what_the_data_say_and_not_what_was_believed():
    """One parameter: variance k s^2 + F d s^2, s = 1/(d + k), F by the scatter of the blocks' scores."""
    block, rows = 10, 400
    held = np.repeat(np.random.default_rng(7).normal(0.0, 0.5, rows // block), block)
    known = 900.0
    believed = GaussianEstimate(("a",), np.array([1.0]), np.array([[1.0 / known]]))
    found = fit(
        lambda values: {"y": np.full(rows, values["a"])},
        {"y": 1.0 + held},
        [Channel("y", 0.01)],
        [Unknown("a", 1.0, positive=False)],
        block=block,
        prior=believed,
    )
    sigma = found.noise["y"]
    data, s = rows / sigma**2, 1.0 / (rows / sigma**2 + known)
    factors = []
    for longer in (block,):  # forty blocks are too few for longer ones
        scores = np.add.reduceat((1.0 + held - found.values["a"]) / sigma**2 * s, np.arange(0, rows, longer))
        excess = np.sum(scores**2) / (data * s * s) - 1.0
        factors.append(1.0 + excess**3 / (excess**2 + 4.0 * 2.0 / (rows // longer)))
    factor = max(factors)
    assert factor > 5.0
    # The search ends within a hundredth of a standard error, and counts that.
    assert found.errors["a"] ** 2 == pytest.approx(known * s * s + factor * data * s * s, rel=1e-4)


def test_nothing_known_pulls_nothing():
    y = {"y": COLUMNS @ TRUTH}
    found = fit(straight, y, [Channel("y", 0.3)], UNKNOWNS, prior=EMPTY)
    assert [found.values["a"], found.values["b"]] == pytest.approx(TRUTH, rel=1e-8)
