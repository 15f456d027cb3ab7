import numpy as np
import pytest

from forest_ident.output_error.gaussian_estimate import (
    EMPTY,
    GaussianEstimate,
    condition_number,
    covariance_of,
    inflation,
    inverse,
    prior_information,
    updated,
    widened,
)


def test_one_fit_after_the_other_is_as_good_as_both_at_once():
    generator = np.random.default_rng(4)
    truth = np.array([1.0, -2.0, 0.5])
    first, second = generator.normal(size=(50, 3)), generator.normal(size=(40, 2))
    y_1, y_2 = first @ truth + generator.normal(size=50), second @ truth[1:] + generator.normal(size=40)
    names = ("a", "b", "c")
    cov = inverse(first.T @ first)
    belief = updated(EMPTY, names, cov @ first.T @ y_1, cov)
    mean, known = prior_information(belief, names[1:], np.zeros(2), np.full(2, np.inf))
    information = second.T @ second + known
    found = np.linalg.solve(information, second.T @ y_2 + known @ mean)
    belief = updated(belief, names[1:], found, inverse(information))
    whole = np.vstack([first, np.column_stack([np.zeros(40), second])])
    joint = np.linalg.solve(whole.T @ whole, whole.T @ np.concatenate([y_1, y_2]))
    assert belief.mean == pytest.approx(joint, rel=1e-9)
    assert belief.covariance == pytest.approx(np.linalg.inv(whole.T @ whole), rel=1e-8, abs=1e-12)


def test_what_is_not_known_yet_has_its_own_spread():
    mean, information = prior_information(EMPTY, ("a", "b"), np.array([1.0, 2.0]), np.array([np.inf, 0.5]))
    assert mean.tolist() == [1.0, 2.0]
    assert information.tolist() == [[0.0, 0.0], [0.0, 4.0]]


def test_what_moves_by_chance_is_known_less_well_and_hangs_together_less():
    belief = updated(EMPTY, ("a", "b"), np.zeros(2), np.array([[1.0, 0.9], [0.9, 1.0]]))
    wide = widened(belief, {"b": 1.0, "c": 5.0})
    assert wide.of("a") == belief.of("a")
    assert wide.of("b")[1] == pytest.approx(np.sqrt(2.0))
    assert widened(EMPTY, {"b": 1.0}).names == ()


def test_what_told_numbers_move_is_part_of_a_spread():
    plain = GaussianEstimate(("a",), np.zeros(1), np.array([[9.0]]))
    assert plain.spread("a") == pytest.approx(3.0)
    assert plain._replace(slopes=np.array([[4.0, 12.0]])).spread("a") == pytest.approx(13.0)


def test_a_direction_that_nobody_sees_is_unknown():
    seen = np.array([[1.0, 1.0], [1.0, 1.0]])  # the sum alone
    assert np.all(np.diag(covariance_of(seen)) > 1e10)
    assert np.ones(2) @ covariance_of(seen) @ np.ones(2) == pytest.approx(1.0, rel=1e-2)
    whole = np.diag([4.0, 1e-14])
    assert covariance_of(whole) == pytest.approx(np.diag([0.25, 1e14]))


def test_a_record_that_tells_the_same_again_makes_nothing_surer():
    """A rig tells k, a record k + n, and k stays: a second record of k + n tells nothing more of n."""
    rig = updated(EMPTY, ("k",), np.array([0.3]), np.array([[1.0]]))
    for _ in range(2):
        mean, known = prior_information(rig, ("k", "n"), np.zeros(2), np.full(2, np.inf))
        covariance = inverse(1e4 * np.ones((2, 2)) + known)
        found = covariance @ (1e4 * np.full(2, 2.0) + known @ mean)
        rig = rig.taken(updated(rig, ("k", "n"), found, covariance), ["n"])
    assert rig.of("k") == pytest.approx((0.3, 1.0))
    assert rig.of("n") == pytest.approx((1.7, 1.0), rel=1e-3)


def test_what_a_later_estimate_is_less_sure_of_makes_no_covariance_that_is_none():
    before = GaussianEstimate(("a", "b"), np.zeros(2), np.diag([1.0, 4.0]))
    wide = np.array([[9.0, 0.0, 5.8], [0.0, 1.0, 0.0], [5.8, 0.0, 4.0]])
    found = before.taken(GaussianEstimate(("a", "b", "new"), np.zeros(3), wide), [])
    assert np.linalg.eigvalsh(found.covariance).min() > 0.0
    assert np.diag(found.covariance).tolist() == pytest.approx([9.0, 4.0, 4.0])


def test_a_later_estimate_is_taken_for_some_names_and_for_what_is_new():
    before = GaussianEstimate(("rig", "free"), np.array([1.0, 2.0]), np.array([[4.0, 1.0], [1.0, 9.0]]))
    covariance = np.array([[0.1, 0.0, 0.05], [0.0, 0.2, 0.05], [0.05, 0.05, 0.3]])
    later = GaussianEstimate(
        ("rig", "free", "new"), np.array([1.5, 2.5, 3.5]), covariance, np.array([[5.0], [6.0], [7.0]])
    )
    found = before.taken(later, ["free"])
    assert found.names == ("rig", "free", "new")
    assert found.mean.tolist() == [1.0, 2.5, 3.5]
    np.testing.assert_allclose(found.covariance, [[4.0, 0.0, 0.05], [0.0, 0.2, 0.05], [0.05, 0.05, 0.3]])
    assert found.moves(("rig", "free", "new"), 1).tolist() == [[0.0], [6.0], [7.0]]
    assert before.taken(later._replace(slopes=None), ["free"]).slopes is None


def test_scatter_beyond_chance_widens_a_variance_the_more_blocks_show_it():
    """F = 3 of 8 blocks: d = 2, chance 4 * 2/8, 1 + 8/(4 + 1); no scatter below one counts."""
    white, scores = np.ones((8, 3)), np.zeros((8, 3))
    scores[:, 0], scores[:, 1], scores[0, 2] = np.sqrt(3.0), 0.5, np.sqrt(24.0)
    assert inflation(scores, white) == pytest.approx([2.6, 1.0, 2.6])
    alone = np.zeros((8, 3))
    alone[0] = 8.0  # one block holds all: its scatter shows hardly anything
    assert inflation(scores, alone)[0] == pytest.approx(1.0 + 8.0 / (4.0 + 8.0))
    assert inflation(np.zeros((4, 1)), np.zeros((4, 1))).tolist() == [1.0]


def test_a_condition_number_is_that_of_columns_of_length_one():
    information = np.array([[1.0, 0.8], [0.8, 1.0]])
    assert condition_number(information) == pytest.approx(3.0)  # eigenvalues 1.8 and 0.2
    units = np.diag([1e6, 1e-3])
    assert condition_number(units @ information @ units) == pytest.approx(3.0)
    assert condition_number(np.eye(1)) == 1.0
    for blind in (
        np.zeros((0, 0)),
        np.diag([1.0, 0.0]),
        np.array([[1.0, 1.0], [1.0, 1.0]]) - 1e-3 * np.eye(2),
    ):
        assert condition_number(blind) == np.inf


def test_names_tell_mean_deviation_moves_and_value():
    known = GaussianEstimate(
        ("a", "b"), np.array([2.0, 600.0]), np.diag([9.0, -1e-20]), np.array([[1.0], [2.0]])
    )
    assert (known.of("a"), known.of("b")) == ((2.0, 3.0), (600.0, 0.0))
    assert known.value("a", positive=True) == pytest.approx(np.exp(2.0))
    assert known.value("a", positive=False) == 2.0
    assert known.value("b", positive=True) == pytest.approx(np.exp(500.0))
    assert known.moves(("b", "c", "a"), 1).tolist() == [[2.0], [0.0], [1.0]]
    assert known._replace(slopes=None).moves(("a",), 2).tolist() == [[0.0, 0.0]]
    left = known.without("a", "c")
    assert (left.names, left.mean.tolist(), left.slopes.tolist()) == (("b",), [600.0], [[2.0]])


def test_what_is_owed_is_the_share_that_goes_if_others_were_exact():
    rows = np.array([[4.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 9.0]])
    known = GaussianEstimate(("a", "b", "c"), np.zeros(3), rows)
    assert known.owed("a", {"b"}) == pytest.approx(1.0 / 4.0)
    assert known.owed("a", {"b", "c", "d"}) == pytest.approx(1.0 / 4.0)
    assert known.owed("a", {"c"}) == 0.0
    assert known.owed("b", {"b"}) == pytest.approx(1.0)
    moved = known._replace(slopes=np.array([[2.0], [0.0], [0.0]]))
    assert moved.owed("a", {"b"}) == pytest.approx(1.0 / 8.0)
