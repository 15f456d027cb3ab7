"""How many simulations a search takes: each is one of a crane's record, which takes tenths of a second."""

import numpy as np
import pytest

from forest_ident.output_error import search
from forest_ident.output_error.fit_problem import Channel, Unknown
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
