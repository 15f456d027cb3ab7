"""The map of `forest-bag from-csv`: which column of somebody's log is which signal of ours, in which unit.

A signal is ``scale · cell + offset`` in its unit, or a constant ``value``:

    time: {column: t, unit: ms}              # or {rate: 50, unit: Hz}; start: s that are added to all times
    file: {delimiter: ";", decimal: ",", header: false, skip: 2}          # all optional
    checks: {rate: {value: 50, unit: Hz, percent: 5}, max_gap: {value: 0.1, unit: s}}         # optional
    topics:
      joint_states:
        boom.position: {column: boom angle, unit: deg, scale: -1, offset: 90}
      joy:
        button_left_shoulder: {value: 1}
"""

import contextlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from forest_bag.storage.bag_files import BagError
from forest_description.config.units import UNITS
from forest_msgs_py.interfaces.topics import (
    FLOAT_ARRAY,
    JOINT_STATE,
    JOY,
    JOY_AXES,
    JOY_BUTTONS,
    POSE,
    TOPICS,
    TWIST,
    Topic,
)
from forest_msgs_py.interfaces.yaml_text import read_yaml


class LogUnit(NamedTuple):
    """``(number + offset) * factor`` is in ``si``."""

    si: str
    factor: float
    offset: float = 0.0


# What logs have and machine files have not.
LOG_UNITS = {name: LogUnit(unit.si, unit.factor) for name, unit in UNITS.items()} | {
    "us": LogUnit("s", 1e-6),
    "ns": LogUnit("s", 1e-9),
    "min": LogUnit("s", 60.0),
    "kPa": LogUnit("Pa", 1e3),
    "cm": LogUnit("m", 1e-2),
    "deg/s": LogUnit("rad/s", math.pi / 180.0),
    "mm/s": LogUnit("m/s", 1e-3),
    "in/s": LogUnit("m/s", 0.0254),
    "kN*m": LogUnit("N*m", 1e3),
    "lbf": LogUnit("N", 4.4482216152605),
    "lbf*ft": LogUnit("N*m", 4.4482216152605 * 0.3048),
    "mV": LogUnit("V", 1e-3),
    "degC": LogUnit("K", 1.0, 273.15),
    "degF": LogUnit("K", 5.0 / 9.0, 459.67),
}
PARTS = ("position", "velocity", "effort")


class Signal(NamedTuple):
    """One column, or with an empty name one constant, as a signal of a topic."""

    column: str
    scale: float
    offset: float
    unit: LogUnit

    def si(self, cell: float) -> float:
        """The cell's number in SI units."""
        return (self.scale * cell + self.offset + self.unit.offset) * self.unit.factor


class FileForm(NamedTuple):
    """How the file is written; an empty delimiter is found out."""

    delimiter: str = ""
    decimal: str = "."
    header: bool = True
    skip: int = 0


class LogMap(NamedTuple):
    """The whole map; ``time`` is None where samples come at ``rate`` [Hz]."""

    form: FileForm
    time: Signal | None
    rate: float
    start: float  # [s]
    wanted_rate: tuple[float, float] | None  # [Hz], share by which it may differ
    max_gap: float  # [s]
    topics: dict[Topic, dict[str, Signal]]


def mappable() -> dict[str, Topic]:
    """Topics that a log can become, by name."""
    kinds = (JOINT_STATE, FLOAT_ARRAY, POSE, TWIST, JOY.type)
    return {topic.name: topic for topic in TOPICS if topic.type in kinds}


def signal_units(topic: Topic) -> dict[str, str]:
    """The signals that a topic has, with their SI units in the units table's spelling."""
    if topic.type == JOY.type:
        return dict.fromkeys([*JOY_AXES, *(f"button_{name}" for name in JOY_BUTTONS)], "1")
    if topic.type == JOINT_STATE:
        split = {label: unit.split(", ") for label, unit in zip(topic.labels, topic.units, strict=True)}
        return {
            f"{label}.{part}": _plain(split[label][n])
            for n, part in enumerate(PARTS)
            for label in topic.labels
        }
    return {label: _plain(unit) for label, unit in zip(topic.labels, topic.units, strict=True)}


def _plain(unit: str) -> str:
    return unit.replace("³", "3").replace("²", "2").replace("·", "*")


def read_map(path: Path) -> LogMap:
    """Read a map.

    Raises:
        BagError: it is not YAML, or something in it is not as it should be.
        OSError: it cannot be read.
    """
    try:
        content = read_yaml(path)
        return _map(_keys(content, "", {"time", "topics"}, {"file", "checks"}))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BagError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    except BagError as error:
        raise BagError(f"{path}: {error}") from error


def _map(content: Mapping[str, Any]) -> LogMap:
    time = _keys(content["time"], "time", set(), {"column", "rate", "unit", "start", "scale", "offset"})
    if ("column" in time) == ("rate" in time):
        raise BagError("time has column and rate, or neither; allowed: one of them")
    form = FileForm(**_keys(content.get("file") or {}, "file", set(), set(FileForm._fields)))
    if len(form.delimiter) > 1 or len(form.decimal) != 1 or not isinstance(form.skip, int) or form.skip < 0:
        raise BagError("file: delimiter and decimal are one character each, skip is a count of lines")
    checks = _keys(content.get("checks") or {}, "checks", set(), {"rate", "max_gap"})
    wanted = None
    if "rate" in checks:
        entry = _keys(checks["rate"], "checks.rate", {"value"}, {"unit", "percent"})
        share = _number(entry.get("percent", 5), "checks.rate.percent") / 100.0
        if share < 0.0:
            raise BagError(f"checks.rate.percent is {100.0 * share:g}; allowed: 0 or more")
        wanted = _quantity({k: entry[k] for k in entry if k != "percent"}, "checks.rate", "Hz"), share
    return LogMap(
        form=form,
        time=_signal({k: v for k, v in time.items() if k != "start"}, "time", "s")
        if "column" in time
        else None,
        rate=_quantity({"value": time["rate"], "unit": time.get("unit", "Hz")}, "time.rate", "Hz")
        if "rate" in time
        else 0.0,
        start=_number(time.get("start", 0), "time.start"),
        wanted_rate=wanted,
        max_gap=_quantity(checks["max_gap"], "checks.max_gap", "s") if "max_gap" in checks else math.inf,
        topics=_topics(content["topics"]),
    )


def _topics(content: Any) -> dict[Topic, dict[str, Signal]]:
    known = mappable()
    found = {}
    for name, entries in _keys(content, "topics", set(), None).items():
        topic = known.get(str(name).lstrip("/")) or known.get(str(name))
        if topic is None:
            raise BagError(f"topics: no topic '{name}'; allowed: {', '.join(known)}")
        units = signal_units(topic)
        signals = _keys(entries, f"topics.{name}", set(), set(units))
        if not signals:
            raise BagError(f"topics.{name} is empty; allowed: {', '.join(units)}")
        found[topic] = {
            label: _signal(entry, f"topics.{name}.{label}", units[label]) for label, entry in signals.items()
        }
    if not found:
        raise BagError(f"topics is empty; allowed: {', '.join(known)}")
    return found


def _signal(entry: Any, where: str, si: str) -> Signal:
    entry = _keys(entry, where, set(), {"column", "value", "unit", "scale", "offset"})
    if ("column" in entry) == ("value" in entry):
        raise BagError(f"{where} has column and value, or neither; allowed: one of them")
    unit = _unit(entry.get("unit", si), where, si)
    scale, offset = (_number(entry.get(k, d), f"{where}.{k}") for k, d in (("scale", 1), ("offset", 0)))
    if "value" in entry:
        return Signal("", 0.0, offset + scale * _number(entry["value"], f"{where}.value"), unit)
    return Signal(str(entry["column"]), scale, offset, unit)


def _quantity(entry: Any, where: str, si: str) -> float:
    entry = _keys(entry, where, {"value"}, {"unit"})
    value = _number(entry["value"], where) * _unit(entry.get("unit", si), where, si).factor
    if value <= 0.0:
        raise BagError(f"{where} is {value:g}; allowed: more than 0")
    return value


def _unit(name: Any, where: str, si: str) -> LogUnit:
    allowed = [known for known, unit in LOG_UNITS.items() if unit.si == si]
    if str(name) not in allowed:
        raise BagError(f"{where}: unit '{name}'; allowed: {', '.join(allowed)}")
    return LOG_UNITS[str(name)]


def _number(value: Any, where: str) -> float:
    if isinstance(value, str):  # YAML takes 1e-3 for a text
        with contextlib.suppress(ValueError):
            value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise BagError(f"{where} is {value!r}; allowed: a number")
    return float(value)


def _keys(content: Any, where: str, needed: set[str], allowed: set[str] | None) -> dict[str, Any]:
    """A mapping with the needed keys and no others than allowed; None: any."""
    place = where or "the map"
    if not isinstance(content, dict):
        raise BagError(f"{place} is {content!r}; allowed: a mapping")
    if missing := sorted(needed - content.keys()):
        raise BagError(f"{place} lacks {', '.join(missing)}")
    if allowed is not None and (unknown := sorted(map(str, content.keys() - needed - allowed))):
        raise BagError(f"{place} has {', '.join(unknown)}; allowed: {', '.join(sorted(needed | allowed))}")
    return content
