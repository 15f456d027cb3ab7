"""A machine, or settings, with numbers of their own: dotted keys, as the machine's file has them."""

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

from forest_description.config.parameter import MachineError
from forest_description.machine import Machine
from forest_description.types import AXES
from forest_msgs_py.runtime.parameter_table import ParameterError, table_of, table_rows, typed_values

Table = TypeVar("Table", bound=tuple[Any, ...])
Path = tuple[str, ...]


def changed_machine(machine: Machine, numbers: Mapping[str, float]) -> Machine:
    """Return a machine with other numbers [SI], all at once.

    Args:
        machine: from which the others stay.
        numbers: by dotted key, as "manipulator.head_mass".

    Raises:
        MachineError: the machine has no such number, or cannot be with it.
    """
    changed: Machine = _replaced(machine, {tuple(key.split(".")): x for key, x in numbers.items()}, "")
    return changed


def _replaced(part: Any, numbers: Mapping[Path, float], where: str) -> Any:
    if part is None:
        raise MachineError(f"{where.rstrip('.')} is not there; allowed: numbers of what the machine has")
    below: dict[str, dict[Path, float]] = {}
    for (name, *rest), value in numbers.items():
        below.setdefault(name, {})[tuple(rest)] = value
    return dataclasses.replace(part, **{name: _value(part, name, of, where) for name, of in below.items()})


def _value(part: Any, name: str, numbers: Mapping[Path, float], where: str) -> Any:
    if not hasattr(part, name):
        raise MachineError(f"{where}{name}: {type(part).__name__} has no such number")
    return numbers[()] if () in numbers else _replaced(getattr(part, name), numbers, f"{where}{name}.")


def changed_settings(settings: Table, values: Mapping[str, Any]) -> Table:
    """Return settings with other values, as people type them.

    Args:
        settings: a table of parameters.
        values: by name; "feedback_gain.boom" is one of three.

    Raises:
        ParameterError: there is no such setting, or its value is not allowed.
    """
    rows = {row.name: row for row in table_rows(type(settings))}
    typed = typed_values(settings)
    for key, value in values.items():
        name, _, axis = key.partition(".")
        if name not in rows or (axis and not (axis in AXES and isinstance(typed[name], tuple))):
            raise ParameterError(f"parameter '{key}' is unknown; allowed: {', '.join(rows)}, or NAME.boom")
        if axis:
            three = list(typed[name])
            three[AXES.index(axis)] = value
            value = three
        typed[name] = rows[name].checked(value)
    return table_of(type(settings), typed)
