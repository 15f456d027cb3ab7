"""One recorded message as one row of a table: stamp, labels, units, numbers; nothing is judged here.

What a live node may believe is judged in :mod:`forest_msgs_py.interfaces.messages`; a record is
shown as it is.
"""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

import numpy as np

from forest_msgs_py.interfaces.stamps import MOST_STAMP
from forest_msgs_py.interfaces.topics import (
    CLOCK,
    FLOAT_ARRAY,
    JOINT_STATE,
    JOY_AXES,
    JOY_BUTTONS,
    JOY_TYPE,
    POSE,
    TIP_POSE,
    TIP_TWIST,
    TWIST,
    Topic,
)
from forest_msgs_py.types import NS_PER_S

LONGEST_ARRAY = 256
EMPTY = "structure_needs_at_least_one_member"  # DDS knows no message without fields


class Row(NamedTuple):
    """One message taken apart; ``stamp_ns`` is None where it carries no stamp."""

    stamp_ns: int | None
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: tuple[float, ...]


def _stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * NS_PER_S + int(message.header.stamp.nanosec)


def _flatten_joints(topic: Topic, message: Any) -> Row:
    """Columns name.position for all joints, then .velocity and .effort where the message has them."""
    names = tuple(message.name)
    parts = (("position", message.position), ("velocity", message.velocity), ("effort", message.effort))
    present = [(part, data) for part, data in parts if len(data) == len(names)]
    units = dict(zip(topic.labels, topic.units, strict=True))
    split = [[*units.get(name, "").split(", "), "", ""][:3] for name in names]
    order = {"position": 0, "velocity": 1, "effort": 2}
    return Row(
        _stamp(message),
        tuple(f"{name}.{part}" for part, _ in present for name in names),
        tuple(unit[order[part]] for part, _ in present for unit in split),
        tuple(value for _, data in present for value in data.tolist()),
    )


def _flatten_array(topic: Topic, message: Any) -> Row:
    offset = int(message.layout.data_offset)
    values = tuple(message.data[offset:].tolist())
    text = message.layout.dim[0].label if message.layout.dim else ""
    labels = tuple(text.split(",")) if text else topic.labels
    if len(labels) != len(values):
        labels = tuple(f"value_{place}" for place in range(len(values)))
    units = dict(zip(topic.labels, topic.units, strict=True))
    return Row(_array_stamp(message), labels, tuple(units.get(label, "") for label in labels), values)


def _array_stamp(message: Any) -> int | None:
    """The stamp that leads an array of ours; None where there is none, or nothing that can be one."""
    stamp: Any = message.data[:2] if message.layout.data_offset == 2 else ()
    if len(stamp) < 2 or not all(abs(number) < MOST_STAMP for number in stamp):
        return None
    return int(stamp[0]) * NS_PER_S + int(stamp[1])


def _flatten_pose(_topic: Topic, message: Any) -> Row:
    point, turn = message.pose.position, message.pose.orientation
    values = (point.x, point.y, point.z, turn.x, turn.y, turn.z, turn.w)
    return Row(_stamp(message), TIP_POSE.labels, TIP_POSE.units, values)


def _flatten_twist(_topic: Topic, message: Any) -> Row:
    speed = message.twist.linear
    return Row(_stamp(message), TIP_TWIST.labels, TIP_TWIST.units, (speed.x, speed.y, speed.z))


def _flatten_joy(_topic: Topic, message: Any) -> Row:
    axes = _named(JOY_AXES, "axis", len(message.axes))
    buttons = _named(JOY_BUTTONS, "button", len(message.buttons))
    labels = (*axes, *(f"button_{name}" for name in buttons))
    values = (*map(float, message.axes), *map(float, message.buttons))
    return Row(_stamp(message), labels, ("1",) * len(labels), values)


def _named(names: tuple[str, ...], kind: str, count: int) -> tuple[str, ...]:
    return (*names, *(f"{kind}_{place}" for place in range(len(names), count)))[:count]


def _flatten_clock(_topic: Topic, message: Any) -> Row:
    stamp = int(message.clock.sec) * NS_PER_S + int(message.clock.nanosec)
    return Row(stamp, CLOCK.labels, CLOCK.units, (stamp / NS_PER_S,))


def flatten_any(_topic: Topic, message: Any) -> Row:
    """Every number of a message of any type, by its path like ``twist.linear.x``; units nobody knows.

    Texts and arrays of more than LONGEST_ARRAY elements (pictures, point clouds) are left out.
    """
    header = getattr(message, "header", None)
    found: dict[str, float] = {}
    _collect_numbers(message, "", found)
    stamp = _stamp(message) if hasattr(header, "stamp") else None
    return Row(stamp, tuple(found), ("",) * len(found), tuple(found.values()))


def _collect_numbers(value: Any, path: str, found: dict[str, float]) -> None:
    if is_dataclass(value):
        for name in _fields(value):
            if path or name != "header":
                _collect_numbers(getattr(value, name), f"{path}.{name}" if path else name, found)
    elif isinstance(value, (bool, int, float)):
        found[path] = float(value)
    elif not isinstance(value, str) and len(value) <= LONGEST_ARRAY:
        for place, element in enumerate(value.tolist() if isinstance(value, np.ndarray) else value):
            _collect_numbers(element, f"{path}_{place}", found)


def texts(message: Any) -> dict[str, Any]:
    """What `flatten_any` leaves out of a message, by its path: texts, and long arrays."""
    found: dict[str, Any] = {}
    _collect_texts(message, "", found)
    return found


def _collect_texts(value: Any, path: str, found: dict[str, Any]) -> None:
    if is_dataclass(value):
        for name in _fields(value):
            _collect_texts(getattr(value, name), f"{path}.{name}" if path else name, found)
    elif isinstance(value, str):
        found[path] = value
    elif hasattr(value, "__len__") and len(value) > LONGEST_ARRAY:
        found[path] = value.tobytes() if isinstance(value, np.ndarray) else str(value)
    elif isinstance(value, (list, tuple)):
        for place, element in enumerate(value):
            _collect_texts(element, f"{path}_{place}", found)


def _fields(message: Any) -> list[str]:
    """Names of a message's fields; the constants of its type, which rosbags counts among them, are none."""
    names = [field.name for field in fields(message) if not str(field.type).startswith("ClassVar")]
    return [name for name in names if name != EMPTY]


FLATTENERS: dict[str, Callable[[Topic, Any], Row]] = {
    JOINT_STATE: _flatten_joints,
    FLOAT_ARRAY: _flatten_array,
    POSE: _flatten_pose,
    TWIST: _flatten_twist,
    JOY_TYPE: _flatten_joy,
    CLOCK.type: _flatten_clock,
}
