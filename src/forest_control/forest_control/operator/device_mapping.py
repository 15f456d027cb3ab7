"""Which device's axis is which lever: from the raw values of an input device to those of a Joy message.

A mapped axis counts from its centre to its ends, -1..1, and is 0 within the driver's `flat`. A
trigger counts from its low end, 0..1. A minus turns the direction. An axis that stands for a button
presses it beyond half of its way. Several sources of one value: the one farthest from rest.

| symbol | name | unit |
|---|---|---|
| code | of an axis or a key, as in the kernel's input-event-codes.h | 1 |
| low, centre, high, flat | raw values of an axis | counts |
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

from forest_control.operator.device_state import DeviceState
from forest_control.operator.levers import LEFT_X, LEFT_Y, RIGHT_Y
from forest_msgs_py.interfaces.topics import JOY_AXES

LEVERS = (LEFT_X, LEFT_Y, RIGHT_Y)  # [1] places in Joy.axes that move something
TRIGGERS = tuple(place for place, name in enumerate(JOY_AXES) if name.endswith("_trigger"))
PRESSED = 0.5  # [1] deflection beyond which an axis presses a button: half of its way


class AxisRange(NamedTuple):
    """Raw values of an axis at its ends and at rest."""

    low: float
    centre: float
    high: float
    flat: float = 0.0  # about the centre: rest, as the driver tells

    def is_usable(self) -> bool:
        """Tell whether both halves have a length."""
        return self.low < self.centre - self.flat <= self.centre + self.flat < self.high


class InputSource(NamedTuple):
    """An axis in one direction, or a key."""

    code: int
    sign: float = 1.0
    is_key: bool = False


class DeviceMapping(NamedTuple):
    """What one device gives to the Joy message; patterns are those of a shell, "" fits anything."""

    role: str  # as the mapping file calls the device
    path: str = ""  # of the device or of a link to it; "": any
    name: str = ""
    phys: str = ""  # where it is plugged in
    uniq: str = ""  # serial number
    axes: Mapping[int, tuple[InputSource, ...]] = {}  # by place in Joy.axes
    buttons: Mapping[int, tuple[InputSource, ...]] = {}  # by place in Joy.buttons
    ranges: Mapping[int, AxisRange] = {}  # in place of the driver's, by code

    def needed(self, deadman: int) -> tuple[tuple[InputSource, ...], ...]:
        """Return the sources of levers and deadman, one of each of which a device must have."""
        levers = [self.axes[place] for place in LEVERS if place in self.axes]
        return (*levers, *([self.buttons[deadman]] if deadman in self.buttons else []))


class Reading(NamedTuple):
    """What is read of one device."""

    axes: Mapping[int, float]  # -1..1, by place in Joy.axes
    buttons: frozenset[int]  # pressed, as places in Joy.buttons
    reports: int  # that the device has sent since it was opened


def mapped(mapping: DeviceMapping, ranges: Mapping[int, AxisRange], state: DeviceState) -> Reading:
    """Return what a device's state means; axes and keys that the device has not are at rest.

    Args:
        mapping: of the device.
        ranges: of its axes, by code.
        state: raw.
    """
    axes = {
        place: max((_axis(s, place in TRIGGERS, ranges, state) for s in sources), key=abs)
        for place, sources in mapping.axes.items()
    }
    pressed = (place for place, sources in mapping.buttons.items() if _is_pressed(sources, ranges, state))
    return Reading(axes, frozenset(pressed), state.reports)


def _is_pressed(
    sources: tuple[InputSource, ...], ranges: Mapping[int, AxisRange], state: DeviceState
) -> bool:
    return any(
        s.code in state.keys if s.is_key else _axis(s, False, ranges, state) > PRESSED for s in sources
    )


def _axis(source: InputSource, one_sided: bool, ranges: Mapping[int, AxisRange], state: DeviceState) -> float:
    if source.code not in ranges:
        return 0.0
    scale = pull if one_sided else deflection
    return source.sign * scale(state.axes[source.code], ranges[source.code]) + 0.0  # no negative zero


def deflection(value: int, r: AxisRange) -> float:
    """Return -1..1 for a raw value of an axis that rests at its centre; 0 within `flat`."""
    away = value - r.centre
    half = r.high - r.centre if away > 0.0 else r.centre - r.low
    beyond = max(0.0, abs(away) - r.flat) / (half - r.flat)
    return math.copysign(min(1.0, beyond), away) if beyond else 0.0


def pull(value: int, r: AxisRange) -> float:
    """Return 0..1 for a raw value of an axis that rests at its low end."""
    return min(1.0, max(0.0, (value - r.low) / (r.high - r.low)))
