"""The place of work: the published task, contacts, and the vehicle."""

import dataclasses

import numpy as np
import pytest

from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_study.log_work import clearance, task
from forest_study.log_work.site import site_of
from forest_study.results import StudyError

MACHINE = load_machine("forwarder")
SITE = site_of(MACHINE)
STILL = np.zeros((1, 2))


def _angles(x, y, z):
    """Return a row of joint angles that hangs the grip at a place [m]."""
    return np.array([pose_at((x, y, z + SITE.hang), MACHINE)])


@pytest.mark.parametrize("name", ["c180", "c180_hoses", "loader", "forwarder"])
def test_every_shipped_crane_reaches_all_logs_with_one_in_the_grapple(name):
    site = site_of(load_machine(name))
    assert site.scale == pytest.approx(0.52 if name == "loader" else 0.97, abs=0.01)


def test_a_crane_that_does_not_reach_a_log_is_told():
    short = dataclasses.replace(MACHINE.boom, stroke=0.5 * MACHINE.boom.stroke)
    with pytest.raises(StudyError, match=r"does not reach the log red .*allowed"):
        site_of(dataclasses.replace(MACHINE, boom=short))


def test_the_task_is_that_of_the_published_trial():
    legs = task.legs(SITE)
    acts = [(leg.number, leg.act, leg.goal) for leg in legs if leg.act]
    ends = ["red on the ground", "red in the bunk", "blue on the ground", "blue in the bunk"]
    ends += ["red in the bunk", "red on the ground", "blue in the bunk", "blue on the ground"]
    assert [goal for _, _, goal in acts] == [SITE.places[name] for name in ends]
    assert [act for _, act, _ in acts] == ["grasp", "release"] * 4
    assert [leg.number for leg in legs if leg.part == task.ACROSS] == [1, 2, 3, 4, 5, 6, 7]
    assert all(leg.loaded == (leg.number % 2 == 1) for leg in legs[1:])
    across = [leg.goal[2] for leg in legs if leg.part == task.ACROSS and leg.number != 4]
    assert min(across) - SITE.log_radius > SITE.stake_top


def test_a_log_that_passes_between_and_over_the_stakes_touches_none():
    held = np.ones(1)
    for name in ("red in the bunk", "blue in the bunk"):
        x, y, z = SITE.places[name]
        for height in (z, SITE.clear):
            assert clearance.contacts(MACHINE.manipulator, SITE, _angles(x, y, height), STILL, held) == 0


def test_a_log_that_crosses_a_stake_and_one_in_the_ground_are_contacts():
    x, y, _ = SITE.places["red in the bunk"]
    low = _angles(x, 2.3 * y, SITE.stake_top - 0.3)
    across = np.concatenate([_angles(x, y, SITE.clear), low, low, _angles(x, y, SITE.clear)])
    rows = np.zeros((4, 2))
    assert clearance.contacts(MACHINE.manipulator, SITE, across, rows, np.ones(4)) >= 1
    red = SITE.places["red on the ground"]
    deep = _angles(red[0], red[1], red[2] - 2.0 * SITE.near)
    m = MACHINE.manipulator
    assert clearance.contacts(m, SITE, deep, STILL, np.ones(1)) == 2  # log and grapple
    assert clearance.contacts(m, SITE, _angles(*red), STILL, np.ones(1)) == 0


def test_the_usual_vehicle_grows_with_the_crane_and_a_told_one_is_taken():
    site = site_of(load_machine("loader"))
    assert site.chassis.half_width == pytest.approx(1.35 * site.scale)
    assert site.chassis.mass == pytest.approx(15000.0 * site.scale**3)
    assert SITE.chassis == MACHINE.chassis
