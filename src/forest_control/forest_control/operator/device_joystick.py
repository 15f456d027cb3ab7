"""A joystick made of one input device or several: what it sends, and when it is silent.

Devices tell changes only, and a driver that hangs tells none. So the watch over joysticks looks at
each device by itself: another one that moves does not hide it.

| state of the joystick | sends |
|---|---|
| a device is missing | one sample at rest, then nothing |
| a device is still for too long, with a lever deflected or the deadman held | the same |
| all there, not yet released and centred since | samples at rest |
| all there | what the devices say |

At rest means released and centred. A device is still for too long when the watch would call it
frozen: after `frozen_timeout`, or sooner if noise has shown that it never holds still.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

from forest_control.operator.device_mapping import Reading
from forest_control.operator.joystick_watch import (
    Sample,
    Watch,
    WatchParameters,
    assessed_watch,
    is_centred,
    is_still,
    updated_watch,
)
from forest_control.operator.levers import AXIS_COUNT, BUTTON_COUNT, Levers, levers_from_axes
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.runtime.parameter_table import Parameter

RESTING = JoyValues((0.0,) * AXIS_COUNT, (0,) * BUTTON_COUNT)


class DeviceParameters(NamedTuple):
    """Of `joystick_node`: the device under a hand."""

    device: Annotated[
        str, Parameter("auto, a device below /dev/input, or a mapping file; empty: play the source")
    ] = ""
    frozen_timeout: Annotated[
        float,
        Parameter(
            "time without any change, deadman held or lever deflected, after which the device is frozen",
            "s",
            0.5,
            60.0,
        ),
    ] = 10.0


class Following(NamedTuple):
    """What is remembered of one device."""

    watch: Watch = Watch()
    reports: int = -1  # that it had sent; -1: it was not there


class DeviceJoystick(NamedTuple):
    """What is remembered of the joystick."""

    devices: tuple[Following, ...]
    sends: bool = False  # it was not silent last time
    rested: bool = False  # it has been released and centred since


class Sent(NamedTuple):
    """What the joystick sends."""

    values: JoyValues | None  # None: nothing
    problem: str = ""  # why it is at rest or silent


NOT_RESTED = "joystick: release the deadman and centre the levers; nothing moves before"
HUNG = "joystick: device {} is still for too long: held, or it hangs; release it, and centre it"


def step(
    joystick: DeviceJoystick,
    readings: Mapping[str, Reading | None],
    now: float,
    p: DeviceParameters,
    deadman: int,
) -> tuple[DeviceJoystick, Sent]:
    """Return the joystick after a look at its devices, and what it sends.

    Args:
        joystick: so far.
        readings: of every device, by its role; None: it is not there.
        now: local monotonic time [s].
        p: the user's.
        deadman: the button to hold, as place in Joy.buttons.
    """
    w = WatchParameters(frozen_timeout=p.frozen_timeout)
    pairs = zip(joystick.devices, readings.values(), strict=True)
    devices = tuple(_followed(device, reading, now, w, deadman) for device, reading in pairs)
    there = [reading for reading in readings.values() if reading is not None]
    if len(there) < len(readings):
        return _silenced(joystick, devices, "")
    for role, device, reading in zip(readings, devices, there, strict=True):
        if is_still(device.watch, now, w) and not _is_released(reading, w, deadman):
            return _silenced(joystick, devices, HUNG.format(role))
    rested = joystick.rested or all(_is_released(reading, w, deadman) for reading in there)
    sent = Sent(_merged(there)) if rested else Sent(RESTING, NOT_RESTED)
    return DeviceJoystick(devices, True, rested), sent


def _followed(
    device: Following, reading: Reading | None, now: float, w: WatchParameters, deadman: int
) -> Following:
    if reading is None:
        return Following()
    sample = Sample(
        received=now,
        same=reading.reports == device.reports,
        good=True,
        levers=_levers(reading),
        held=deadman in reading.buttons,
    )
    watch, _ = assessed_watch(updated_watch(device.watch, sample), now, True, w)
    return Following(watch, reading.reports)


def _silenced(
    joystick: DeviceJoystick, devices: tuple[Following, ...], problem: str
) -> tuple[DeviceJoystick, Sent]:
    return DeviceJoystick(devices), Sent(RESTING if joystick.sends else None, problem)


def _is_released(reading: Reading, w: WatchParameters, deadman: int) -> bool:
    return deadman not in reading.buttons and is_centred(_levers(reading), w.centre)


def _levers(reading: Reading) -> Levers:
    return levers_from_axes(tuple(reading.axes.get(place, 0.0) for place in range(AXIS_COUNT)))


def _merged(readings: Sequence[Reading]) -> JoyValues:
    axes = [0.0] * AXIS_COUNT
    for reading in readings:
        for place, value in reading.axes.items():
            axes[place] = value
    pressed = frozenset[int]().union(*(reading.buttons for reading in readings))
    return JoyValues(tuple(axes), tuple(int(place in pressed) for place in range(BUTTON_COUNT)))
