"""A mapping file: which input device's axes and buttons are which of a Joy message.

    devices:
      left:                                # a role; one device each
        name: "Maker's stick*"             # patterns of a shell: name, phys (port), uniq (serial number)
        path: /dev/input/by-path/...       # or the device itself; what is absent fits anything
        axes: {left_x: -ABS_X, left_y: -ABS_Y}
        buttons: {left_shoulder: BTN_TRIGGER, dpad_up: [-ABS_HAT0Y, BTN_DPAD_UP]}
        range: {ABS_X: [60, 512, 960]}     # low, centre, high in place of the driver's

Names of axes and buttons are those of ROS's game_controller_node. Codes are the kernel's
(input-event-codes.h; `python -m evdev.evtest` shows them). A minus turns the direction.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from evdev import ecodes

from forest_control.config.setting_file import SettingFileError, is_number, shown, tree_of
from forest_control.operator.device_mapping import LEVERS, AxisRange, DeviceMapping, InputSource
from forest_msgs_py.interfaces.topics import JOY_AXES, JOY_BUTTONS

AUTO = "auto"
KEYS = ("name", "path", "phys", "uniq", "axes", "buttons", "range")
CODES: dict[str, int] = ecodes.ecodes
COUNTS = 2**31  # [1] raw values are 32-bit integers


def load_devices(device: str, deadman: int) -> tuple[DeviceMapping, ...]:
    """Return the mappings of a joystick's devices.

    Args:
        device: `auto` for the only gamepad, a gamepad's path below /dev, or a mapping file.
        deadman: the button to hold, as place in Joy.buttons.

    Raises:
        SettingFileError: no such file, or something in it is not allowed.
    """
    if device == AUTO or device.startswith("/dev/"):
        if Path(device).resolve().name.startswith("js"):
            raise SettingFileError(
                f"device {device!r} is of the old joystick interface; allowed: its event device, as in "
                "/dev/input/by-id/*-event-joystick"
            )
        gamepads = _Reader("gamepad").mappings(deadman)
        return tuple(m._replace(path="" if device == AUTO else device) for m in gamepads)
    return _Reader(device).mappings(deadman)


class _Reader:
    """Takes a file's tree apart; every complaint names the file."""

    def __init__(self, name: str) -> None:
        self._name = name

    def mappings(self, deadman: int) -> tuple[DeviceMapping, ...]:
        tree = self._mapping(tree_of("joystick", self._name, "joysticks"), ("devices",), "")
        devices: Any = tree.get("devices")
        if not isinstance(devices, dict) or not devices:
            self._refuse(f"devices is {shown(devices)}; allowed: a mapping of one device or more")
        found = tuple(self._device(str(role), device) for role, device in devices.items())
        self._check(found, deadman)
        return found

    def _check(self, found: tuple[DeviceMapping, ...], deadman: int) -> None:
        axes = [place for mapping in found for place in mapping.axes]
        for place in LEVERS:
            if place not in axes:
                self._refuse(f"no device has the axis {JOY_AXES[place]}, which moves the crane")
        for place in set(axes):
            if axes.count(place) > 1:
                self._refuse(f"two devices have the axis {JOY_AXES[place]}; allowed: one")
        if not any(deadman in mapping.buttons for mapping in found):
            self._refuse(f"no device has the button {JOY_BUTTONS[deadman]}, which is the deadman")

    def _device(self, role: str, tree: Any) -> DeviceMapping:
        tree = self._mapping(tree, KEYS, role)
        patterns = {key: str(tree.get(key, "")) for key in ("path", "name", "phys", "uniq")}
        axes = self._mapping(tree.get("axes", {}), JOY_AXES, f"{role}.axes")
        buttons = self._mapping(tree.get("buttons", {}), JOY_BUTTONS, f"{role}.buttons")
        return DeviceMapping(
            role,
            **patterns,
            axes={JOY_AXES.index(n): tuple(self._sources(f"{role}.{n}", v, False)) for n, v in axes.items()},
            buttons={
                JOY_BUTTONS.index(n): tuple(self._sources(f"{role}.{n}", v, True)) for n, v in buttons.items()
            },
            ranges=dict(self._ranges(f"{role}.range", tree.get("range", {}))),
        )

    def _sources(self, key: str, value: Any, keys: bool) -> Iterator[InputSource]:
        for text in value if isinstance(value, list) and value else [value]:
            name = text.removeprefix("-") if isinstance(text, str) else ""
            is_key = name.startswith(("BTN_", "KEY_"))
            allowed = "an axis (ABS_X, -ABS_X)" + (" or a key (BTN_TL)" if keys else "")
            if name not in CODES or not (name.startswith("ABS_") or (keys and is_key and name == text)):
                self._refuse(f"{key} is {shown(text)}; allowed: {allowed}")
            yield InputSource(CODES[name], 1.0 if name == text else -1.0, is_key)

    def _ranges(self, key: str, tree: Any) -> Iterator[tuple[int, AxisRange]]:
        for name, ends in self._mapping(tree, tuple(n for n in CODES if n.startswith("ABS_")), key).items():
            good = (
                isinstance(ends, list) and len(ends) == 3 and all(is_number(n, -COUNTS, COUNTS) for n in ends)
            )
            if not good or not AxisRange(*ends).is_usable():
                self._refuse(f"{key}.{name} is {shown(ends)}; allowed: low, centre and high, rising")
            yield CODES[name], AxisRange(*map(float, ends))

    def _mapping(self, tree: Any, allowed: tuple[str, ...], key: str) -> dict[str, Any]:
        where = f"{key}: " if key else ""
        names = ", ".join(allowed) if len(allowed) < 40 else "axes of the kernel, such as ABS_X"
        if not isinstance(tree, dict):
            self._refuse(f"{where}{shown(tree)}; allowed: a mapping of {names}")
        for name in tree:
            if name not in allowed:
                self._refuse(f"{where}unknown key {shown(name)}; allowed: {names}")
        return dict(tree)

    def _refuse(self, problem: str) -> None:
        raise SettingFileError(f"joystick {self._name!r}: {problem}")
