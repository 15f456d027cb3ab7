"""Input devices without a kernel's: streams of `struct input_event` in a pipe, which python-evdev reads."""

import contextlib
import errno
import itertools
import os
import struct

from evdev import AbsInfo, ecodes
from evdev.eventio import EventIO

STICK = AbsInfo(value=128, min=0, max=255, fuzz=0, flat=15, resolution=0)
TRIGGER = STICK._replace(value=0, flat=0)
HAT = AbsInfo(value=0, min=-1, max=1, fuzz=0, flat=0, resolution=0)
GAMEPAD_AXES = {
    **dict.fromkeys((ecodes.ABS_X, ecodes.ABS_Y, ecodes.ABS_RX, ecodes.ABS_RY), STICK),
    **dict.fromkeys((ecodes.ABS_Z, ecodes.ABS_RZ), TRIGGER),
    **dict.fromkeys((ecodes.ABS_HAT0X, ecodes.ABS_HAT0Y), HAT),
}
GAMEPAD_KEYS = (ecodes.BTN_SOUTH, ecodes.BTN_EAST, ecodes.BTN_NORTH, ecodes.BTN_WEST, ecodes.BTN_TL)
SYN = (ecodes.EV_SYN, ecodes.SYN_REPORT, 0)
DROPPED = (ecodes.EV_SYN, ecodes.SYN_DROPPED, 0)
_numbers = itertools.count(1)


def event(kind, code, value):
    """Return the bytes of a `struct input_event`; 64 bits, the time does not matter here."""
    return struct.pack("llHHi", 0, 0, kind, code, value)


def stream(*reports):
    """Return the bytes of reports: each a mapping of codes (`ABS_X`) to values."""
    data = b""
    for report in reports:
        for name, value in report.items():
            kind = ecodes.EV_ABS if name.startswith("ABS_") else ecodes.EV_KEY
            data += event(kind, ecodes.ecodes[name], value)
        data += event(*SYN)
    return data


class PipedDevice(EventIO):
    """An `InputDevice` whose events come from a pipe; the kernel's answers are the test's."""

    def __init__(self, fd, name="Pad", axes=GAMEPAD_AXES, keys=GAMEPAD_KEYS, path=""):
        self.fd, self.name, self.phys, self.uniq = fd, name, "usb-1/input0", ""
        self.path = path or f"/dev/input/event{next(_numbers)}"
        self.axes, self.keys, self.down, self.refused = dict(axes), keys, set(), []

    def capabilities(self, absinfo=True):
        assert absinfo
        return {ecodes.EV_KEY: list(self.keys), ecodes.EV_ABS: list(self.axes.items())}

    def absinfo(self, code):
        if self.fd < 0:
            raise OSError(errno.ENODEV, "No such device")
        return self.axes[code]

    def active_keys(self):
        return list(self.down)

    def close(self):
        with contextlib.suppress(OSError):
            os.close(self.fd)
        self.fd = -1


class Hand:
    """Somebody who moves a piped device."""

    def __init__(self, **options):
        reader, self.writer = os.pipe2(os.O_NONBLOCK)
        self.device = PipedDevice(reader, **options)

    def report(self, **values):
        """Report values of codes (`ABS_X`, `BTN_TL`), as the kernel does; it remembers them, too."""
        for name, value in values.items():
            code = ecodes.ecodes[name]
            if name.startswith("ABS_"):
                self.device.axes[code] = self.device.axes[code]._replace(value=value)
            else:
                (self.device.down.add if value else self.device.down.discard)(code)
        self.write(stream(values))

    def write(self, data):
        os.write(self.writer, data)

    def unplug(self):
        os.close(self.writer)


def held_file(path):
    """Return the file that has a piped device plugged in with its deadman held and its stick to the left."""
    return path.with_suffix(".held")


def fifo_listing(path):
    """Return what lists the gamepad behind a named pipe, while there is one."""

    def listing():
        if not path.exists():
            return [], []
        device = PipedDevice(os.open(path, os.O_RDONLY | os.O_NONBLOCK), path=str(path))
        if held_file(path).exists():
            device.down.add(ecodes.BTN_TL)
            device.axes[ecodes.ABS_X] = STICK._replace(value=0)
        return [device], []

    return listing
