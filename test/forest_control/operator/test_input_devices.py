"""Claims about input devices: events that python-evdev reads of a pipe, and who is who."""

import itertools
import os
import pty
import tty

import pytest
from evdev import AbsInfo, UInput, ecodes
from input_events import DROPPED, GAMEPAD_AXES, GAMEPAD_KEYS, Hand, PipedDevice, event, stream

from forest_control.config.joystick_file import load_devices
from forest_control.operator.input_devices import SEARCH_PERIOD, InputDevices, input_devices
from forest_control.operator.levers import LEFT_SHOULDER, LEFT_X, RIGHT_Y

AUTO = load_devices("auto", LEFT_SHOULDER)
TWO = """devices:
  left: {name: "*left*", axes: {left_x: -ABS_X, left_y: -ABS_Y}, buttons: {left_shoulder: BTN_TL}}
  right: {name: "*right*", axes: {right_y: -ABS_Y}, range: {ABS_Y: [0, 100, 255]}}
"""


class Plugged:
    """What is plugged in."""

    def __init__(self, *hands):
        self.hands, self.refused = list(hands), []

    def __call__(self):
        return [hand.device for hand in self.hands], self.refused


@pytest.fixture
def hand():
    return Hand()


@pytest.fixture
def devices(hand):
    devices = InputDevices(AUTO, LEFT_SHOULDER, Plugged(hand))
    yield devices
    devices.close()


def left_x(devices, now=0.0):
    reading = devices.read(now)["gamepad"]
    return reading and reading.axes[LEFT_X]


def test_events_move_the_lever_and_a_report_without_its_end_waits(devices, hand):
    assert left_x(devices) == 0.0
    hand.report(ABS_X=0, BTN_TL=1)
    reading = devices.read(0.1)["gamepad"]
    assert (reading.axes[LEFT_X], reading.buttons, reading.reports) == (1.0, {LEFT_SHOULDER}, 1)
    data = stream({"ABS_X": 255})
    hand.write(data[:-24])
    assert left_x(devices) == 1.0
    hand.write(data[-24:])
    assert left_x(devices) == -1.0


def test_all_that_waits_is_read_at_once(devices, hand):
    devices.read(0.0)
    for k in range(500):
        hand.report(ABS_X=k % 255)
    hand.report(ABS_X=255)
    assert left_x(devices) == -1.0
    assert devices.read(0.0)["gamepad"].reports == 501


def test_what_the_kernel_dropped_is_asked_for(devices, hand):
    devices.read(0.0)
    hand.write(event(*DROPPED) + stream({"ABS_X": 0}))
    hand.device.axes[0] = hand.device.axes[0]._replace(value=255)
    assert left_x(devices) == -1.0


def test_a_state_from_before_the_start_counts(hand):
    hand.report(BTN_TL=1, ABS_X=0)
    os.read(hand.device.fd, 1000)  # an event that came before the device was opened
    reading = InputDevices(AUTO, LEFT_SHOULDER, Plugged(hand)).read(0.0)["gamepad"]
    assert (reading.axes[LEFT_X], reading.buttons) == (1.0, {LEFT_SHOULDER})


def test_a_device_that_goes_is_missing_and_one_that_comes_is_found_again(hand):
    plugged = Plugged(hand)
    devices = InputDevices(AUTO, LEFT_SHOULDER, plugged)
    devices.read(0.0)
    hand.report(ABS_X=0)
    assert left_x(devices) == 1.0
    plugged.hands.clear()
    hand.unplug()
    assert left_x(devices, 0.1) is None
    again = Hand()
    plugged.hands.append(again)
    assert left_x(devices, 0.2) is None
    assert left_x(devices, 0.1 + SEARCH_PERIOD) == 0.0
    again.report(ABS_X=255)
    assert left_x(devices, 0.7) == -1.0
    assert devices.problem == ""
    assert devices.names == f"gamepad: Pad ({again.device.path})"


def test_an_error_of_the_device_is_its_end():
    ours, theirs = pty.openpty()  # a terminal whose other end hangs up gives EIO
    tty.setraw(theirs)
    os.set_blocking(theirs, False)
    device = PipedDevice(theirs)
    devices = InputDevices(AUTO, LEFT_SHOULDER, lambda: ([device], []))
    devices.read(0.0)
    os.write(ours, stream({"ABS_X": 0}))
    assert left_x(devices) == 1.0
    os.close(ours)
    assert left_x(devices, 0.1) is None


def test_two_gamepads_are_refused_until_one_is_named():
    one, two = Hand(), Hand()
    devices = InputDevices(AUTO, LEFT_SHOULDER, Plugged(one, two))
    assert left_x(devices) is None
    paths = f"{one.device.path}, {two.device.path}"
    assert devices.problem == f"joystick: {paths} fit gamepad; allowed: one; name its path, phys or uniq"
    one, two = Hand(), Hand()
    named = InputDevices(load_devices(two.device.path, LEFT_SHOULDER), LEFT_SHOULDER, Plugged(one, two))
    two.report(ABS_X=0)
    assert left_x(named) == 1.0


def test_a_device_without_the_levers_or_the_deadman_does_not_fit():
    keyboard = Hand(axes={}, keys=(30, 31))
    wheel = Hand(axes=dict(list(GAMEPAD_AXES.items())[:1]))
    paddle = Hand(keys=GAMEPAD_KEYS[:-1])
    flat = Hand(axes={code: info._replace(min=0, max=0) for code, info in GAMEPAD_AXES.items()})
    plugged = Plugged(keyboard, wheel, paddle, flat)
    plugged.refused = ["/dev/input/event99"]
    devices = InputDevices(AUTO, LEFT_SHOULDER, plugged)
    assert left_x(devices) is None
    assert devices.problem == (
        "joystick: no device fits gamepad; no permission for /dev/input/event99: join the group input"
    )


def test_two_joysticks_are_told_apart_by_the_mapping_file(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text(TWO)
    mappings = load_devices(str(file), LEFT_SHOULDER)
    left, right = Hand(name="Stick, left"), Hand(name="Stick, right")
    devices = InputDevices(mappings, LEFT_SHOULDER, Plugged(right, left))
    devices.read(0.0)
    left.report(ABS_X=0, BTN_TL=1)
    right.report(ABS_Y=50)
    readings = devices.read(0.0)
    assert readings["left"].axes[LEFT_X] == 1.0
    assert readings["right"].axes == {RIGHT_Y: 0.5}
    assert readings["right"].buttons == frozenset()


def test_a_device_that_fits_two_roles_is_refused_even_when_it_comes_first(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text(TWO.replace("*right*", "*").replace("*left*", "*"))
    mappings = load_devices(str(file), LEFT_SHOULDER)
    plugged = Plugged(Hand())
    devices = InputDevices(mappings, LEFT_SHOULDER, plugged)
    assert devices.read(0.0) == {"left": None, "right": None}
    assert "fits left and right; name their paths, phys or uniq" in devices.problem
    plugged.hands.append(Hand())
    assert devices.read(1.0) == {"left": None, "right": None}


@pytest.mark.skipif(
    not os.access("/dev/uinput", os.W_OK), reason="this kernel has no uinput that may be used"
)
def test_a_virtual_device_of_the_kernel_is_found_read_lost_and_found_again(wait_until):
    devices, searches = InputDevices(AUTO, LEFT_SHOULDER), itertools.count()

    def reads(swung):  # each look is a search: the kernel takes its time to show a device
        return left_x(devices, next(searches) * SEARCH_PERIOD) == swung

    assert left_x(devices, -1.0) is None
    for _ in range(2):
        with virtual_gamepad() as pad:
            wait_until(lambda: reads(0.0))
            move(pad, BTN_TL=1, ABS_X=0)
            wait_until(lambda: reads(1.0))
            for k in range(3000):  # more than the kernel keeps
                move(pad, ABS_X=k % 255)
            move(pad, ABS_X=255)
            wait_until(lambda: reads(-1.0))
            assert devices.read(0.0)["gamepad"].buttons == {LEFT_SHOULDER}
        wait_until(lambda: reads(None))


def virtual_gamepad():
    axes = [(code, AbsInfo(*info)) for code, info in GAMEPAD_AXES.items()]
    return UInput({ecodes.EV_KEY: GAMEPAD_KEYS, ecodes.EV_ABS: axes}, name="Virtual pad")


def move(pad, **values):
    for name, value in values.items():
        pad.write(ecodes.EV_ABS if name.startswith("ABS_") else ecodes.EV_KEY, ecodes.ecodes[name], value)
    pad.syn()


def test_the_devices_of_this_computer_can_be_listed():
    devices, refused = input_devices()
    assert all(device.path not in refused for device in devices)
    for device in devices:
        device.close()
