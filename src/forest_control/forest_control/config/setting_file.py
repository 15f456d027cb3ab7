"""YAML files of settings, read while the controller may be moving a crane.

Whatever such a file is, be it a pipe, a picture or a page of brackets, the node goes on. One
sentence says what is wrong with the file.
"""

from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from forest_msgs_py.interfaces.yaml_text import LARGEST, parsed

SHOWN = 80  # [1] characters of a value in a message: a line of a terminal


class SettingFileError(ValueError):
    """A file is not usable; the message names it and says what is allowed."""


def shipped_in(folder: str) -> tuple[str, ...]:
    """Return the names of the files that come with this package in a folder of it."""
    entries = (resources.files("forest_control") / folder).iterdir()
    return tuple(sorted(Path(entry.name).stem for entry in entries if entry.name.endswith(".yaml")))


def tree_of(kind: str, name: str, folder: str) -> Any:
    """Return the content of a shipped file, by its name, or of another, by its path.

    Args:
        kind: of file, as messages call it.
        name: shipped name, or path.
        folder: of this package, with the shipped ones.

    Raises:
        SettingFileError: no such file, too large or no regular one, or not YAML.
    """
    try:
        return parsed(_text(kind, name, folder))
    except SettingFileError:
        raise
    except (OSError, ValueError) as error:  # a name may hold what no name may, a file no text
        known = ", ".join(shipped_in(folder))
        raise SettingFileError(
            f"{kind} {name!r}: neither shipped ({known}) nor a readable file: {error}"
        ) from error
    except yaml.YAMLError as error:
        raise SettingFileError(f"{kind} {name!r}: not YAML: {' '.join(str(error).split())}") from error


def is_number(value: Any, low: float, high: float) -> bool:
    """Tell whether a file's value is a number within finite bounds."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and low <= value <= high


def shown(value: Any) -> str:
    """Return a file's value for a message, not too long."""
    try:
        text = repr(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits
        return "a number of thousands of digits"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def _text(kind: str, name: str, folder: str) -> str:
    if name in shipped_in(folder):
        return (resources.files("forest_control") / folder / f"{name}.yaml").read_text("utf-8")
    path = Path(name)
    if path.exists() and not path.is_file():  # reading a pipe would hold the node up
        raise SettingFileError(f"{kind} {name!r}: allowed: a regular file")
    if path.stat().st_size > LARGEST:
        raise SettingFileError(f"{kind} {name!r}: {path.stat().st_size} bytes; allowed: up to {LARGEST}")
    return path.read_text("utf-8")
