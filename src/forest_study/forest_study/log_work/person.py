"""An operator's numbers, each with its source, from a file; practice changes them.

A number with `learnt` goes from its value to that as practice grows: by exp(-practice / learning_time). Equal
seeds give equal persons, who differ from the file's by chance.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import yaml

from forest_msgs_py.interfaces.yaml_text import read_yaml
from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError, table_rows
from forest_study.results import StudyError

FOLDER = Path(__file__).parent / "operators"
SHIPPED = tuple(sorted(file.stem for file in FOLDER.glob("*.yaml")))
KEYS = ("value", "learnt", "unit", "source")


class Person(NamedTuple):
    """What an operator is like."""

    practice: Annotated[float, Parameter("at the levers so far", "h", 0.0, 1e5)] = 0.0
    learning_time: Annotated[float, Parameter("in which 63 % is learnt", "h", 0.01, 1e4)] = 3.0
    reaction: Annotated[float, Parameter("from seeing to beginning to act", "s", 0.0, 2.0)] = 0.25
    delay: Annotated[float, Parameter("from eye to hand while steering", "s", 0.0, 2.0)] = 0.2
    hand: Annotated[float, Parameter("lag of arm and lever", "s", 0.02, 1.0)] = 0.1
    foresight: Annotated[
        float, Parameter("share of what is under way that is reckoned with", "1", 0.0, 1.0)
    ] = 0.0
    precision: Annotated[
        float, Parameter("standard deviation of a deflection over itself", "1", 0.0, 1.0)
    ] = 0.1
    axes: Annotated[float, Parameter("levers that are moved at once", "1", 1.0, 3.0)] = 1.2
    dwell: Annotated[float, Parameter("for which attention stays with them", "s", 0.05, 5.0)] = 0.5
    joint_error: Annotated[float, Parameter("of which joint moves the tip where", "1", 0.0, 1.0)] = 0.3
    tip_error: Annotated[float, Parameter("of the tip's directions", "1", 0.0, 1.0)] = 0.1
    boldness: Annotated[float, Parameter("of a lever's way that is used", "1", 0.05, 1.0)] = 0.6
    persons: Annotated[float, Parameter("how much persons differ", "1", 0.0, 1.0)] = 0.15


ROWS = {row.name: row for row in table_rows(Person)}
LIKE_ALL = ("practice", "learning_time", "persons")  # what chance leaves as it is


def read_person(name: str, changes: Mapping[str, float] | None = None) -> Person:
    """Return the operator of a shipped file or a path, at its practice.

    Args:
        name: "novice", "expert", or a file.
        changes: numbers in place of the file's, learnt ones too; practice and learning time count first.

    Raises:
        StudyError: the file cannot be read, or something in it is not allowed; the sentence says what is.
    """
    numbers, changes = _numbers(name), dict(changes or {})
    for key in changes:
        if key not in ROWS:
            raise StudyError(f"operator.{key}: an operator has no such number; allowed: {', '.join(ROWS)}")
    begun = {key: row.default for key, row in ROWS.items()} | {k: n["value"] for k, n in numbers.items()}
    time = {key: changes.get(key, begun[key]) for key in ("practice", "learning_time")}
    left = math.exp(-time["practice"] / time["learning_time"])
    learnt = {k: n["learnt"] + (n["value"] - n["learnt"]) * left for k, n in numbers.items() if "learnt" in n}
    try:
        return Person(**{k: ROWS[k].checked(x) for k, x in (begun | learnt | changes).items()})
    except ParameterError as error:
        raise StudyError(f"{name}: {error}") from error


def sources(name: str) -> dict[str, str]:
    """Return the source of each number that an operator's file, or one that it is based on, has.

    Raises:
        StudyError: as `read_person`.
    """
    return {key: str(entry["source"]) for key, entry in _numbers(name).items()}


def _numbers(name: str) -> dict[str, dict[str, Any]]:
    """Return a file's entries over those of the file that it is based on."""
    file = FOLDER / f"{name}.yaml" if name in SHIPPED else Path(name)
    try:
        tree = read_yaml(file)
    except OSError as error:
        raise StudyError(
            f"{name}: no operator ({error.strerror}); allowed: {', '.join(SHIPPED)}, or a file"
        ) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise StudyError(f"{file}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(tree, dict):
        raise StudyError(f"{file}: no mapping of names; allowed: {', '.join(ROWS)}")
    base = tree.pop("based_on", None)
    if base is not None and base not in SHIPPED:
        raise StudyError(f"{file}: based_on is {base!r}; allowed: {', '.join(SHIPPED)}")
    own = {str(key): _entry(file, key, entry) for key, entry in tree.items()}
    return own if base is None else _numbers(base) | own


def _entry(file: Path, key: Any, entry: Any) -> dict[str, Any]:
    if key not in ROWS:
        raise StudyError(f"{file}: {key}: not known; allowed: based_on, {', '.join(ROWS)}")
    wrong = not isinstance(entry, dict) or not {"value", "unit", "source"} <= set(entry) <= set(KEYS)
    if wrong or entry["unit"] != ROWS[key].unit or not str(entry["source"]).strip():
        raise StudyError(
            f"{file}: {key} is {entry!r}; allowed: {{value: NUMBER, unit: {ROWS[key].unit}, source: TEXT}}, "
            "and learnt: NUMBER"
        )
    try:
        return {name: ROWS[key].checked(x) if name in ("value", "learnt") else x for name, x in entry.items()}
    except ParameterError as error:
        raise StudyError(f"{file}: {error}") from error


def drawn(person: Person, seed: int) -> Person:
    """Return a seed's person: each number times exp(persons g), g from the standard normal distribution."""
    rng = np.random.default_rng([seed, 7])
    factors = np.exp(person.persons * rng.standard_normal(len(Person._fields))).tolist()
    varied = {
        key: min(ROWS[key].high or math.inf, max(ROWS[key].low or 0.0, x * factor))
        for (key, x), factor in zip(person._asdict().items(), factors, strict=True)
        if key not in LIKE_ALL
    }
    return person._replace(**varied)
