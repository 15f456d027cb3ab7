"""Tables of node parameters: name, type, default, unit, range and text, each told once.

A table is a NamedTuple whose fields are the parameters. The annotation carries what a default cannot say:

    class Playing(NamedTuple):
        rate: Annotated[float, tunable("seconds of the bag per second", high=10.0)] = 1.0

`node_parameters.declare` declares a whole table on a node and returns its values as an instance of it. The
reference page of all nodes is made from the same tables. This module does not import ROS.

============  =================================================================================
default       parameter
============  =================================================================================
bool, int     of that type
float         finite; whole numbers are accepted, as people type them
str           of that type
tuple         as many numbers as the default has; of a `tuple[T, ...]` any number of items like its first
IntEnum       the member's name in lower case, one of all names
none          computed by the node before it declares the table
============  =================================================================================
"""

import math
from collections.abc import Mapping, Sequence
from enum import EnumMeta, IntEnum
from functools import partial
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_type_hints

LARGEST_WHOLE = 2**1023  # a greater one may be no float; the largest finite one is twice this
Table = TypeVar("Table", bound=tuple[Any, ...])


class ParameterError(ValueError):
    """A parameter's value is not allowed; the text names parameter, value and what is allowed."""


class Parameter(NamedTuple):
    """One row of a table; `table_rows` fills in name and default."""

    text: str
    unit: str = ""
    low: float | None = None  # inclusive, in the unit
    high: float | None = None
    choices: Sequence[str] | None = None
    read_only: bool = True  # once the node runs
    name: str = ""
    default: Any = None

    @property
    def description(self) -> str:
        """The text with its unit."""
        return f"{self.text} [{self.unit}]" if self.unit else self.text

    @property
    def allowed(self) -> str:
        """What the parameter may be, in words."""
        if self.choices is not None:
            return "one of " + ", ".join(self.choices)
        if self.low is not None or self.high is not None:
            low = "-inf" if self.low is None else f"{self.low:g}"
            high = "inf" if self.high is None else f"{self.high:g}"
            return f"{low} .. {high} {self.unit}".rstrip()
        kinds = {bool: "true or false", int: "a whole number", float: "a finite number", str: "a text"}
        if isinstance(self.default, (tuple, list)) and isinstance(self.default[0], str):
            return "a list of texts"
        return kinds.get(type(self.default), "a list of finite numbers")

    def checked(self, given: Any) -> Any:
        """Return a value in the default's type.

        Raises:
            ParameterError: wrong type, not finite, out of range, not among the choices, or too few or many.
        """
        value = converted(self.default, given)
        if value is None or not self._is_inside(value):
            raise ParameterError(f"parameter '{self.name}' is {given!r}; allowed: {self.allowed}")
        if not isinstance(self.default, tuple):
            return value
        if len(value) != len(self.default):
            count = len(self.default)
            raise ParameterError(f"parameter '{self.name}' is {value!r}; allowed: {count} numbers")
        return tuple(value)

    def _is_inside(self, value: Any) -> bool:
        if isinstance(value, list):
            return all(map(self._is_inside, value))
        if isinstance(value, float) and not math.isfinite(value):
            return False
        if self.choices is not None and value not in self.choices:
            return False
        return (self.low is None or value >= self.low) and (self.high is None or value <= self.high)


tunable = partial(Parameter, read_only=False)  # may be set while the node runs


class MachineParameter(NamedTuple):
    """The parameter of every node that knows the machine."""

    machine: Annotated[str, Parameter("shipped machine, or path of a machine file")] = "c180"


def table_rows(table: type[Table], defaults: Mapping[str, Any] | None = None) -> tuple[Parameter, ...]:
    """Return a table's rows in its order.

    Args:
        table: NamedTuple whose fields are `Annotated` with a `Parameter`.
        defaults: in place of the table's own, as people type them.
    """
    own: dict[str, Any] = getattr(table, "_field_defaults")  # noqa: B009  mypy knows it of no type variable
    known = {name: as_typed(value) for name, value in own.items()} | dict(defaults or {})
    rows = []
    for name, hint in get_type_hints(table, include_extras=True).items():
        row: Parameter = hint.__metadata__[0]
        kind = hint.__origin__
        default: Any = known.get(name)
        if isinstance(kind, EnumMeta):
            row = row._replace(choices=[label.lower() for label in kind.__members__])
        elif Ellipsis in get_args(kind):
            default = list(default)
        rows.append(row._replace(name=name, default=default))
    return tuple(rows)


def typed_values(values: Any) -> dict[str, Any]:
    """Return the values of a table's instance as people type them, by name."""
    return {name: as_typed(value) for name, value in values._asdict().items()}


def table_of(table: type[Table], typed: Mapping[str, Any]) -> Table:
    """Return a table's instance for values as people type them; names of other tables are left out."""
    made = {}
    for name, kind in get_type_hints(table).items():
        value: Any = tuple(typed[name]) if isinstance(typed[name], list) else typed[name]
        made[name] = kind[value.upper()] if isinstance(kind, EnumMeta) else value
    return table(**made)


def as_typed(value: Any) -> Any:
    """Return a value as people type it: the label of an enumeration's member."""
    return value.name.lower() if isinstance(value, IntEnum) else value


def converted(default: Any, given: Any) -> Any:
    """Return a value in the default's type, a list for a tuple, or None where it does not fit."""
    if isinstance(default, float) and isinstance(given, int) and not isinstance(given, bool):
        return float(given) if abs(given) < LARGEST_WHOLE else None
    if isinstance(default, (list, tuple)):
        items = list(given) if isinstance(given, (list, tuple)) or hasattr(given, "typecode") else [None]
        found = [converted(default[0], item) for item in items] if default else items
        return None if any(item is None for item in found) else found
    return given if type(given) is type(default) else None
