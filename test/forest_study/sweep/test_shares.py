"""Variance shares against functions whose shares are known in closed form."""

import math

import pytest

from forest_study.sweep.design import runs
from forest_study.sweep.shares import shares
from forest_study.sweep.study import Span, Study
from forest_study.sweep.workers import row

STUDY = Study(
    text="",
    kind="track",
    common={},
    lists={},
    ranges={name: Span(-math.pi, math.pi) for name in ("x", "y", "z")},
    design="sobol",
    points=1024,
    seeds=range(1),
)


def ishigami(x, y, z):
    """Ishigami and Homma (1990), a = 7, b = 0.1."""
    return math.sin(x) + 7.0 * math.sin(y) ** 2 + 0.1 * z**4 * math.sin(x)


def rows_of(study, function):
    return [row(one) | {"figure": function(**one.varied)} for one in runs(study)]


def test_sobols_indices_are_ishigamis():
    found = shares(STUDY, rows_of(STUDY, ishigami), "figure")
    assert [found[name].first for name in "xyz"] == pytest.approx([0.3139, 0.4424, 0.0], abs=0.03)
    assert [found[name].total for name in "xyz"] == pytest.approx([0.5576, 0.4424, 0.2437], abs=0.03)


def test_a_single_range_makes_all_of_its_figure_by_sobol_and_nothing_of_a_constant():
    study = STUDY._replace(ranges={"x": Span(0.0, 1.0)})
    for function, share in ((lambda x: 3.0 * x, 1.0), (lambda x: 0.0 * x, 0.0)):
        found = shares(study, rows_of(study, function), "figure")
        assert found["x"] == pytest.approx((share, share), abs=0.01)


def test_a_hypercubes_shares_are_the_first_order_of_each_range():
    study = STUDY._replace(design="latin_hypercube", points=2000)
    found = shares(study, rows_of(study, ishigami), "figure")
    assert [found[name].first for name in "xyz"] == pytest.approx([0.3139, 0.4424, 0.0], abs=0.05)
    assert found["x"].total is None


def test_of_a_grid_each_list_has_its_part():
    study = STUDY._replace(ranges={}, lists={"a": (0.0, 1.0, 2.0), "b": (0.0, 3.0)}, design="grid")
    found = shares(study, rows_of(study, lambda a, b: a + b), "figure")
    variances = 2.0 / 3.0, 9.0 / 4.0
    assert found["a"].first == pytest.approx(variances[0] / sum(variances))
    assert found["b"].first == pytest.approx(variances[1] / sum(variances))


def test_a_run_without_a_figure_withholds_sobols_indices_but_no_others():
    rows = rows_of(STUDY, ishigami)
    rows[5]["figure"] = None
    assert shares(STUDY, rows, "figure") == {}
    study = STUDY._replace(design="latin_hypercube", points=2000)
    rows = rows_of(study, ishigami)
    rows[5]["figure"] = None
    assert shares(study, rows, "figure")["y"].first == pytest.approx(0.4424, abs=0.05)
