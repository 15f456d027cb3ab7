"""From the tree of a machine file to the machine dataclasses; keys, numbers, units and sources are checked.

Every number of a file is written ``{value: 3000, unit: psi, source: "Thesis 3.1"}``. What is
allowed, the dataclasses declare.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from typing import NamedTuple, TypeVar

from forest_description.machine_tree import QUANTITY_KEYS, Branch, Leaf
from forest_description.parameter import MachineError, Parameter, parameter_of
from forest_description.units import UNITS, units_for

T = TypeVar("T")


class FieldKind(NamedTuple):
    """What a dataclass field may hold: its type without None, whether None may be, its parameter if any."""

    kind: type
    optional: bool
    allowed: Parameter | None


class Quantity(NamedTuple):
    """One number of a machine file as it stands there, in the file's own unit."""

    key: str
    value: float
    unit: str
    source: str


def build(kind: type[T], tree: Branch, prefix: str = "") -> T:
    """Build a machine dataclass from a tree.

    Args:
        kind: A dataclass of parameters, texts and further dataclasses.
        tree: What the file says about it.
        prefix: Dotted key of the tree, with a dot at its end, or nothing.

    Raises:
        MachineError: Unknown or missing key, wrong unit, out of range, not a number, no source, or
            inconsistent values.
    """
    kinds = _field_kinds(kind)
    unknown = [key for key in tree.children if key not in kinds]
    if unknown:
        place = tree.children[unknown[0]].place
        raise MachineError(f"{place}: unknown key {prefix}{unknown[0]}; allowed: {', '.join(kinds)}")
    values = {name: _value(prefix + name, tree, name, field) for name, field in kinds.items()}
    try:
        return kind(**values)
    except MachineError as error:
        raise MachineError(f"{tree.place}: {prefix}{error}") from error


def _value(key: str, tree: Branch, name: str, field: FieldKind) -> object:
    """Return the value of one field of the dataclass that ``tree`` describes."""
    item, allowed = tree.children.get(name), field.allowed
    if item is None:
        what = f"a number in {allowed.range}" if allowed else "a text" if field.kind is str else "a section"
        raise MachineError(f"{tree.place}: missing key {key}: {what}{' or null' if field.optional else ''}")
    if field.optional and isinstance(item, Leaf) and item.text is None:
        return None
    if allowed is not None:
        return _number(key, item, allowed)
    if field.kind is str:
        if isinstance(item, Leaf) and item.text:
            return item.text
        raise MachineError(f"{item.place}: {key} must be a text")
    if isinstance(item, Leaf):
        raise MachineError(f"{item.place}: {key} must be a section with keys, not {item.text!r}")
    return build(field.kind, item, f"{key}.")


def _number(key: str, item: Branch | Leaf, allowed: Parameter) -> float:
    """Return a quantity in SI; it must have a value in the allowed range, a fitting unit and a source."""
    given = _quantity(key, item, allowed)
    unit = UNITS.get(given.unit)
    if unit is None or unit.si != allowed.unit:
        names = ", ".join(units_for(allowed.unit))
        raise MachineError(f"{item.place}: {key}: unit {given.unit!r} does not fit; allowed: {names}")
    value = given.value * unit.factor
    if not allowed.low <= value <= allowed.high:
        converted = "" if unit.factor == 1.0 else f" ({value:g} {allowed.unit})"
        raise MachineError(
            f"{item.place}: {key} = {given.value:g} {given.unit}{converted} is outside the range "
            f"{allowed.range}"
        )
    return value


def _quantity(key: str, item: Branch | Leaf, allowed: Parameter) -> Quantity:
    """Return a quantity as the file has it, after checking its three keys and that the value is a number."""
    form = f"{{value: a number in {allowed.range}, unit: {allowed.unit}, source: where it comes from}}"
    if isinstance(item, Leaf):
        raise MachineError(f"{item.place}: {key} = {item.text}: a number must be written {form}")
    for part in item.children:
        if part not in QUANTITY_KEYS:
            raise MachineError(
                f"{item.children[part].place}: unknown key {key}.{part}; allowed: value, unit, source"
            )
    texts = []
    for part in QUANTITY_KEYS:
        leaf = item.children.get(part)
        if not isinstance(leaf, Leaf) or not leaf.text:
            raise MachineError(f"{leaf.place if leaf else item.place}: missing {key}.{part}: write {form}")
        texts.append(leaf.text)
    try:
        value = float(texts[0])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise MachineError(f"{item.place}: {key}: {texts[0]!r} is not a number; allowed: {allowed.range}")
    return Quantity(key, value, texts[1], texts[2])


def quantities(kind: type, tree: Branch, prefix: str = "") -> list[Quantity]:
    """Return all numbers of a tree as the file has them, in the order of the dataclass' fields."""
    found: list[Quantity] = []
    for name, field in _field_kinds(kind).items():
        item = tree.children[name]
        if isinstance(item, Branch) and field.allowed is not None:
            found.append(_quantity(prefix + name, item, field.allowed))
        elif isinstance(item, Branch):
            found.extend(quantities(field.kind, item, f"{prefix}{name}."))
    return found


def parameters(kind: type, prefix: str = "") -> dict[str, Parameter]:
    """Return the declared parameters of a machine dataclass by dotted key."""
    found: dict[str, Parameter] = {}
    for name, field in _field_kinds(kind).items():
        if field.allowed is not None:
            found[prefix + name] = field.allowed
        elif dataclasses.is_dataclass(field.kind):
            found.update(parameters(field.kind, f"{prefix}{name}."))
    return found


def _field_kinds(kind: type) -> dict[str, FieldKind]:
    """Return what each field of a dataclass may hold, by name."""
    hints = typing.get_type_hints(kind)
    kinds: dict[str, FieldKind] = {}
    for field in dataclasses.fields(kind):
        members = [hints[field.name]]
        if typing.get_origin(members[0]) in (types.UnionType, typing.Union):
            members = list(typing.get_args(members[0]))
        optional = type(None) in members
        inner = next(member for member in members if member is not type(None))
        kinds[field.name] = FieldKind(inner, optional, parameter_of(field))
    return kinds
