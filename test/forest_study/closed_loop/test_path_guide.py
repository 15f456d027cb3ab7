"""An operator who leads the reference: the path is kept and the time gives, alone and in the loop."""

import math

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.taught.tip_path import cross_track_distance
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.path_guide import Guide, Hand, answered, asked, levers_for, place_at

TURN = np.linspace(0.0, 2.0 * np.pi, 1257)  # 0.2 m/s on a circle of 0.2 m, one place a period
CIRCLE = np.column_stack([0.2 * np.cos(TURN), 0.2 * np.sin(TURN), np.zeros(len(TURN))])
REST = 100


def profile(places=CIRCLE):
    """Places with a rest at both ends."""
    return np.vstack([np.repeat(places[:1], REST, axis=0), places, np.repeat(places[-1:], REST, axis=0)])


def led(places, limit=lambda _row, velocity: velocity, late=0, latency=0.0, rows=10_000):
    """Lead a reference that a limit holds back, and that answers so many periods late."""
    hand = Hand(0.5, latency)
    last, flat = len(places) - 1, places.ravel().tolist()
    guide, line = Guide(0.0, 0.0, tuple(places[0].tolist())), [(0.0, 0.0, 0.0)] * late
    found = []
    for row in range(rows):
        if guide.clock >= last:
            break
        found.append((guide.clock, *guide.place))
        line.append(asked(guide, hand, flat, last))
        said = levers_for(line[-1], hand)
        guide = answered(guide, said, limit(row, line.pop(0)), hand, flat, last)
    return np.array(found)


def halved(_row, velocity):
    return tuple(0.5 * v for v in velocity)


def test_without_a_limit_the_wish_is_the_profile_period_by_period():
    places = profile()
    found = led(places)
    np.testing.assert_allclose(found[:, 0], np.arange(len(places) - 1), atol=1e-9)
    np.testing.assert_allclose(found[:, 1:], places[:-1], atol=1e-9)


@pytest.mark.parametrize("late", [0, 3])
def test_a_limit_costs_time_and_not_the_path(late):
    places = profile()
    found = led(places, halved, late, float(late))
    assert len(found) == pytest.approx(2 * REST + 2 * len(CIRCLE), abs=16)
    assert cross_track_distance(CIRCLE, found[:, 1:]).max() < (1e-3 if late else 1e-4)
    assert np.linalg.norm(found[-1, 1:] - CIRCLE[-1]) < 4.1e-3  # the lead, at a speed that does not ramp down


def test_a_limit_that_acts_for_a_while_is_paid_by_its_own_time():
    found = led(profile(), lambda row, v: halved(row, v) if 300 <= row < 500 else v)
    assert len(found) == pytest.approx(len(profile()) + 100, abs=6)
    assert cross_track_distance(CIRCLE, found[:, 1:]).max() < 1e-4


def test_a_reference_that_is_pushed_aside_is_led_back():
    places = profile()
    found = led(places, lambda row, v: (v[0], v[1], v[2] + (0.4 if row == 400 else 0.0)))
    away = np.abs(found[:, 3])
    assert away[402] == pytest.approx(2e-3, rel=0.05)
    assert away[402 + round(1.0 / PERIOD)] == pytest.approx(2e-3 * math.exp(-3.0), rel=0.1)


def test_a_converter_that_knows_no_slower_motion_does_not_hold_the_clock():
    ramp = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 600)))
    places, hand = (
        profile(np.column_stack([0.3 * ramp, np.zeros(600), np.zeros(600)])),
        Hand(0.5, steps=127.0),
    )
    last, flat = len(places) - 1, places.ravel().tolist()
    guide, rows = Guide(0.0, 0.0, (0.0, 0.0, 0.0)), 0
    while guide.clock < last and rows < 2 * last:
        said = levers_for(asked(guide, hand, flat, last), hand)
        guide = answered(guide, said, (0.5 * said.stick, 0.5 * said.swing, 0.0), hand, flat, last)
        rows += 1
    assert rows == pytest.approx(last, abs=10)
    assert guide.place[0] == pytest.approx(0.3, abs=1e-3)


def test_a_corner_is_gone_through_though_the_reference_is_late():
    ramp = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 300)))
    one = np.column_stack([0.3 * ramp, np.zeros(300), np.zeros(300)])
    other = np.column_stack([np.full(300, 0.3), 0.3 * ramp, np.zeros(300)])
    corner = np.vstack([one, other])
    found = led(profile(corner), late=20, latency=20.0)
    assert cross_track_distance(corner, found[:, 1:]).max() < 2e-3
    assert np.linalg.norm(found[-1, 1:] - corner[-1]) < 1e-3


def test_a_reference_that_does_not_move_holds_the_clock():
    found = led(profile(), lambda _row, _v: (0.0, 0.0, 0.0), rows=2000)
    assert len(found) == 2000
    assert found[-1, 0] < REST + 3


def test_places_are_straight_between_periods_and_stay_at_both_ends():
    flat = CIRCLE.ravel().tolist()
    assert place_at(flat, 2.25, 1256) == pytest.approx(0.75 * CIRCLE[2] + 0.25 * CIRCLE[3])
    assert place_at(flat, -3.0, 1256) == pytest.approx(CIRCLE[0])
    assert place_at(flat, 5000.0, 1256) == pytest.approx(CIRCLE[-1])


def test_levers_are_those_of_a_message_or_of_a_converter():
    velocity = (0.123456789, -0.2, 0.7)
    exact = levers_for(velocity, Hand(0.5))
    assert list(exact) == [float(np.float32(x)) for x in (-0.4, 1.0, 0.123456789 / 0.5)]
    coarse = levers_for(velocity, Hand(0.5, steps=127.0))
    assert list(coarse) == [float(np.float32(x)) for x in (-51 / 127, 1.0, 31 / 127)]


def test_a_limit_in_the_loop_costs_time_and_not_the_path():
    """The controller allows a fifth of the joint rates that the plan was made with."""
    pytest.importorskip("llvmlite")
    from forest_control.servo.schemes import Scheme
    from forest_description.machine import load_machine
    from forest_study.tracking import tracking
    from forest_study.tracking.paths import path_named

    machine = load_machine("c180_hoses")
    course = tracking.prepare(path_named("circle_v"), 1.0, Scheme.COORDINATED, machine)
    rates = controller_settings.Settings().joint_rates
    slow = course.settings._replace(joint_rates=tuple(0.2 * rate for rate in rates))
    free, held = (tracking.follow(one, machine).total for one in (course, course._replace(settings=slow)))
    assert held.time_lost_s > 10.0
    assert held.duration_s > free.duration_s + 10.0
    # Granted a fifth of its wish, the reference turns 40 ms late (`ramped`): 7 mm on a radius of 1 m.
    assert held.cross_track_max_mm < free.cross_track_max_mm + 8.0
    assert held.cross_track_rms_mm < 2.5
    assert held.end_mm < 2.0
    assert held.wish_max_mm > 500.0
