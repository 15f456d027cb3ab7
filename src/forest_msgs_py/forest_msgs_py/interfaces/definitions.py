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
WITHOUT_PACKAGE = {("tf2_msgs", "TFMessage"): "geometry_msgs/TransformStamped[] transforms\n"}
"""Texts of types that are written for viewers where their package, which is no wheel, is not installed."""
_DIVIDER = re.compile(r"^---.*\n?", re.MULTILINE)
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
    return _completed(package, _text(package, "msg", name))


def service_definitions(type_name: str) -> tuple[str, str]:
    """The texts of a service's request and response, each in MCAP's ``ros2msg`` form.

    Args:
        type_name: like ``std_srvs/srv/Trigger``.

    Raises:
        FileNotFoundError: the .srv file, or the .msg file of a type within it, is not installed.
    """
    package, _, name = type_name.split("/")
    request, response = _DIVIDER.split(_text(package, "srv", name), maxsplit=1)
    return _completed(package, request), _completed(package, response)


def _completed(package: str, text: str) -> str:
    """A package's text, followed by those of all types in it."""
    inner: dict[tuple[str, str], str] = {}
    _collect(package, text, inner)
    return "\n".join([text, *(f"{SEPARATOR}\nMSG: {pkg}/{typ}\n{one}" for (pkg, typ), one in inner.items())])


def _collect(package: str, text: str, texts: dict[tuple[str, str], str]) -> None:
    for line in text.splitlines():
        match = _TYPE.match(line.split("#")[0])
        if not match or match[1] in _PRIMITIVES:
            continue
        *owner, name = match[1].split("/")
        key = owner[0] if owner else package, name
        if key not in texts:
            texts[key] = _text(key[0], "msg", name)
            _collect(key[0], texts[key], texts)


def _text(package: str, kind: str, name: str) -> str:
    if (package, name) in WITHOUT_PACKAGE:
        return WITHOUT_PACKAGE[package, name]
    for share in share_directories():
        file = share / package / kind / f"{name}.{kind}"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{package}/{kind}/{name}.{kind} is in no share directory of this environment")
