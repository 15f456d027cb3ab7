"""From the tree of a machine file to the machine dataclasses; keys, numbers, units and sources are checked.

Kept instead of a schema library, because every complaint names file, line, unit and source of a number.

Every number of a file is written ``{value: 3000, unit: psi, source: "Thesis 3.1"}``, a row of them
``{values: [1, 2], unit: V, source: "..."}``. A component of which there are several sorts says
which under ``kind``. What is allowed, the dataclasses declare.
"""

import dataclasses
import math
import re
import types
import typing
from typing import NamedTuple, TypeVar

from forest_description.config.parameter import (
    Choice,
    MachineError,
    Parameter,
    choice_of,
    in_unit,
    may_be_left_out,
    parameter_of,
)
from forest_description.config.source_tree import QUANTITY_KEYS, ROW_KEYS, UNCERTAINTY, Branch, Leaf, Row
from forest_description.config.units import UNITS, Unit, units_for

T = TypeVar("T")
Item = Branch | Leaf | Row


class FieldKind(NamedTuple):
    """What a dataclass field may hold: its types without None, whether None may be, its parameter if any."""

    kinds: tuple[type, ...]  # several: sorts of a component, told apart by ``kind``
    optional: bool
    allowed: Parameter | None
    choice: Choice | None
    row: bool
    may_be_left_out: bool


class Quantity(NamedTuple):
    """One number, or one row of numbers, of a machine file as it stands there, in the file's own unit."""

    key: str
    value: float | tuple[float, ...]
    unit: str
    source: str
    uncertainty: float | None = None  # half the width of the 95 % interval, in the file's own unit


def build(kind: type[T], tree: Branch, prefix: str = "") -> T:
    """Build a machine dataclass from a tree.

    Args:
        kind: A dataclass of parameters, choices, texts and further dataclasses.
        tree: What the file says about it.
        prefix: Dotted key of the tree, with a dot at its end, or nothing.

    Raises:
        MachineError: Unknown or missing key, wrong unit, out of range, not a number, no source, or
            inconsistent values.
    """
    fields = field_kinds(kind)
    known = (*fields, "kind") if hasattr(kind, "kind") else tuple(fields)
    unknown = [key for key in tree.children if key not in known]
    if unknown:
        place = tree.children[unknown[0]].place
        raise MachineError(f"{place}: unknown key {prefix}{unknown[0]}; allowed: {', '.join(known)}")
    values = {name: _value(prefix + name, tree, name, field) for name, field in fields.items()}
    try:
        return kind(**values)
    except MachineError as error:
        raise MachineError(f"{_place_of(str(error), tree)}: {prefix}{error}") from error


def _value(key: str, tree: Branch, name: str, field: FieldKind) -> object:
    """Return the value of one field of the dataclass that ``tree`` describes."""
    item = tree.children.get(name)
    if item is None and field.may_be_left_out:
        return None
    if item is None:
        null = " or null" if field.optional else ""
        raise MachineError(f"{tree.place}: missing key {key}: {_what(field)}{null}")
    if field.optional and isinstance(item, Leaf) and item.text is None:
        return None
    if field.allowed is not None:
        numbers = _numbers(key, item, field.allowed, field.row)
        return numbers if field.row else numbers[0]
    if field.kinds == (str,):
        return _text(key, item, field.choice)
    if not isinstance(item, Branch):
        given = item.text if isinstance(item, Leaf) else list(item.texts)
        allowed = _keys(field) + (" or null" if field.optional else "")
        raise MachineError(
            f"{item.place}: {key} must be a section with keys, not {given!r}; allowed: {allowed}"
        )
    return build(sort_of(key, item, field.kinds), item, f"{key}.")


def _place_of(complaint: str, tree: Branch) -> str:
    """Return the place of the first key that a complaint names and that its section says itself.

    Values that contradict each other may come from two places, one of them inherited: from the
    machine that the file is based on, or from what all axes share. Who came later made the
    contradiction.
    """
    file, _, start = tree.place.rpartition(":")
    for word in re.findall(r"[a-z_0-9.]+", complaint):
        item: Item | None = tree
        for key in word.rstrip(".").split("."):
            item = item.children.get(key) if isinstance(item, Branch) else None
        if item is not None:
            place, _, line = item.place.rpartition(":")
            if place == file and int(line) >= int(start):
                return item.place
    return tree.place


def _keys(field: FieldKind) -> str:
    """Return in words which keys a section has, or which sorts of it there are."""
    if len(field.kinds) > 1:
        return (
            f"kind ({', '.join(str(getattr(kind, 'kind', 'none')) for kind in field.kinds)}) "
            "and the kind's own"
        )
    return ", ".join(field_kinds(field.kinds[0]))


def _what(field: FieldKind) -> str:
    """Return in words what a field wants."""
    if field.allowed is not None:
        return f"{'numbers' if field.row else 'a number'} in {field.allowed.range}"
    if field.choice is not None:
        return f"one of {', '.join(field.choice.words)}"
    return "a text" if field.kinds == (str,) else "a section"


def _text(key: str, item: Item, choice: Choice | None) -> str:
    """Return a text, one of the words if it is a choice."""
    if not isinstance(item, Leaf) or not item.text:
        raise MachineError(f"{item.place}: {key} must be a text")
    if choice is not None and item.text not in choice.words:
        raise MachineError(
            f"{item.place}: {key} = {item.text!r} is unknown; allowed: {', '.join(choice.words)}"
        )
    return item.text


def sort_of(key: str, item: Branch, kinds: tuple[type, ...]) -> type:
    """Return the dataclass that a section is of; of several, the one whose ``kind`` it names.

    Raises:
        MachineError: ``kind`` is missing, or none of the known ones, or there are none to choose
            from.
    """
    sorts = {getattr(kind, "kind", ""): kind for kind in kinds}
    named = item.children.get("kind")
    if len(kinds) == 1 and "" in sorts:
        if named is not None:
            raise MachineError(f"{named.place}: unknown key {key}.kind: {key} has only one")
        return kinds[0]
    if named is None and "" in sorts:
        return sorts[""]
    text = named.text if isinstance(named, Leaf) else None
    if text not in sorts:
        place, given = (named.place, f"{key}.kind = {text!r} is unknown") if named else (item.place, "")
        words = ", ".join(sort or "no kind" for sort in sorts)
        raise MachineError(f"{place}: {given or f'missing key {key}.kind'}; allowed: {words}")
    return sorts[text]


def _numbers(key: str, item: Item, allowed: Parameter, row: bool) -> tuple[float, ...]:
    """Return a quantity in SI; it must have values in the allowed range, a fitting unit and a source."""
    given = _quantity(key, item, allowed, row)
    unit = UNITS.get(given.unit)
    if unit is None or unit.si != allowed.unit:
        names = ", ".join(units_for(allowed.unit))
        raise MachineError(f"{item.place}: {key}: unit {given.unit!r} does not fit; allowed: {names}")
    values = given.value if isinstance(given.value, tuple) else (given.value,)
    return tuple(_in_range(f"{item.place}: {key}", value, given.unit, unit, allowed) for value in values)


def _in_range(where: str, given: float, unit_name: str, unit: Unit, allowed: Parameter) -> float:
    """Return a number in SI."""
    value = given * unit.factor
    if not allowed.low <= value <= allowed.high:
        converted = "" if unit.factor == 1.0 else f" ({in_unit(value, allowed.unit)})"
        raise MachineError(
            f"{where} = {in_unit(given, unit_name)}{converted} is outside the range {allowed.range}"
        )
    return value


def _quantity(key: str, item: Item, allowed: Parameter, row: bool) -> Quantity:
    """Return a quantity as the file has it, after checking its three keys and that it holds numbers."""
    keys = ROW_KEYS if row else QUANTITY_KEYS
    inside = f"[numbers in {allowed.range}]" if row else f"a number in {allowed.range}"
    form = f"{{{keys[0]}: {inside}, unit: {allowed.unit}, source: where it comes from}}"
    if not isinstance(item, Branch):
        given = item.text if isinstance(item, Leaf) else ", ".join(item.texts)
        raise MachineError(f"{item.place}: {key} = {given}: a number must be written {form}")
    every = keys if row else (*keys, UNCERTAINTY)
    for part in item.children:
        if part not in every:
            raise MachineError(
                f"{item.children[part].place}: unknown key {key}.{part}; allowed: {', '.join(every)}"
            )
    parts = [item.children.get(part) for part in keys]
    for part, found in zip(keys, parts, strict=True):
        wanted = Row if part == "values" else Leaf
        if not isinstance(found, wanted) or not (found.texts if isinstance(found, Row) else found.text):
            raise MachineError(f"{found.place if found else item.place}: missing {key}.{part}: write {form}")
    texts = parts[0].texts if isinstance(parts[0], Row) else (str(parts[0].text),)  # type: ignore[union-attr]
    values = tuple(_number(f"{item.place}: {key}", text, allowed) for text in texts)
    unit, source = (str(leaf.text) for leaf in parts[1:] if isinstance(leaf, Leaf))
    uncertainty = _uncertainty(f"{item.place}: {key}.{UNCERTAINTY}", item.children.get(UNCERTAINTY), allowed)
    return Quantity(key, values if row else values[0], unit, source, uncertainty)


def _uncertainty(where: str, item: Item | None, allowed: Parameter) -> float | None:
    """Return the half-width of a number's 95 % interval as the file has it; None if it tells none."""
    if item is None:
        return None
    value = _number(where, item.text or "", allowed) if isinstance(item, Leaf) else 0.0
    if value <= 0.0:
        raise MachineError(f"{where}: allowed: half the width of the 95 % interval, above 0")
    return value


def _number(where: str, text: str, allowed: Parameter) -> float:
    """Return the finite number that a text is."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise MachineError(f"{where}: {text!r} is not a number; allowed: {allowed.range}")
    return value


def quantities(kind: type, tree: Branch, prefix: str = "") -> list[Quantity]:
    """Return all numbers of a tree as the file has them, in the order of the dataclass' fields."""
    found: list[Quantity] = []
    for name, field in field_kinds(kind).items():
        item, key = tree.children.get(name), prefix + name
        if isinstance(item, Branch) and field.allowed is not None:
            found.append(_quantity(key, item, field.allowed, field.row))
        elif isinstance(item, Branch):
            found.extend(quantities(sort_of(key, item, field.kinds), item, f"{key}."))
    return found


def parameters(kind: type, prefix: str = "") -> dict[str, Parameter]:
    """Return the parameters that a machine dataclass declares, of every sort of component, by dotted key."""
    found: dict[str, Parameter] = {}
    for name, field in field_kinds(kind).items():
        if field.allowed is not None:
            found[prefix + name] = field.allowed
        for sort in field.kinds:
            if dataclasses.is_dataclass(sort):
                found.update(parameters(sort, f"{prefix}{name}."))
    return found


def field_kinds(kind: type) -> dict[str, FieldKind]:
    """Return what each field of a dataclass may hold, by name."""
    hints = typing.get_type_hints(kind)
    kinds: dict[str, FieldKind] = {}
    for field in dataclasses.fields(kind):
        members = [hints[field.name]]
        if typing.get_origin(members[0]) in (types.UnionType, typing.Union):
            members = list(typing.get_args(members[0]))
        inner = tuple(member for member in members if member is not type(None))
        row = any(typing.get_origin(member) is tuple for member in inner)
        kinds[field.name] = FieldKind(
            kinds=inner,
            optional=len(inner) < len(members),
            allowed=parameter_of(field),
            choice=choice_of(field),
            row=row,
            may_be_left_out=may_be_left_out(field),
        )
    return kinds
