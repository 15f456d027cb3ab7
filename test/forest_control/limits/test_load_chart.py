"""The laws of the load-moment limit by themselves: the chart, and which part of a motion loads."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from properties import between, vectors

from forest_control.config import controller_settings
from forest_control.limits import load_moment
from forest_control.limits.load_moment import (
    Loading,
    allowed_load,
    allowed_speed,
    believed_mass,
    load_scale,
    loading,
    unloaded,
)
from forest_control.pipeline.control_state import REST
from forest_control.pipeline.controller import counted_angles
from forest_description.derived.limits import pose_at
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.types import ZERO

REAL, C180 = load_machine("c180"), load_machine("c180_hoses")
TIP = (6.5, 0.0, -1.0)  # [m]


def test_the_chart_is_straight_between_its_points():
    c = load_moment.capacity(REAL)
    reaches, loads = REAL.capacity.reach, REAL.capacity.load
    for reach in np.linspace(0.0, 10.0, 101):
        assert allowed_load(float(reach), c) == pytest.approx(np.interp(reach, reaches, loads))
    two_points = dataclasses.replace(REAL.capacity, reach=(4.0, 9.0), load=(2000.0, 1000.0))
    c = load_moment.capacity(dataclasses.replace(REAL, capacity=two_points))
    assert [allowed_load(reach, c) for reach in (3.0, 4.0, 6.5, 9.0, 9.5)] == [2e3, 2e3, 1.5e3, 1e3, 1e3]
    assert len(c.reaches) == len(c.loads) == load_moment.MOST_POINTS
    free = load_moment.capacity(C180)
    assert allowed_load(8.0, free) == math.inf
    told = loading(9000.0, pose_at(TIP, C180), C180.manipulator.links, free)
    assert (told.mass, told.allowed, told.utilisation) == (9000.0, math.inf, 0.0)
    assert told.reach == pytest.approx(6.5)


TIPS = (vectors(-7.0, 7.0) | vectors(-0.7, 0.7)).filter(lambda p: math.hypot(p[0], p[1]) > 0.01)


@given(TIPS, vectors(-1.0, 1.0), between(0.8, 1.2))
def test_whatever_is_wished_no_more_loads_than_may_and_what_does_not_load_is_untouched(p, v, share):
    load = Loading(1000.0, math.hypot(p[0], p[1]), 1000.0, share)
    most, before = allowed_speed(load), np.array(parts(p, v))
    asked = before[0] + max(0.0, before[2])
    slid, left = unloaded(p, v, load, keeps_path=False)
    kept, part = unloaded(p, v, load, keeps_path=True)
    if asked <= max(most, load_moment.NEGLIGIBLE_SPEED):
        assert (slid, kept, left, part) == (v, v, 1.0, 1.0)
        return
    for after in (np.array(parts(p, slid)), np.array(parts(p, kept))):
        assert after[0] + max(0.0, after[2]) == pytest.approx(most, abs=1e-9)
    assert parts(p, slid)[1] == pytest.approx(before[1], abs=1e-9)
    assert kept == pytest.approx(part * np.array(v))
    assert 0.0 <= left <= 1.0


def parts(p, v):
    """A velocity outward, aside and up."""
    r = math.hypot(p[0], p[1])
    return (p[0] * v[0] + p[1] * v[1]) / r, (p[0] * v[1] - p[1] * v[0]) / r, v[2]


def test_what_is_not_weighed_counts_as_all_that_is_allowed():
    c, q = load_moment.capacity(REAL), pose_at(TIP, REAL)
    links = REAL.manipulator.links
    assert loading(math.nan, q, links, c).utilisation == 1.0
    loader = load_machine("loader")
    near = pose_at((loader.manipulator.links.base_offset + 0.7, 0.0, -1.9), loader)
    told = loading(math.nan, near, loader.manipulator.links, load_moment.capacity(loader))
    assert told.utilisation == 0.0  # or the crane could not get away from where nothing can be weighed
    c180 = REAL.manipulator.links
    for ahead, share in ((0.98, 0.0), (1.02, 1.0)):  # [m] of the tip from the boom's pivot
        boom = 1.2  # [rad]
        stick = math.acos((ahead - c180.boom * math.cos(boom)) / c180.stick) - boom
        assert loading(math.nan, (0.4, boom, stick), c180, c).utilisation == share
    assert loading(-50.0, q, links, c).utilisation == 0.0
    told = loading(575.0, q, links, c)
    assert told.reach == pytest.approx(math.hypot(*tip_position(q, links)[:2]))
    assert told.utilisation == pytest.approx(0.5)
    assert allowed_speed(told) == pytest.approx(told.reach)
    assert allowed_speed(told._replace(utilisation=1.3)) == 0.0
    assert unloaded(TIP, ZERO, told._replace(utilisation=1.3), keeps_path=False)[0] == ZERO


def test_the_numbers_are_what_the_documents_promise():
    assert (load_moment.WARNED, load_moment.APPROACH) == (0.9, 1.0)
    empty = Loading(0.0, 5.0, 1000.0, 0.0)
    assert allowed_speed(empty) == math.inf
    assert allowed_speed(empty._replace(utilisation=0.8)) == pytest.approx(5.0 * (1.0 / 0.8 - 1.0))


def test_nothing_is_known_of_what_was_not_looked_at_and_reach_has_no_sign():
    assert Loading() == pytest.approx(Loading(math.nan, math.nan, math.inf, 0.0), nan_ok=True)
    links = REAL.manipulator.links
    behind = (0.0, 2.6, 0.0)  # boom and stick over the column
    assert loading(0.0, behind, links, load_moment.capacity(REAL)).reach == pytest.approx(
        math.hypot(*tip_position(behind, links)[:2])
    )


def test_at_the_capacity_each_part_that_loads_is_taken_away_and_no_other():
    full = Loading(1000.0, 6.5, 1000.0, 1.0)
    assert unloaded(TIP, (0.5, 0.2, -0.3), full, keeps_path=False)[0] == pytest.approx((0.0, 0.2, -0.3))
    slid, left = unloaded(TIP, (-0.2, 0.1, 0.5), full, keeps_path=False)
    assert slid == pytest.approx((-0.2, 0.1, 0.2))  # up as far as it goes inward
    assert left == pytest.approx(0.3 / math.sqrt(0.3))
    half = full._replace(utilisation=0.95)
    most = allowed_speed(half)
    slid, _ = unloaded(TIP, (0.5, 0.0, 0.5), half, keeps_path=False)
    assert slid == pytest.approx((most / 2, 0.0, most / 2))


def test_joints_are_scaled_as_a_whole_and_the_load_at_the_column_is_that_of_any_direction():
    q, links = pose_at(TIP, REAL), REAL.manipulator.links
    load = loading(2000.0, q, links, load_moment.capacity(REAL))
    assert load_scale(q, (0.1, 0.0, 0.0), links, load) == 1.0
    assert load_scale(q, (0.0, 0.1, 0.0), links, load) == 0.0
    assert load_scale(q, (0.2, 0.1, 0.0), links, load) == 0.0
    assert unloaded((0.0, 0.0, 1.0), (0.3, 0.0, 0.0), load, keeps_path=True)[1] == 0.0
    assert unloaded((0.0, 0.0, 1.0), (0.0, 0.3, 0.0), load, keeps_path=True)[1] == 1.0


def test_a_chart_of_all_its_points_is_read_to_its_end():
    count = load_moment.MOST_POINTS
    full = load_moment.Capacity(
        tuple(map(float, range(count))), tuple(1000.0 - 10.0 * k for k in range(count))
    )
    assert allowed_load(count - 1.5, full) == pytest.approx(1000.0 - 10.0 * (count - 1.5))
    assert allowed_load(count + 3.0, full) == pytest.approx(1000.0 - 10.0 * (count - 1))


def test_over_the_column_outward_is_ahead():
    load = Loading(1000.0, 5.0, 1000.0, 0.98)
    most = allowed_speed(load)
    assert unloaded((0.0, 0.0, 1.0), (0.3, 0.0, 0.0), load, keeps_path=True)[1] == pytest.approx(most / 0.3)
    assert unloaded((0.0, 0.0, 1.0), (0.3, 0.0, 0.0), load, keeps_path=False)[0] == pytest.approx(
        (most, 0.0, 0.0)
    )


def test_a_motion_too_slow_to_be_one_passes():
    full = Loading(1000.0, 6.5, 1000.0, 1.0)
    slow = (0.9 * load_moment.NEGLIGIBLE_SPEED, 0.0, 0.0)
    assert unloaded(TIP, slow, full, keeps_path=False) == (slow, 1.0)


def test_a_mass_that_no_crane_can_carry_is_not_believed():
    p = controller_settings.parameters(REAL, controller_settings.Settings())
    head, allowed = 700.0, 1150.0  # [kg] of the file; the latter from 6 m on
    q = pose_at((7.5, 0.0, 0.0), REAL)

    def believed(mass, chart=p.capacity):
        return believed_mass(mass, head, q, p.links, chart)

    assert believed(5000.0) == 1.25 * allowed
    assert [believed(mass) for mass in (-700.0, 0.0, allowed)] == [-700.0, 0.0, allowed]
    assert believed(-2000.0) == -700.0
    assert math.isnan(believed(math.nan))
    assert believed(5000.0, load_moment.NO_CAPACITY) == 5000.0

    def tip(mass):
        state = REST._replace(weighing=REST.weighing._replace(mass=mass))
        return tip_position(counted_angles(q, state, p), p.links)

    assert math.dist(tip(0.0), tip(5000.0)) < 0.05  # 0.13 m if it were
