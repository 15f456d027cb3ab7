"""The input devices of a joystick: found, opened, read without waiting, and found again when plugged in.

A device fits a role when the mapping's patterns fit and it has the levers and the deadman that the
role maps. Exactly one must fit: of two alike, nobody knows which hand holds which.
"""

import contextlib
import errno
import os
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

from evdev import AbsInfo, InputDevice, InputEvent, ecodes

from forest_control.operator.device_mapping import AxisRange, DeviceMapping, InputSource, Reading, mapped
from forest_control.operator.device_state import DeviceState, after_events, read_anew

FOLDER = Path("/dev/input")
SEARCH_PERIOD = 0.5  # [s] between two looks for a device that is missing; chosen: plugging takes a second
Listing = Callable[[], tuple[list["InputDevice[str]"], list[str]]]


def input_devices() -> tuple[list["InputDevice[str]"], list[str]]:
    """Open every input device; return them, and the paths that this user may not open."""
    paths = sorted(map(str, FOLDER.glob("event*")))
    refused = [path for path in paths if not os.access(path, os.R_OK)]
    opened = [_device(path) for path in paths if path not in refused]
    return [device for device in opened if device is not None], refused


def _device(path: str) -> "InputDevice[str] | None":
    try:
        return InputDevice(path)
    except OSError:  # unplugged meanwhile
        return None


class _Opened(NamedTuple):
    device: "InputDevice[str]"
    ranges: dict[int, AxisRange]  # of its axes, by code
    state: DeviceState


class InputDevices:
    """The devices of a joystick, one of each role.

    Args:
        mappings: of the roles.
        deadman: the button to hold, as place in Joy.buttons.
        listing: gives all devices, opened, and the paths that may not be.
    """

    def __init__(
        self, mappings: Sequence[DeviceMapping], deadman: int, listing: Listing = input_devices
    ) -> None:
        self._mappings, self._deadman, self._listing = mappings, deadman, listing
        self._opened: dict[str, _Opened] = {}
        self._next_search = -1.0
        self.problem = ""  # what keeps a device from being found

    @property
    def names(self) -> str:
        """What is open, in words."""
        return ", ".join(f"{role}: {o.device.name} ({_path(o.device)})" for role, o in self._opened.items())

    def read(self, now: float) -> dict[str, Reading | None]:
        """Return what the devices say by now, by role; None: it is not there.

        Args:
            now: local monotonic time [s].
        """
        for role, opened in list(self._opened.items()):
            state = _state_of(opened)
            if state is None:
                self._close(role)
            else:
                self._opened[role] = opened._replace(state=state)
        if len(self._opened) < len(self._mappings) and now >= self._next_search:
            self._next_search = now + SEARCH_PERIOD
            self._search()
        return {mapping.role: self._reading(mapping) for mapping in self._mappings}

    def close(self) -> None:
        """Close all devices."""
        for role in list(self._opened):
            self._close(role)

    def _close(self, role: str) -> None:
        with contextlib.suppress(OSError):  # of a device that has gone
            self._opened.pop(role).device.close()

    def _reading(self, mapping: DeviceMapping) -> Reading | None:
        opened = self._opened.get(mapping.role)
        return mapped(mapping, opened.ranges, opened.state) if opened else None

    def _search(self) -> None:
        listed, refused = self._listing()
        taken = {_path(opened.device) for opened in self._opened.values()}
        fitting: dict[str, list[InputDevice[str]]] = {mapping.role: [] for mapping in self._mappings}
        for device in listed:
            for role in self._roles_of(device) if _path(device) not in taken else ():
                fitting[role].append(device)
        missing = [mapping for mapping in self._mappings if mapping.role not in self._opened]
        self.problem = _doubt(fitting) or _missing([m.role for m in missing if not fitting[m.role]], refused)
        kept = [self._taken(mapping, fitting[mapping.role]) for mapping in missing]
        for device in listed:
            if device not in kept:
                device.close()

    def _roles_of(self, device: "InputDevice[str]") -> list[str]:
        return [mapping.role for mapping in self._mappings if _fits(mapping, self._deadman, device)]

    def _taken(self, mapping: DeviceMapping, fitting: list["InputDevice[str]"]) -> "InputDevice[str] | None":
        if self.problem or not fitting:
            return None
        try:
            self._opened[mapping.role] = _opened(mapping, fitting[0])
        except OSError:  # unplugged meanwhile: the next search tells
            return None
        return fitting[0]


def _doubt(fitting: dict[str, list["InputDevice[str]"]]) -> str:
    """Return what is not clear about who is who; "": nothing."""
    for role, devices in fitting.items():
        paths = [_path(device) for device in devices]
        other = [r for r, others in fitting.items() if r != role and any(_path(d) in paths for d in others)]
        if len(paths) > 1:
            return f"joystick: {', '.join(paths)} fit {role}; allowed: one; name its path, phys or uniq"
        if other:
            return f"joystick: {paths[0]} fits {role} and {other[0]}; name their paths, phys or uniq"
    return ""


def _missing(roles: list[str], refused: list[str]) -> str:
    if not roles:
        return ""
    hint = f"; no permission for {', '.join(refused)}: join the group input" if refused else ""
    return f"joystick: no device fits {', '.join(roles)}{hint}"


def _path(device: "InputDevice[str]") -> str:
    return os.fsdecode(device.path)


def _fits(mapping: DeviceMapping, deadman: int, device: "InputDevice[str]") -> bool:
    if mapping.path and os.path.realpath(mapping.path) != os.path.realpath(_path(device)):
        return False
    told = ((mapping.name, device.name), (mapping.phys, device.phys), (mapping.uniq, device.uniq))
    if not all(fnmatchcase(text, pattern or "*") for pattern, text in told):
        return False
    try:
        keys, axes = _abilities(device)
    except OSError:
        return False
    ranges = _ranges(mapping, axes)
    return all(any(_has(keys, ranges, source) for source in needed) for needed in mapping.needed(deadman))


def _has(keys: set[int], ranges: dict[int, AxisRange], source: InputSource) -> bool:
    return source.code in (keys if source.is_key else ranges)


def _abilities(device: "InputDevice[str]") -> tuple[set[int], dict[int, AbsInfo]]:
    told: dict[int, list] = device.capabilities(absinfo=True)  # type: ignore[type-arg]
    return set(told.get(ecodes.EV_KEY, [])), dict(told.get(ecodes.EV_ABS, []))


def _ranges(mapping: DeviceMapping, axes: dict[int, AbsInfo]) -> dict[int, AxisRange]:
    """Return the usable ranges of a device's axes: the driver's, or those of the mapping."""
    told = {code: AxisRange(i.min, 0.5 * (i.min + i.max), i.max, i.flat) for code, i in axes.items()}
    told |= {code: r for code, r in mapping.ranges.items() if code in axes}
    return {code: r for code, r in told.items() if r.is_usable()}


def _opened(mapping: DeviceMapping, device: "InputDevice[str]") -> _Opened:
    ranges = _ranges(mapping, _abilities(device)[1])
    return _Opened(device, ranges, _read_anew(device, ranges, DeviceState({}, frozenset())))


def _read_anew(device: "InputDevice[str]", ranges: dict[int, AxisRange], state: DeviceState) -> DeviceState:
    return read_anew(state, {code: device.absinfo(code).value for code in ranges}, device.active_keys())


def _state_of(opened: _Opened) -> DeviceState | None:
    """Return a device's state after all that it has said; None: it has gone."""
    try:
        state = after_events(opened.state, _waiting(opened.device))
        return _read_anew(opened.device, opened.ranges, state) if state.stale else state
    except OSError:
        return None


def _waiting(device: "InputDevice[str]") -> Iterator[InputEvent]:
    while True:
        try:
            events = list(device.read())
        except BlockingIOError:
            return
        if not events:
            raise OSError(errno.ENODEV, "the device has ended")
        yield from events
