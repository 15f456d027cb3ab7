"""How many simulations a search takes: each is one of a crane's record, which takes tenths of a second."""

import numpy as np
import pytest

from forest_ident.output_error import search
from forest_ident.output_error.fit_problem import Channel, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import EMPTY, GaussianEstimate
from forest_ident.output_error.output_error import fit

X = np.linspace(0.0, 1.0, 2000)
KNOWN = [Unknown(f"known_{i}", 1.0, 0.001) for i in range(12)]


class Counted:
    """A decay, and how often it was simulated."""

    def __init__(self, gain=1.0):
        self.gain, self.count = gain, 0

    def __call__(self, values):
        self.count += 1
        size = self.gain * values["size"] * values.get("told", 1.0)
        near = 1.0 + sum(values.get(u.key, 1.0) - 1.0 for u in KNOWN)
        return {"y": size * near * np.exp(-values["rate"] * X)}


def read(noise=1e-3):
    return Counted()({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(1).normal(0.0, noise, len(X))


def searched(begun):
    model = Counted()
    far = [Unknown("size", 1.0, begun=begun), Unknown("rate", 1.0, begun=begun)]
    return fit(model, {"y": read()}, [Channel("y", 1e-3)], [*far, *KNOWN]), model.count


def test_a_search_begins_with_what_may_be_far_off_alone():
    (plain, many), (found, few) = searched(begun=False), searched(begun=True)
    assert few < 0.7 * many
    for key in ("size", "rate"):
        assert found.values[key] == pytest.approx(plain.values[key], abs=0.1 * plain.errors[key])
        assert found.errors[key] == pytest.approx(plain.errors[key], rel=0.02)


def test_a_search_that_begins_does_not_move_what_it_has_no_derivatives_of():
    """Though what was believed hangs together: each step would be spoilt by what it does not foresee."""
    model, near = Counted(), []

    def recorded(values):
        near.append(values["known_0"])
        return model(values)

    spread = np.array([[0.5, 0.009], [0.009, 0.0002]])  # a correlation of 0.9
    believed = GaussianEstimate(("size", "known_0"), np.zeros(2), spread)
    unknowns = [Unknown("size", 1.0, begun=True), Unknown("rate", 3.0, 0.1), *KNOWN]
    found = fit(recorded, {"y": read()}, [Channel("y", 1e-3)], unknowns, prior=believed)
    assert found.values["size"] == pytest.approx(2.0, rel=0.1)
    assert near[0:4] == [1.0] * 4  # the start, a derivative, two steps


def test_the_exact_model_is_simulated_at_the_end_alone():
    exact, rough = Counted(), Counted(gain=1.001)
    unknowns = [Unknown("size", 1.0, begun=True), Unknown("rate", 1.0, begun=True)]
    found = fit(exact, {"y": read()}, [Channel("y", 1e-3)], unknowns, rough=rough)
    assert found.values["size"] == pytest.approx(2.0, abs=4.0 * found.errors["size"])
    assert exact.count <= 4 < rough.count


def iterations(stated):
    """Steps of a search whose derivatives are twice too great, so that it creeps."""
    unknowns = [Unknown("size", 1.97), Unknown("rate", 2.97)]
    steep = Counted(gain=2.0)
    told = fit(Counted(), {"y": read()}, [Channel("y", 1e-3)], unknowns, rough=steep, stated=stated)
    return told.iterations


def test_a_search_ends_at_a_tenth_of_the_interval_stated_numbers_counted():
    assert iterations([{"told": 1.1}]) < iterations([])


def test_a_step_with_new_derivatives_begins_without_the_damping_of_a_refused_one(monkeypatch):
    begun, step = [], search.Search._step

    def refused_at_first(self, model, at, jacobian, least):
        begun.append(at.damping)
        if len(begun) == 1:
            return at._replace(damping=1e6, moved=0.0, fall=1e9)  # far from its end
        return step(self, model, at, jacobian, least)

    monkeypatch.setattr(search.Search, "_step", refused_at_first)
    unknowns = [Unknown("size", 1.9), Unknown("rate", 2.9)]
    found = fit(Counted(), {"y": read()}, [Channel("y", 1e-3)], unknowns)
    assert begun[:2] == [search.DAMPING, search.DAMPING]
    assert found.values["size"] == pytest.approx(2.0, abs=4.0 * found.errors["size"])


def test_derivatives_bent_along_a_step_tell_where_it_has_led_and_no_more():
    model, start = Counted(), {"size": 2.0, "rate": 3.0}
    unknowns, channels = [Unknown(key, value) for key, value in start.items()], [Channel("y", 1e-3)]
    problem = Problem({"y": read()}, channels, unknowns, 200, EMPTY)
    looked_for = search.Search(model, model, problem, unknowns, channels, lambda: None, (), ())
    errors, step = np.array([0.01, 0.05]), np.array([0.02, -0.1])

    def place(theta):
        return search.Place(theta, model(problem.values(theta)), 0.0, 1.0, 0.0, errors)

    begin, end = place(problem.mean), place(problem.mean + step)
    bent = looked_for._derivatives(begin, begin.predicted, range(2))
    across = np.array([step[1] * errors[0] ** 2, -step[0] * errors[1] ** 2])  # in standard errors
    before = across @ bent["y"]
    looked_for._bend(bent, begin, end)
    np.testing.assert_allclose(step @ bent["y"], end.predicted["y"] - begin.predicted["y"], atol=1e-12)
    np.testing.assert_allclose(across @ bent["y"], before, atol=1e-12)


def curved():
    """What a search found whose model curves so much that its steps shrink slowly, and its simulations."""
    model = Counted()

    def squared(values):
        return {"y": model(values)["y"] ** 3 / 4.0}

    y = squared({"size": 2.0, "rate": 3.0})["y"] + np.random.default_rng(1).normal(0.0, 0.02, len(X))
    model.count = 0
    unknowns = [Unknown("size", 1.96, difference=1e-5), Unknown("rate", 2.95, difference=1e-5), *KNOWN]
    return fit(squared, {"y": y}, [Channel("y", 0.02)], unknowns), model.count


def test_bent_derivatives_save_new_ones_and_find_the_same(monkeypatch):
    found, few = curved()
    monkeypatch.setattr(search, "STALE", 1e-4)
    fresh, many = curved()
    assert few < 0.7 * many
    for key in ("size", "rate"):
        assert found.values[key] == pytest.approx(fresh.values[key], abs=0.02 * fresh.errors[key])
        assert found.errors[key] == pytest.approx(fresh.errors[key], rel=0.02)


def test_what_acts_like_another_but_for_its_reading_is_not_simulated():
    def shifted(values):
        shift = values["start"] + values["angle"]
        return {"y": np.sin(3.0 * X + shift) - values["angle"], "z": np.cos(3.0 * X + shift)}

    def searched(like):
        count = [0]

        def model(values):
            count[0] += 1
            return shifted(values)

        noise = np.random.default_rng(2).normal(0.0, 1e-3, (2, len(X)))
        true = shifted({"start": 0.02, "angle": -0.01})
        y = {name: column + extra for (name, column), extra in zip(true.items(), noise, strict=True)}
        angle = Unknown("angle", 0.0, 0.1, False, difference=1e-5, like=like)
        unknowns = [angle, Unknown("start", 0.0, 0.1, False, difference=1e-5)]
        return fit(model, y, [Channel("y", 1e-3), Channel("z", 1e-3)], unknowns), count[0]

    (plain, many), (found, few) = searched(None), searched(("start", "y"))
    assert few < many
    assert found.values == pytest.approx(plain.values, abs=1e-6)
    assert found.errors == pytest.approx(plain.errors, rel=1e-3)
