"""Claims about mapping files: what they say, and files that say what is wrong with them."""

from pathlib import Path

import pytest
from evdev import ecodes
from page_examples import examples

from forest_control.config.joystick_file import load_devices
from forest_control.config.setting_file import SettingFileError
from forest_control.operator.device_mapping import AxisRange, InputSource
from forest_control.operator.levers import LEFT_SHOULDER, LEFT_X, LEFT_Y, RIGHT_Y

ROOT = Path(__file__).resolve().parents[3]
GOOD = """
devices:
  left:
    phys: "usb-*/input0"
    axes: {left_x: -ABS_X, left_y: ABS_Y}
    buttons: {left_shoulder: [BTN_TRIGGER, -ABS_THROTTLE]}
    range: {ABS_X: [60, 512, 960]}
  right:
    path: /dev/input/by-path/right
    axes: {right_y: -ABS_Y}
"""


def load(tmp_path, text):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    return load_devices(str(file), LEFT_SHOULDER)


def test_a_file_names_two_joysticks(tmp_path):
    left, right = load(tmp_path, GOOD)
    assert (left.role, left.phys, right.role, right.path) == (
        *("left", "usb-*/input0"),
        *("right", "/dev/input/by-path/right"),
    )
    assert left.axes == {
        LEFT_X: (InputSource(ecodes.ABS_X, -1.0),),
        LEFT_Y: (InputSource(ecodes.ABS_Y, 1.0),),
    }
    assert right.axes == {RIGHT_Y: (InputSource(ecodes.ABS_Y, -1.0),)}
    assert left.buttons[LEFT_SHOULDER] == (
        InputSource(ecodes.BTN_TRIGGER, 1.0, True),
        InputSource(ecodes.ABS_THROTTLE, -1.0),
    )
    assert left.ranges == {ecodes.ABS_X: AxisRange(60.0, 512.0, 960.0)}


def test_the_example_of_the_page_is_a_mapping_file(tmp_path):
    (text,) = (e.text for e in examples(ROOT / "docs/how-to/use-a-joystick.md") if e.title)
    left, right = load(tmp_path, text)
    assert (set(left.axes), set(right.axes)) == ({LEFT_X, LEFT_Y}, {RIGHT_Y})


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("devices:", "device:", "unknown key 'device'; allowed: devices"),
        (GOOD, "devices: []", "devices is []; allowed: a mapping of one device or more"),
        ("phys", "port", "left: unknown key 'port'; allowed: name, path, phys, uniq, axes, buttons, range"),
        (
            "left_y: ABS_Y",
            "left_z: ABS_Y",
            "left.axes: unknown key 'left_z'; allowed: left_x, left_y, right_x",
        ),
        ("-ABS_X,", "BTN_TL,", "left.left_x is 'BTN_TL'; allowed: an axis (ABS_X, -ABS_X)"),
        ("-ABS_X,", "ABS_Q,", "left.left_x is 'ABS_Q'; allowed: an axis"),
        (
            "BTN_TRIGGER",
            "-BTN_TRIGGER",
            "left_shoulder is '-BTN_TRIGGER'; allowed: an axis (ABS_X, -ABS_X) or a key",
        ),
        ("BTN_TRIGGER", "3", "left_shoulder is 3; allowed"),
        (
            "[60, 512, 960]",
            "[60, 960, 512]",
            "ABS_X is [60, 960, 512]; allowed: low, centre and high, rising",
        ),
        ("[60, 512, 960]", "[0, .inf, 1]", "allowed: low, centre and high, rising"),
        ("{ABS_X: [60", "{BTN_TL: [60", "left.range: unknown key 'BTN_TL'; allowed: axes of the kernel"),
        ("right_y:", "left_y:", "no device has the axis right_y, which moves the crane"),
        (
            "{right_y: -ABS_Y}",
            "{right_y: -ABS_Y, left_y: ABS_Z}",
            "two devices have the axis left_y; allowed: one",
        ),
        ("left_shoulder", "right_shoulder", "no device has the button left_shoulder, which is the deadman"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, old, new, said):
    assert old in GOOD
    with pytest.raises(SettingFileError) as refused:
        load(tmp_path, GOOD.replace(old, new))
    assert said in str(refused.value)
    assert str(refused.value).startswith(f"joystick '{tmp_path}")


def test_a_path_is_a_gamepads_and_the_old_joystick_interface_is_refused():
    (gamepad,) = load_devices("/dev/input/event7", LEFT_SHOULDER)
    assert gamepad.path == "/dev/input/event7"
    with pytest.raises(SettingFileError, match="allowed: its event device, as in /dev/input/by-id"):
        load_devices("/dev/input/js0", LEFT_SHOULDER)
    with pytest.raises(SettingFileError, match=r"neither shipped \(gamepad\) nor a readable file"):
        load_devices("mine", LEFT_SHOULDER)
