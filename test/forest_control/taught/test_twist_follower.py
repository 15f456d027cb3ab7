"""A program's velocity leads the tip along its own way, while it comes in time and a person lets it."""

import math

import numpy as np
import pytest

from forest_control.operator.taught_command import NO_COMMAND
from forest_control.taught.taught_work import Seen
from forest_control.taught.twist_follower import (
    NO_WISH,
    Follower,
    TwistError,
    Wish,
    step,
    wish_of,
)
from forest_description.types import ZERO

TIP, ONWARD = (5.0, -1.0, 1.5), (0.2, 0.3, 0.6)  # [m], [m/s] of size 0.7
SEEN = Seen(time=77.0, tip=TIP, armed=True, centred=True)
READY = Follower(run=3.0, zeroed=True)
RUNS = Follower(run=70.0, runs=True, place=(4.9, -1.1, 1.4), zeroed=True)


def after(state, velocity=ONWARD, age=0.0, **seen):
    return step(state, Wish(velocity, 10.0 - age), SEEN._replace(**seen), 10.0)


def test_a_run_begins_where_the_tip_is_once_the_program_has_wished_nothing():
    assert after(Follower()) == (Follower(), None)
    ready, said = after(Follower(run=3.0), ZERO)
    assert (ready, said) == (READY, None)
    begun, command = after(ready)
    assert begun == Follower(run=77.0, runs=True, place=TIP, zeroed=True)
    assert command.place == TIP


def test_a_wish_is_a_straight_piece_from_where_the_tip_has_come_on_the_way():
    state, command = after(RUNS)
    t = np.array(ONWARD) / 0.7
    place = RUNS.place + np.dot(np.subtract(TIP, RUNS.place), t) * t
    assert (state.run, state.runs, state.zeroed) == (70.0, True, True)
    assert state.place == command.place == pytest.approx(place.tolist())
    assert command.tangent == pytest.approx(t.tolist())
    assert (command.curvature, command.left) == (ZERO, 1.0)
    assert command.speed == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("changed", "zeroed"),
    [
        ({"age": 0.11}, False),
        ({"armed": False}, False),
        ({"centred": False}, False),
        ({"velocity": (0.0, 0.0009, 0.0)}, True),
    ],
)
def test_what_ends_a_run_is_said_once_and_only_a_wish_of_nothing_lets_it_begin_anew(changed, zeroed):
    state, said = after(RUNS, **changed)
    assert said == NO_COMMAND
    assert state == Follower(run=70.0, zeroed=zeroed)
    assert after(state, **changed) == (state, None)
    assert after(state)[0].runs == zeroed
    assert after(after(state, ZERO)[0])[0].runs


def test_a_wish_that_is_nearly_too_old_or_too_small_still_counts():
    assert after(RUNS, age=0.09)[0].runs
    assert after(RUNS, (0.0, -0.0011, 0.0))[1].speed == pytest.approx(0.0011)
    assert step(RUNS, NO_WISH, SEEN, 10.0) == (Follower(run=70.0), NO_COMMAND)


def test_a_wish_is_read_in_the_frame_of_the_base_or_none():
    for frame in ("", "base_link"):
        assert wish_of(frame, ONWARD, ZERO, 4.0) == Wish(ONWARD, 4.0)


@pytest.mark.parametrize(
    ("frame", "linear", "angular", "said"),
    [
        ("odom", ONWARD, ZERO, "frame 'odom'; allowed: 'base_link' or none"),
        ("", (0.0, math.nan, 0.0), ZERO, "not finite"),
        ("", ONWARD, (0.0, 0.0, math.inf), "not finite"),
        ("", ONWARD, (0.0, 0.0, 0.1), "it turns"),
    ],
)
def test_what_cannot_be_followed_is_refused(frame, linear, angular, said):
    with pytest.raises(TwistError, match=said):
        wish_of(frame, linear, angular, 4.0)
