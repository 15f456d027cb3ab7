"""Texts of message types as they are installed: what makes a bag readable where they are not."""

import os
import re
import sys
from pathlib import Path

SEPARATOR = "=" * 80

_PRIMITIVES = frozenset(
    (
        *("bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16"),
        *("int32", "uint32", "int64", "uint64", "string", "wstring"),
    )
)
_TYPE = re.compile(r"^\s*([A-Za-z][\w/]*)")


def share_directories() -> list[Path]:
    """Where installed packages keep their files: the sourced ROS first, then this Python environment."""
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    return [Path(prefix) / "share" for prefix in prefixes if prefix]


def message_definition(type_name: str) -> str:
    """The text of a message type and of all types in it, in MCAP's ``ros2msg`` form.

    Args:
        type_name: like ``sensor_msgs/msg/JointState``.

    Raises:
        FileNotFoundError: the .msg file of the type, or of one within it, is not installed.
    """
    package, _, name = type_name.split("/")
    texts: dict[tuple[str, str], str] = {}
    _collect(package, name, texts)
    (_, first), *others = texts.items()
    return "\n".join([first, *(f"{SEPARATOR}\nMSG: {pkg}/{typ}\n{text}" for (pkg, typ), text in others)])


def _collect(package: str, name: str, texts: dict[tuple[str, str], str]) -> None:
    if (package, name) in texts:
        return
    texts[package, name] = text = _message_text(package, name)
    for line in text.splitlines():
        match = _TYPE.match(line.split("#")[0])
        if match and match[1] not in _PRIMITIVES:
            *owner, inner = match[1].split("/")
            _collect(owner[0] if owner else package, inner, texts)


def _message_text(package: str, name: str) -> str:
    for share in share_directories():
        file = share / package / "msg" / f"{name}.msg"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{package}/msg/{name}.msg is in no share directory of this environment")
