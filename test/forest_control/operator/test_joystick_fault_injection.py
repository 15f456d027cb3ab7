"""Faults of a joystick are read as people write them, and hold when they say."""

import math

import pytest

from forest_control.operator.joystick_fault_injection import JoystickFault, faults_at, parse_joystick_faults


def test_faults_are_read_with_their_times():
    text = "lost from 3 s until 4.5 s; frozen from 6s to 7 s\n released until .5 s;; bad"
    assert parse_joystick_faults(text) == (
        JoystickFault("lost", 3.0, 4.5),
        JoystickFault("frozen", 6.0, 7.0),
        JoystickFault("released", 0.0, 0.5),
        JoystickFault("bad", 0.0, math.inf),
    )
    assert parse_joystick_faults("") == ()


def test_a_fault_holds_from_its_start_to_just_before_its_end():
    faults = parse_joystick_faults("lost from 3 s until 4 s; released from 3.5 s")
    assert [faults_at(faults, t) for t in (2.999, 3.0, 3.5, 3.999, 4.0)] == [
        frozenset(),
        {"lost"},
        {"lost", "released"},
        {"lost", "released"},
        {"released"},
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "melted from 3 s",
            "'melted from 3 s' is no fault of a joystick; allowed: lost, frozen, released, bad",
        ),
        ("lost from 3", "'lost from 3' is no fault"),
        ("lost from -3 s", "is no fault"),
        ("lost from 4 s until 4 s", "from 4 s until 4 s; allowed: a later end"),
    ],
)
def test_what_is_no_fault_is_refused_with_what_is_allowed(text, words):
    with pytest.raises(ValueError, match="allowed") as error:
        parse_joystick_faults(text)
    assert words in str(error.value)
