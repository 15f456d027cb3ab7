"""Operator profiles: stick curves, speeds, axis frame and mode of one person, in a file of theirs.

A profile is a YAML mapping of some of the controller's settings (`KEYS`) to values; what it does not name
keeps its default. Shipped ones are named by their file, others by their path.
"""

import math
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from forest_control.settings import Settings
from forest_control.tunables import TUNABLES, Tunable, as_typed

KEYS = (
    "mode",
    "axis_frame",
    "deadzone",
    "expo",
    "tip_speed",
    "axis_speed",
    "joint_rates",
    "position_span",
    "joint_span",
)
RULES = {tunable.name: tunable for tunable in TUNABLES if tunable.name in KEYS}
AXES = 3


class ProfileError(ValueError):
    """A profile is not usable; the message names file, key, value and what is allowed."""


def shipped() -> tuple[str, ...]:
    """Return the names of the shipped profiles."""
    folder = resources.files("forest_control") / "profiles"
    return tuple(sorted(Path(entry.name).stem for entry in folder.iterdir() if entry.name.endswith(".yaml")))


def load_profile(name: str) -> dict[str, Any]:
    """Return a profile's settings as people type them, every key of `KEYS`.

    Args:
        name: of a shipped profile, or the path of a file.

    Raises:
        ProfileError: no such profile, or something in it is not allowed.
    """
    try:
        if name in shipped():
            text = (resources.files("forest_control") / "profiles" / f"{name}.yaml").read_text("utf-8")
        else:
            text = Path(name).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        known = ", ".join(shipped())
        raise ProfileError(
            f"profile {name!r}: neither shipped ({known}) nor a readable file: {error}"
        ) from error
    try:
        given = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ProfileError(f"profile {name!r}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(given, dict):
        raise ProfileError(f"profile {name!r}: allowed: a mapping of {', '.join(KEYS)}")
    found = {key: as_typed(key, Settings()) for key in KEYS}
    for key, value in given.items():
        if key not in RULES:
            raise ProfileError(f"profile {name!r}: unknown key {key!r}; allowed: {', '.join(KEYS)}")
        found[key] = _checked(name, RULES[key], value, isinstance(found[key], tuple))
    return found


def _checked(name: str, rule: Tunable, value: Any, triple: bool) -> Any:
    """Return a value that follows its rule.

    Raises:
        ProfileError: it does not.
    """
    if rule.choices is not None:
        if value not in rule.choices:
            raise ProfileError(
                f"profile {name!r}: {rule.name} is {value!r}; allowed: {', '.join(rule.choices)}"
            )
        return value
    allowed = f"{rule.low:g} .. {rule.high:g} {rule.unit}".rstrip()
    numbers = value if triple and isinstance(value, list) else [value]
    if not all(_fits(number, rule) for number in numbers) or len(numbers) not in (1, AXES):
        many = "one number for all levers or three (swing, boom, stick), each " if triple else ""
        raise ProfileError(f"profile {name!r}: {rule.name} is {value!r}; allowed: {many}{allowed}")
    floats = [float(number) for number in numbers]
    return tuple(AXES // len(floats) * floats) if triple else floats[0]


def _fits(value: Any, rule: Tunable) -> bool:
    number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    return number and rule.low is not None and rule.high is not None and rule.low <= value <= rule.high
