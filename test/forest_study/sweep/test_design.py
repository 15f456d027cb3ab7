"""The cases of a study: equal files give equal cases, each number once."""

import numpy as np
import pytest

from forest_study.sweep.design import points, runs, size
from forest_study.sweep.study import Span, Study

STUDY = Study(
    text="",
    kind="track",
    common={},
    lists={"path": ("sweep", "radial"), "scheme": ("coordinated", "a", "b")},
    ranges={"speed": Span(0.3, 0.6), "plant.manipulator.head_mass": Span(100.0, 500.0)},
    design="sobol",
    points=8,
    seeds=range(4, 6),
)


@pytest.mark.parametrize("design", ["sobol", "latin_hypercube"])
def test_every_combination_meets_every_point_with_every_seed(design):
    study = STUDY._replace(design=design)
    found = list(runs(study))
    assert len(found) == size(study) == 2 * 3 * len(points(study)) * 2
    assert [one.number for one in found] == list(range(len(found)))
    assert len({(one.combination, one.point, one.seed) for one in found}) == len(found)
    assert found == list(runs(study))


def test_a_latin_hypercube_has_each_part_of_each_range_once():
    study = STUDY._replace(design="latin_hypercube", points=20)
    low, high = np.array(list(study.ranges.values())).T
    parts = np.floor(20 * (points(study) - low) / (high - low)).astype(int)
    assert all(sorted(column) == list(range(20)) for column in parts.T)


def test_sobols_mixed_points_differ_in_one_column():
    a, b, *mixed = points(STUDY).reshape(4, 8, 2)
    for k, one in enumerate(mixed):
        np.testing.assert_array_equal(one[:, k], b[:, k])
        np.testing.assert_array_equal(one[:, 1 - k], a[:, 1 - k])


def test_a_study_without_anything_that_varies_is_one_case_a_seed():
    study = STUDY._replace(lists={}, ranges={}, design="grid")
    assert [(one.seed, one.varied) for one in runs(study)] == [(4, {}), (5, {})]
