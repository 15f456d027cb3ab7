"""Claims about the levers and buttons that raw values of a device stand for."""

import itertools

import pytest
from evdev import ecodes

from forest_control.config.joystick_file import load_devices
from forest_control.operator.device_mapping import AxisRange, deflection, mapped, pull
from forest_control.operator.device_state import DeviceState
from forest_control.operator.levers import LEFT_SHOULDER, LEFT_X, LEFT_Y, RIGHT_Y
from forest_msgs_py.interfaces.topics import JOY_AXES, JOY_BUTTONS

BYTE = AxisRange(0, 127.5, 255, 15)
(GAMEPAD,) = load_devices("auto", LEFT_SHOULDER)
RANGES = {
    **dict.fromkeys((ecodes.ABS_X, ecodes.ABS_Y, ecodes.ABS_RX, ecodes.ABS_RY), BYTE),
    **dict.fromkeys((ecodes.ABS_Z, ecodes.ABS_RZ), AxisRange(0, 127.5, 255)),
    **dict.fromkeys((ecodes.ABS_HAT0X, ecodes.ABS_HAT0Y), AxisRange(-1, 0, 1)),
}
REST = {code: round(r.centre) for code, r in RANGES.items()} | {ecodes.ABS_Z: 0, ecodes.ABS_RZ: 0}


def read(*keys, **axes):
    raw = REST | {ecodes.ecodes[name]: value for name, value in axes.items()}
    return mapped(GAMEPAD, RANGES, DeviceState(raw, frozenset(ecodes.ecodes[key] for key in keys)))


def test_both_ends_are_one_the_centre_and_its_surroundings_are_zero_and_nothing_jumps():
    assert [deflection(v, BYTE) for v in (0, 127, 128, 142, 255)] == [-1.0, 0.0, 0.0, 0.0, 1.0]
    assert deflection(143, BYTE) == pytest.approx(0.5 / 112.5)
    for r in (BYTE, AxisRange(-32768, -0.5, 32767, 128), AxisRange(60, 512, 1000)):
        values = [deflection(v, r) for v in range(round(r.low) - 1, round(r.high) + 2)]
        steps = [b - a for a, b in itertools.pairwise(values)]
        assert min(steps) >= 0.0
        assert max(steps) < 1.01 / (min(r.high - r.centre, r.centre - r.low) - r.flat)
        assert (values[0], values[-1]) == (-1.0, 1.0)


def test_a_range_of_its_own_has_its_own_centre():
    r = AxisRange(60, 500, 1000)
    assert [deflection(v, r) for v in (60, 280, 500, 750, 1000, 1023)] == [-1.0, -0.5, 0.0, 0.5, 1.0, 1.0]
    assert [pull(v, AxisRange(0, 127.5, 255)) for v in (-3, 0, 51, 255, 300)] == [0.0, 0.0, 0.2, 1.0, 1.0]


@pytest.mark.parametrize("r", [(0, 0, 255), (5, 5, 5), (0, 128, 255, 128), (255, 128, 0)])
def test_an_axis_without_a_way_to_go_is_not_usable(r):
    assert not AxisRange(*r).is_usable()


def test_a_gamepads_sticks_are_positive_to_the_left_and_up_as_those_of_game_controller_node():
    assert not any(read().axes.values())
    assert read().buttons == frozenset()
    for name, place in (("ABS_X", LEFT_X), ("ABS_Y", LEFT_Y), ("ABS_RY", RIGHT_Y)):
        assert read(**{name: 0}).axes[place] == 1.0
        assert read(**{name: 255}).axes[place] == -1.0
        assert [p for p, value in read(**{name: 0}).axes.items() if value] == [place]
    assert read(ABS_Z=255).axes[JOY_AXES.index("left_trigger")] == -1.0
    assert read(ABS_Z=51).axes[JOY_AXES.index("left_trigger")] == pytest.approx(-0.2)


def test_a_gamepads_buttons_and_its_cross_of_either_kind_are_found():
    keys = {"BTN_SOUTH": "a", "BTN_EAST": "b", "BTN_TL": "left_shoulder", "BTN_DPAD_UP": "dpad_up"}
    for key, name in keys.items():
        assert read(key).buttons == {JOY_BUTTONS.index(name)}
    for name, (axis, value) in {
        "dpad_up": ("ABS_HAT0Y", -1),
        "dpad_down": ("ABS_HAT0Y", 1),
        "dpad_left": ("ABS_HAT0X", -1),
        "dpad_right": ("ABS_HAT0X", 1),
    }.items():
        assert read(**{axis: value}).buttons == {JOY_BUTTONS.index(name)}
    assert JOY_BUTTONS[LEFT_SHOULDER] == "left_shoulder"


def test_what_a_device_has_not_is_at_rest():
    reading = mapped(GAMEPAD, {ecodes.ABS_X: BYTE}, DeviceState({ecodes.ABS_X: 0}, frozenset(), 3))
    assert reading.axes[LEFT_X] == 1.0
    assert sum(map(abs, reading.axes.values())) == 1.0
    assert reading.reports == 3
