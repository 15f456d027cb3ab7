"""Claims about walls: the tip slides along them, brakes before them, and can always leave."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import vectors

from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace, shipped
from forest_control.limits.workspace import (
    BOX,
    CYLINDER,
    MOST,
    NO_WALL,
    OPEN,
    PLANE,
    Wall,
    Workspace,
    clearance,
    slide,
    wall_scaling,
)

GROUND = Wall(PLANE, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), -1.0)
FENCE = Wall(PLANE, (0.0, 0.6, 0.8), (0.0, 0.0, 0.0), -2.0)
CAB = Wall(BOX, (-2.0, -1.0, -1.0), (-0.5, 1.0, 1.5), 0.0)
PILLAR = Wall(CYLINDER, (0.5, 0.5, -1.0), (0.0, 0.0, 1.0), 0.6)
EVERY = (GROUND, FENCE, CAB, PILLAR)


def workspace(*walls, approach=4.0):
    return Workspace((*walls, *(NO_WALL,) * (MOST - len(walls))), approach, len(walls))


def random_points(rng, count):
    return [tuple(p) for p in rng.uniform(-3.0, 3.0, (count, 3)).tolist()]


@pytest.mark.parametrize("wall", EVERY, ids=["plane", "slope", "box", "cylinder"])
def test_the_gap_is_the_distance_and_its_gradient(wall):
    rng, step = np.random.default_rng(1), 1e-6
    for p in random_points(rng, 500):
        near = clearance(p, wall)
        assert np.linalg.norm(near.away) == pytest.approx(1.0, abs=1e-9)
        there = tuple(x + step * n for x, n in zip(p, near.away, strict=True))
        assert clearance(there, wall).distance - near.distance == pytest.approx(step, rel=1e-3)


@given(vectors(-3.0, 3.0), vectors(-2.0, 2.0))
def test_what_is_left_is_never_too_fast_and_what_leads_away_is_kept(p, wish):
    w = workspace(*EVERY)
    left = slide(p, wish, w)
    for wall in EVERY:
        near = clearance(p, wall)
        assert -np.dot(left, near.away) <= max(0.0, w.approach * near.distance) + 1e-5
    assert np.dot(left, left) <= np.dot(wish, wish) + 1e-9
    if all(np.dot(wish, clearance(p, wall).away) >= 0.0 for wall in EVERY):
        assert left == wish


@given(vectors(-3.0, 3.0), vectors(-2.0, 2.0), st.sampled_from(EVERY))
def test_of_one_wall_what_is_too_fast_towards_it_is_taken_away_and_nothing_else(p, wish, wall):
    near = clearance(p, wall)
    excess = max(0.0, -np.dot(wish, near.away) - max(0.0, 4.0 * near.distance))
    left = np.add(wish, excess * np.array(near.away))
    assert slide(p, wish, workspace(wall)) == pytest.approx(left, abs=2e-5)


def test_along_a_wall_nothing_is_taken_away():
    w = workspace(GROUND)
    assert slide((1.0, 2.0, -1.0), (0.3, -0.4, -0.5), w) == pytest.approx((0.3, -0.4, 0.0))
    assert slide((1.0, 2.0, -1.2), (0.3, -0.4, 0.5), w) == (0.3, -0.4, 0.5)
    assert slide((1.0, 2.0, -0.9), (0.0, 0.0, -0.5), w) == pytest.approx((0.0, 0.0, -0.4))
    assert slide((1.0, 2.0, -0.9), (0.0, 0.0, -0.5), OPEN) == (0.0, 0.0, -0.5)


def test_the_tip_arrives_without_passing_and_slides_on_to_the_corner():
    w, p, dt = workspace(GROUND, CAB), (1.0, 0.0, 0.0), 0.005
    lowest = nearest = 1.0
    for _ in range(4000):
        v = slide(p, (-0.5, 0.0, -0.5), w)
        p = tuple(x + dt * u for x, u in zip(p, v, strict=True))
        lowest, nearest = min(lowest, p[2]), min(nearest, p[0])
    assert p == pytest.approx((-0.5, 0.0, -1.0), abs=1e-3)
    assert lowest >= -1.0 - 1e-9
    assert nearest >= -0.5 - 1e-9


def test_joints_are_slowed_together():
    w = workspace(GROUND)
    assert wall_scaling((0.0, 0.0, -0.9), (0.3, 0.0, -0.8), w) == pytest.approx(0.5)
    assert wall_scaling((0.0, 0.0, -1.1), (0.3, 0.0, 0.8), w) == 1.0
    assert wall_scaling((0.0, 0.0, -1.1), (0.3, 0.0, -0.1), w) == 0.0


def test_joints_are_slowed_by_the_wall_that_allows_least_whichever_it_is():
    rng, slowed = np.random.default_rng(4), dict.fromkeys(range(4), 0)
    w = workspace(*EVERY)
    for p in random_points(rng, 2000):
        wish = tuple(rng.normal(0.0, 1.0, 3).tolist())
        gaps = [clearance(p, wall) for wall in EVERY]
        speeds = [-np.dot(wish, near.away) for near in gaps]
        most = [
            max(0.0, 4.0 * near.distance) / speed if speed > 1e-6 else 1.0
            for near, speed in zip(gaps, speeds, strict=True)
        ]
        assert wall_scaling(p, wish, w) == pytest.approx(min(1.0, *most), rel=1e-12)
        if min(most) < 1.0:
            slowed[int(np.argmin(most))] += 1
    assert min(slowed.values()) > 10, slowed


def test_rounding_towards_a_wall_does_not_stop_the_joints():
    at, w = (0.0, 0.0, -1.1), workspace(GROUND)
    assert wall_scaling(at, (0.3, 0.0, -0.9e-6), w) == 1.0
    assert wall_scaling(at, (0.3, 0.0, -1.1e-6), w) == 0.0


def test_what_is_no_wall_is_far_and_walls_beyond_the_number_do_not_count():
    wish = (0.1, -0.2, -0.3)
    assert clearance((0.0, 0.0, 0.0), NO_WALL).distance > 1e6
    assert slide((0.0, 0.0, -2.0), wish, workspace(GROUND, FENCE)._replace(number=0)) == wish
    assert wall_scaling((0.0, 0.0, -2.0), wish, workspace(GROUND, FENCE)._replace(number=0)) == 1.0
    assert slide((0.0, 0.0, -2.0), wish, OPEN) == wish
    assert wall_scaling((0.0, 0.0, -2.0), wish, OPEN) == 1.0


def test_in_a_corner_too_sharp_to_slide_into_the_tip_stops_and_it_may_still_leave():
    """A valley of 10 degrees: each wall's slope leads into the other, in ever smaller steps."""
    steep, flat = math.cos(math.radians(5.0)), math.sin(math.radians(5.0))
    walls = [Wall(PLANE, (side * steep, 0.0, flat), (0.0, 0.0, 0.0), 0.0) for side in (-1.0, 1.0)]
    for wish in ((0.0, 0.0, -1.0), (0.0, 0.3, -1.0), (0.02, 0.0, -1.0)):
        assert slide((0.0, 0.0, 0.0), wish, workspace(*walls)) == (0.0, 0.0, 0.0)
    assert slide((0.0, 0.0, 0.0), (0.0, 0.3, 1.0), workspace(*walls)) == (0.0, 0.3, 1.0)
    assert slide((0.0, 0.0, 9.0), (0.0, 0.3, -0.1), workspace(*walls)) == (0.0, 0.3, -0.1)


BOX_LOW, BOX_HIGH = (-1.0, -2.0, -3.0), (1.0, 2.0, 3.0)
BLOCK = Wall(BOX, BOX_LOW, BOX_HIGH, 0.0)


@pytest.mark.parametrize(("axis", "side"), list(itertools.product(range(3), (-1.0, 1.0))))
def test_a_tip_within_a_box_leaves_by_the_nearest_side_and_outside_keeps_off_it(axis, side):
    """The corners are not alike, so no side is taken for another."""
    normal = tuple(side * (i == axis) for i in range(3))
    face = (BOX_LOW, BOX_HIGH)[side > 0.0][axis]
    for depth in (-0.3, 0.0, 0.7):
        p = tuple(face + side * depth if i == axis else 0.1 for i in range(3))
        distance, away = clearance(p, BLOCK)
        assert distance == pytest.approx(depth, abs=1e-12)
        assert away == normal


def test_off_an_edge_and_a_corner_of_a_box_the_distance_is_straight():
    away = (2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0)
    for signs in itertools.product((-1.0, 1.0), repeat=3):
        p = tuple(s * (c + 0.3 * a) for s, c, a in zip(signs, BOX_HIGH, away, strict=True))
        near = clearance(p, BLOCK)
        assert near.distance == pytest.approx(0.3)
        assert near.away == pytest.approx(tuple(s * a for s, a in zip(signs, away, strict=True)))


@pytest.mark.parametrize(
    ("across", "z", "distance", "away"),
    [
        *((0.9, 0.0, 0.3, (1.0, 0.0)), (0.5, 0.0, -0.1, (1.0, 0.0)), (0.0, 0.45, -0.55, (0.0, 1.0))),
        *((0.1, 0.9, -0.1, (0.0, 1.0)), (0.1, -0.9, -0.1, (0.0, -1.0))),
        *((0.1, 1.2, 0.2, (0.0, 1.0)), (0.1, -1.2, 0.2, (0.0, -1.0))),
        *((0.9, 1.4, 0.5, (0.6, 0.8)), (0.9, -1.4, 0.5, (0.6, -0.8)), (0.6, 0.0, 0.0, (1.0, 0.0))),
        (0.6, 1.3, 0.3, (0.0, 1.0)),
    ],
)
def test_a_pillar_is_left_by_its_mantle_or_its_ends_whichever_is_nearer(across, z, distance, away):
    for turn in (0.0, 2.0, 4.0):
        e = math.cos(turn), math.sin(turn)
        near = clearance((0.5 + across * e[0], 0.5 + across * e[1], z), PILLAR)
        assert near.distance == pytest.approx(distance, abs=1e-9)
        assert near.away == pytest.approx((away[0] * e[0], away[0] * e[1], away[1]), abs=1e-9)


def test_on_the_axis_of_a_pillar_some_way_leads_out():
    thick = Wall(CYLINDER, (0.5, 0.5, -9.0), (0.0, 0.0, 9.0), 0.6)
    near = clearance((0.5, 0.5, 0.0), thick)
    assert near.distance == -0.6
    assert np.linalg.norm(near.away) == 1.0
    assert near.away[2] == 0.0


def test_files_are_read_with_their_margin(tmp_path):
    path = tmp_path / "yard.yaml"
    path.write_text(
        "ground: -1.5\nmargin: 0.1\nstay_inside: {lower: [-5, -5, -5], upper: [5, 5, 5]}\n"
        "boxes: [{lower: [1, 1, 1], upper: [2, 2, 2]}]\n"
        "cylinders: [{centre: [0, 3], radius: 0.5, lower: -1, upper: 1}]\n"
    )
    w = load_workspace(str(path))
    assert w.number == 9
    assert clearance((0.0, 0.0, -1.0), w.walls[0]).distance == pytest.approx(0.4)
    inside = [clearance((4.0, 0.0, 0.0), wall).distance for wall in w.walls[1:7]]
    assert min(inside) == pytest.approx(0.9)
    assert clearance((0.0, 1.5, 1.5), w.walls[7]).distance == pytest.approx(0.9)
    assert clearance((0.0, 2.0, 0.0), w.walls[8]).distance == pytest.approx(0.4)
    assert load_workspace("") == OPEN


def test_a_dozen_walls_are_read_and_no_more(tmp_path):
    path, box = tmp_path / "yard.yaml", "{lower: [1, 1, 1], upper: [2, 2, 2]}"
    path.write_text(f"boxes: [{', '.join([box] * 12)}]\n")
    assert load_workspace(str(path)).number == 12
    path.write_text(f"ground: -1\nboxes: [{', '.join([box] * 12)}]\n")
    with pytest.raises(SettingFileError, match="13 walls; allowed: up to 12"):
        load_workspace(str(path))


@pytest.mark.parametrize("name", shipped())
def test_shipped_workspaces_are_read(name):
    assert load_workspace(name).number > 0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("ground: low", "ground is 'low'; allowed: -1000 .. 1000 m"),
        ("ground: .nan", "ground is nan; allowed"),
        ("grund: 1", "unknown key 'grund'; allowed: ground, stay_inside"),
        ("boxes: [{lower: [0, 0, 0]}]", "boxes[0]: no upper; allowed: lower, upper"),
        ("boxes: [{lower: [0, 0, 0], upper: [1, 1, 0]}]", "boxes[0]: lower [0.0, 0.0, 0.0] is not below"),
        (
            "cylinders: [{centre: [0], radius: 1, lower: 0, upper: 1}]",
            "cylinders[0].centre is [0]; allowed: 2",
        ),
        ("approach: 0", "approach is 0; allowed: 0.1 .. 20 1/s"),
        ("stay_inside: {lower: [0, 0, 0], upper: [1, 1, 1]}\nmargin: 0.6", "stay_inside: nothing is left"),
        ("- 1", "allowed: a mapping of ground"),
        ("a: [", "not YAML"),
        ("ground: 2001-99-99", "not YAML: month must be in 1..12"),
        ("ground: " + 400 * "9", "ground is 9"),
    ],
)
def test_a_bad_file_is_refused_in_one_sentence(tmp_path, text, said):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(SettingFileError) as error:
        load_workspace(str(path))
    assert said in str(error.value)
    assert "bad.yaml" in str(error.value)
    with pytest.raises(SettingFileError, match="neither shipped"):
        load_workspace(str(tmp_path / "none.yaml"))
