"""Operator profiles: stick curves, speeds, axis frame and mode of one person, in a file of theirs.

A profile is a YAML mapping of some of the controller's settings (`KEYS`) to values; what it does
not name is as in the shipped `default`, and gains are by the machine's rule. Shipped ones are named
by their file, others by their path.
"""

from typing import Any

from forest_control.config.controller_settings import Settings
from forest_control.config.setting_file import SettingFileError, is_number, shipped_in, shown, tree_of
from forest_description.types import AXES
from forest_msgs_py.runtime.parameter_table import Parameter, table_rows

GAINS = ("feedback_gain", "integral_gain", "rate_gain", "lead_time")  # of the coordinated scheme
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
    *GAINS,
)
RULES = {row.name: row for row in table_rows(Settings) if row.name in KEYS}


def shipped() -> tuple[str, ...]:
    """Return the names of the shipped profiles."""
    return shipped_in("profiles")


def load_profile(name: str) -> dict[str, Any]:
    """Return a profile's settings as people type them, every key of `KEYS`.

    Args:
        name: of a shipped profile, or the path of a file.

    Raises:
        SettingFileError: no such profile, or something in it is not allowed.
    """
    return _overlaid(_overlaid({key: RULES[key].default for key in KEYS}, "default"), name)


def with_gains_of(settings: Settings, name: str) -> Settings:
    """Return settings with a profile's gains.

    Args:
        settings: all else.
        name: as of `load_profile`.

    Raises:
        SettingFileError: as `load_profile`.
    """
    told = load_profile(name)
    return settings._replace(**{key: told[key] for key in GAINS})


def _overlaid(found: dict[str, Any], name: str) -> dict[str, Any]:
    """Return settings, those that a profile names changed.

    Raises:
        SettingFileError: no such profile, or something in it is not allowed.
    """
    given, found = tree_of("profile", name, "profiles"), dict(found)
    if not isinstance(given, dict):
        raise SettingFileError(f"profile {name!r}: allowed: a mapping of {', '.join(KEYS)}")
    for key, value in given.items():
        if key not in RULES:
            raise SettingFileError(f"profile {name!r}: unknown key {shown(key)}; allowed: {', '.join(KEYS)}")
        found[key] = _checked(name, RULES[key], value, isinstance(found[key], tuple))
    return found


def _checked(name: str, rule: Parameter, value: Any, triple: bool) -> Any:
    """Return a value that follows its rule.

    Raises:
        SettingFileError: it does not.
    """
    if rule.choices is not None:
        if value not in rule.choices:
            raise SettingFileError(
                f"profile {name!r}: {rule.name} is {shown(value)}; allowed: {', '.join(rule.choices)}"
            )
        return value
    allowed = f"{rule.low:g} .. {rule.high:g} {rule.unit}".rstrip()
    numbers = value if triple and isinstance(value, list) else [value]
    if not all(_fits(number, rule) for number in numbers) or len(numbers) not in (1, len(AXES)):
        many = "one number for all levers or three (swing, boom, stick), each " if triple else ""
        raise SettingFileError(f"profile {name!r}: {rule.name} is {shown(value)}; allowed: {many}{allowed}")
    floats = [float(number) for number in numbers]
    return tuple(len(AXES) // len(floats) * floats) if triple else floats[0]


def _fits(value: Any, rule: Parameter) -> bool:
    return rule.low is not None and rule.high is not None and is_number(value, rule.low, rule.high)
