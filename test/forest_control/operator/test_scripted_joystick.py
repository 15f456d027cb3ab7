"""Claims about the joystick that is played from a source: what it sends, by the time since it began."""

import math
from pathlib import Path

import pytest

from forest_control.operator.joystick_sources import JoystickParameters, LeverError, thesis_levers
from forest_control.operator.levers import LEFT_SHOULDER, REST, Levers, levers_from_axes
from forest_control.operator.scripted_joystick import JoyMessage, ScriptedJoystick
from forest_msgs_py.runtime.parameter_table import ParameterError

BAG = Path(__file__).resolve().parents[3] / "bags" / "coordinated"


def decoded(data):
    return JoyMessage("bag", (float(len(data)),), (1,) * 21)


def joystick(**settings):
    return ScriptedJoystick(JoystickParameters(**settings), decoded)


def levers(message):
    return levers_from_axes(message.axes)


def held(message):
    return message.buttons[LEFT_SHOULDER] == 1


@pytest.fixture
def rows(tmp_path):
    path = tmp_path / "levers.csv"
    path.write_text("time_s,swing,boom,stick\n0,0.5,0,0\n0.1,0,0.5,0\n")
    return str(path)


def test_the_thesis_input_rests_plays_and_releases():
    played = joystick(tip_speed=0.6)
    assert played.length == 10.0
    before, during, after = (played.message(time) for time in (0.49, 2.5, 10.6))
    assert (levers(before), held(before)) == (REST, True)
    assert (levers(during), held(during)) == (thesis_levers(2.0, 0.6), True)
    assert (levers(after), held(after)) == (REST, False)
    assert not played.is_over(10.79)
    assert played.is_over(10.81)


def test_a_file_plays_for_as_long_as_it_is_or_is_told(rows):
    assert joystick(source=rows).length == 0.1
    cut = joystick(source=rows, duration=0.04, interpolate=False)
    assert levers(cut.message(0.53)) == Levers(0.5, 0.0, 0.0)
    assert levers(cut.message(0.55)) == REST
    assert levers(joystick(source=rows).message(0.55)).boom == pytest.approx(0.25)


def test_each_message_counts_on_the_last_words_too():
    played = joystick()
    frames = [played.message(0.1).frame, played.message(0.1).frame, played.released().frame]
    assert frames == ["heartbeat:1", "heartbeat:2", "heartbeat:3"]
    assert not any(played.released().buttons)


def test_another_deadman_button_is_held():
    message = joystick(deadman_button=3).message(0.1)
    assert [place for place, down in enumerate(message.buttons) if down] == [3]


def test_a_message_of_a_bag_is_sent_once_as_it_is():
    played = joystick(source=str(BAG))
    first = played.message(0.1)
    assert (first.frame, first.buttons) == ("bag", (1,) * 21)
    assert played.message(0.1) is None
    assert played.message(0.3) is not None
    assert not played.is_over(played.length)
    assert played.is_over(played.length + 0.01)


def test_lost_sends_nothing_and_frozen_repeats_the_last_message():
    assert joystick(faults="lost until 1 s").message(0.9) is None
    frozen = joystick(faults="frozen from 1 s")
    last = frozen.message(0.99)
    assert frozen.message(2.0) == last
    assert frozen.message(3.0) == last


def test_a_joystick_that_is_frozen_from_the_start_repeats_its_first_message():
    frozen = joystick(faults="frozen")
    assert frozen.message(0.0) == frozen.message(3.0)


def test_released_lets_the_deadman_go_and_leaves_all_else():
    released, sound = joystick(faults="released").message(2.5), joystick().message(2.5)
    assert not held(released)
    assert (released.axes, released.frame) == (sound.axes, sound.frame)
    played = joystick(source=str(BAG), faults="released").message(0.1)
    assert [place for place, down in enumerate(played.buttons) if not down] == [LEFT_SHOULDER]


def test_bad_levers_are_no_numbers_and_the_last_words_are_free_of_faults():
    bad = joystick(faults="bad; released from 3 s")
    assert all(map(math.isnan, bad.message(0.1).axes))
    assert held(bad.message(0.2))
    assert levers(bad.released()) == REST


def test_wrong_faults_and_sources_are_refused(tmp_path):
    with pytest.raises(
        ParameterError, match=r"parameter 'faults': 'sleepy' is no fault of a joystick; allowed"
    ):
        joystick(faults="sleepy")
    with pytest.raises(LeverError, match="cannot be read as CSV"):
        joystick(source=str(tmp_path / "none.csv"))
