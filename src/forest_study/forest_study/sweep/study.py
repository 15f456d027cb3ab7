"""The file of a study: what its runs have in common, what varies, and over how many seeds.

    kind: track
    with: {noise: true, speed: 0.5}
    vary:
      path: [sweep, radial]
      plant.manipulator.head_mass: {low: 150, high: 600, unit: kg}
      control.tip_acceleration: {low: 2, high: 6}
    design: sobol
    points: 64
    seeds: 2

Lists make a grid. Ranges are sampled, by a Latin hypercube or by Sobol's sequence. A machine's number has the
unit that its file may have. Everything is checked before the first run.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from forest_control.taught.tip_path import PathError
from forest_description.config import schema
from forest_description.config.parameter import MachineError
from forest_description.config.units import UNITS, units_for
from forest_description.machine import Machine
from forest_msgs_py.interfaces.yaml_text import LARGEST, parsed
from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError, converted, table_rows
from forest_study.closed_loop import model_mismatch
from forest_study.results import StudyError
from forest_study.sweep.trials import KINDS, Kind

MOST = 10_000_000  # [1] runs of a study
DESIGNS = ("grid", "latin_hypercube", "sobol")
OPTIONS = (
    Parameter("of trial", choices=tuple(KINDS), name="kind", default="track"),
    Parameter("how ranges are sampled", choices=DESIGNS, name="design", default="grid"),
    Parameter("of the sampled design", low=1, high=2**20, name="points", default=64),
    Parameter("of every point", low=1, high=MOST, name="seeds", default=1),
    Parameter("the first", low=0, high=2**31 - 1, name="seed", default=0),
)


class Span(NamedTuple):
    """A range of a number."""

    low: float
    high: float


class Study(NamedTuple):
    """What is to be run."""

    text: str  # the file's
    kind: str
    common: Mapping[str, Any]  # values by key; machines' numbers in SI
    lists: Mapping[str, tuple[Any, ...]]
    ranges: Mapping[str, Span]
    design: str
    points: int
    seeds: range


def read_study(file: Path) -> Study:
    """Return the study of a file.

    Raises:
        StudyError: it cannot be read, or something in it is not allowed; the sentence says what is.
    """
    text = _text(file)
    try:
        return study_of(text)
    except yaml.YAMLError as error:
        raise StudyError(f"{file}: not YAML: {' '.join(str(error).split())}") from error
    except (StudyError, MachineError, ParameterError, PathError, argparse.ArgumentTypeError) as error:
        raise StudyError(f"{file}: {error}") from error


def study_of(text: str) -> Study:
    """Return the study of a text.

    Raises:
        StudyError, MachineError, ParameterError, PathError: something in it is not allowed.
        YAMLError: it is not YAML.
    """
    return _study(text, parsed(text))


def _text(file: Path) -> str:
    try:
        if file.stat().st_size > LARGEST:
            raise StudyError(f"{file}: {file.stat().st_size} bytes; allowed: up to {LARGEST}")
        return file.read_text("utf-8")
    except UnicodeDecodeError as error:
        raise StudyError(f"{file}: not UTF-8 text") from error


def _study(text: str, tree: Any) -> Study:
    given = _mapping("the study", tree)
    known = [row.name for row in OPTIONS]
    _refuse_others("the study", given, [*known, "with", "vary"])
    options = {row.name: row.checked(given.get(row.name, row.default)) for row in OPTIONS}
    kind = KINDS[options["kind"]]
    common = {key: _one(kind, key, value) for key, value in _mapping("with", given.get("with")).items()}
    lists, ranges = {}, {}
    for key, value in _mapping("vary", given.get("vary")).items():
        if key in common:
            raise StudyError(f"vary.{key} stands under with, too; allowed: one of them")
        if isinstance(value, dict) and "low" in value:
            ranges[key] = _span(kind, key, value)
        else:
            lists[key] = _list(kind, key, value)
    study = Study(
        text=text,
        kind=options["kind"],
        common=common,
        lists=lists,
        ranges=ranges,
        design=options["design"],
        points=options["points"],
        seeds=range(options["seed"], options["seed"] + options["seeds"]),
    )
    _require_possible(study, kind)
    return study


def _require_possible(study: Study, kind: Kind) -> None:
    """Raise unless each value alone can be, and the design fits what varies."""
    if (study.design == "grid") != (not study.ranges):
        raise StudyError(
            f"design is {study.design}, ranges: {', '.join(study.ranges) or 'none'}; allowed: grid for lists "
            f"alone, else {' or '.join(DESIGNS[1:])}"
        )
    if study.design == "sobol" and study.points & (study.points - 1):
        raise StudyError(f"points is {study.points}; allowed with sobol: a power of two")
    first = {key: values[0] for key, values in study.lists.items()}
    first |= {key: span.low for key, span in study.ranges.items()}
    varied = [(key, value) for key, values in study.lists.items() for value in values]
    varied += [(key, value) for key, span in study.ranges.items() for value in span]
    for key, value in varied or [("", None)]:
        kind.require_possible({**study.common, **first, **({key: value} if key else {})})


def _list(kind: Kind, key: str, value: Any) -> tuple[Any, ...]:
    """Return the values of a list, or of `{values: [...], unit: ...}`."""
    unit, values = {}, value
    if isinstance(value, dict):
        _refuse_others(f"vary.{key}", value, ["values", "low", "high", "unit"])
        unit, values = {"unit": value.get("unit")}, value.get("values")
    if not isinstance(values, list) or not values:
        raise StudyError(f"vary.{key} is {values!r}; allowed: a list of values, or low, high and unit")
    found = tuple(_one(kind, key, {"value": x, **unit} if unit else x) for x in values)
    if len(set(found)) < len(found):
        raise StudyError(f"vary.{key} has a value twice; allowed: each once")
    return found


def _span(kind: Kind, key: str, value: dict[str, Any]) -> Span:
    _refuse_others(f"vary.{key}", value, ["low", "high", "unit"])
    unit = {"unit": value["unit"]} if "unit" in value else {}
    low, high = (
        _one(kind, key, {"value": value.get(end), **unit} if unit else value.get(end)) for end in Span._fields
    )
    if not (isinstance(low, float) and isinstance(high, float) and low < high):
        raise StudyError(f"vary.{key} is {low!r} .. {high!r}; allowed: numbers, low less than high")
    return Span(low, high)


def _one(kind: Kind, key: str, value: Any) -> Any:
    """Return a key's value: a machine's number in SI, others as people type them."""
    prefix, _, name = key.partition(".")
    if not name:
        rows = {row.name: row for row in table_rows(kind.keys)}
        if key not in rows:
            raise StudyError(f"{key}: not a key of this kind; allowed: {_allowed(kind, rows)}")
        checked = rows[key].checked(value)
        if key == "mismatch" and checked:
            model_mismatch.ranges_from(checked)
        return checked
    if prefix not in kind.prefixes:
        raise StudyError(f"{key}: not a key of this kind; allowed: {_allowed(kind, ())}")
    return _si(key, name, value) if prefix in ("machine", "plant") else _plain(key, value)


def _allowed(kind: Kind, rows: Any) -> str:
    return ", ".join([*rows, *(f"{prefix}.KEY" for prefix in kind.prefixes)])


def _si(key: str, name: str, value: Any) -> float:
    allowed = schema.parameters(Machine).get(name)
    if allowed is None:
        raise StudyError(f"{key}: a machine's file has no number of this name")
    units = units_for(allowed.unit)
    if not isinstance(value, dict) or value.get("unit") not in units:
        raise StudyError(f"{key} needs its unit; allowed: {{value: NUMBER, unit: {' or '.join(units)}}}")
    try:
        number = float(str(value.get("value")))  # YAML takes 1e7, without a dot, for a text
    except ValueError:
        raise StudyError(f"{key}: {value.get('value')!r} is no number [{value['unit']}]") from None
    si = number * UNITS[value["unit"]].factor
    if not allowed.low <= si <= allowed.high:
        raise StudyError(f"{key}: {number:g} {value['unit']}; allowed: {allowed.range}")
    return si


def _plain(key: str, value: Any) -> Any:
    """Return a setting's value, which its own table checks later: a number, a word, or some of them."""
    if isinstance(value, list):
        return tuple(_plain(key, one) for one in value)
    if isinstance(value, int) and not isinstance(value, bool):
        value = converted(0.0, value)
    if not isinstance(value, bool | float | str):
        raise StudyError(f"{key} is {value!r}; allowed: a number, a word, or a list of them")
    return value


def _mapping(where: str, value: Any) -> dict[str, Any]:
    if value is None:
        return {}
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise StudyError(f"{where} is no mapping of names; allowed: see forest-study sweep --help")
    return value


def _refuse_others(where: str, given: Mapping[str, Any], allowed: list[str]) -> None:
    others = [key for key in given if key not in allowed]
    if others:
        raise StudyError(f"{where} has {', '.join(map(repr, others))}; allowed: {', '.join(allowed)}")
