"""Reading machine files: YAML to a tree that remembers files and lines, laid over the machine it is based on.

A file may say ``based_on: c180_thesis`` and then give only what differs. ``null`` removes an
optional component. The YAML is read as nodes, not as plain values, because every complaint names
the line that it is about. The file of an `unknown` machine is drawn.
"""

import functools
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import yaml

from forest_description.config import random_machine
from forest_description.config.parameter import MachineError

QUANTITY_KEYS = ("value", "unit", "source")
ROW_KEYS = ("values", "unit", "source")
UNCERTAINTY = "uncertainty"  # a number may have one
DEEPEST = 50  # levels
LARGEST = 1_000_000  # [byte] of a machine file: the shipped ones have 24 000


class _TooDeep(yaml.YAMLError):
    """A text is nested too deeply."""

    def __str__(self) -> str:
        return f"nested more than {DEEPEST} levels deep"


class Leaf(NamedTuple):
    """A scalar of the file; ``text`` is None where the file says null."""

    place: str
    text: str | None


class Row(NamedTuple):
    """A list of scalars of the file."""

    place: str
    texts: tuple[str, ...]


class Branch(NamedTuple):
    """A mapping of the file. ``place`` is "file:line"."""

    place: str
    children: "dict[str, Branch | Leaf | Row]"


def shipped_machines() -> list[str]:
    """Return the names of the machines that come with this package."""
    folder = resources.files("forest_description") / "machines"
    return sorted(item.name[: -len(".yaml")] for item in folder.iterdir() if item.name.endswith(".yaml"))


def is_shipped(name: str) -> bool:
    """Tell whether a name is not that of a file: a shipped machine's, or one's that is drawn."""
    return random_machine.is_unknown(name) or (Path(name).suffix == "" and Path(name).name == name)


def read(name_or_path: str | Path) -> Branch:
    """Return the tree of a machine file, laid over the machine that it is based on.

    Args:
        name_or_path: A shipped name (no suffix, no folder), one that is drawn (`unknown`), or a
            file.

    Raises:
        MachineError: No such machine, unreadable file, not YAML, or a circle of ``based_on``.
    """
    trees = [tree for _, _, tree in _layers(str(name_or_path), Path(), ())]
    return functools.reduce(overlay, reversed(trees))


def texts(name_or_path: str | Path) -> list[tuple[str, str]]:
    """Return label and text of a machine's file, then of those that it is based on.

    Raises:
        MachineError: As ``read``.
    """
    return [(label, text) for label, text, _ in _layers(str(name_or_path), Path(), ())]


def _layers(
    name: str, folder: Path, derived: tuple[str, ...], place: str = ""
) -> list[tuple[str, str, Branch]]:
    """Read a machine named at a place in a file of ``folder``; ``derived`` are those that are based on it."""
    shipped = is_shipped(name)
    identity = name if shipped else str((folder / name).resolve())
    if identity in derived:
        raise MachineError(f"based_on goes round in a circle: {' -> '.join([*derived, identity])}")
    label, text = _shipped_text(name, place) if shipped else _file_text(folder / name)
    tree = _parse(text, label)
    tree.children.setdefault("name", Leaf(tree.place, Path(name).stem))
    base = tree.children.pop("based_on", None)
    if base is None:
        return [(label, text, tree)]
    if not isinstance(base, Leaf) or not base.text:
        raise MachineError(f"{base.place}: based_on must be the name or the file of a machine")
    beside = folder if shipped else (folder / name).parent
    below = _layers(base.text, beside, (*derived, identity), f"{base.place}: based_on: ")
    return [(label, text, tree), *below]


def _shipped_text(name: str, place: str) -> tuple[str, str]:
    """Return file label and text of a shipped machine, or of one that is drawn."""
    if random_machine.is_unknown(name):
        return name, random_machine.text(name, _numbers(read(random_machine.parts(name)[1]), ""))
    if name not in shipped_machines():
        known = ", ".join(shipped_machines())
        raise MachineError(
            f"{place}no machine named {name!r}: there are {known}, unknown:SEED; "
            "a file needs its suffix (.yaml)"
        )
    label = f"{name}.yaml"
    return label, (resources.files("forest_description") / "machines" / label).read_text("utf-8")


def _numbers(tree: Branch, prefix: str) -> dict[str, random_machine.Number]:
    """Return the numbers of a tree, which is a shipped machine's and thus whole, by dotted key.

    Of a row it is the first one.
    """
    found: dict[str, random_machine.Number] = {}
    for key, item in tree.children.items():
        if not isinstance(item, Branch):
            continue
        value, unit = item.children.get("value", item.children.get("values")), item.children.get("unit")
        if isinstance(value, Leaf | Row) and isinstance(unit, Leaf):
            first = value.text if isinstance(value, Leaf) else value.texts[0]
            found[prefix + key] = random_machine.Number(float(str(first)), str(unit.text))
        else:
            found |= _numbers(item, f"{prefix}{key}.")
    return found


def _file_text(path: Path) -> tuple[str, str]:
    """Return file label and text of a machine file."""
    if path.exists() and not path.is_file():  # a pipe may never end, and each node reads the file
        raise MachineError(f"{path}: cannot read the machine file: not a regular file")
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise MachineError(f"{path}: a machine file has at most {LARGEST} bytes, this one has more")
        return str(path), data.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise MachineError(f"{path}: cannot read the machine file: {reason}") from error


def _parse(text: str, label: str) -> Branch:
    """Parse YAML text into a tree whose places are "label:line"."""
    try:
        node = _composed(text)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise MachineError(f"{label}:{line}: not valid YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise MachineError(f"{label}:1: not valid YAML: {error}") from error
    if not isinstance(node, yaml.MappingNode):
        raise MachineError(f"{label}:1: a machine file is a mapping of keys, this one is not")
    return _branch(node, label, "")


def _composed(text: str) -> yaml.Node | None:
    """Return YAML text as nodes: by the parser in C, or for its complaints by Python's, which says more."""
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        _refuse_depths(yaml.parse(text, Loader=loader))
        return yaml.compose(text, Loader=loader)
    except RecursionError as error:
        raise _TooDeep from error
    except _TooDeep:
        raise
    except yaml.YAMLError:
        return yaml.compose(text, Loader=yaml.SafeLoader)


def _refuse_depths(events: Iterable[yaml.Event]) -> None:
    """Raise `_TooDeep` for a text that is nested deeper than any machine: the parser in C would crash."""
    depth = 0
    for event in events:
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise _TooDeep


def _branch(mapping: yaml.MappingNode, label: str, prefix: str) -> Branch:
    """Turn a YAML mapping into a branch; a key that stands twice is an error."""
    children: dict[str, Branch | Leaf | Row] = {}
    for key_node, node in mapping.value:
        place, key = f"{label}:{key_node.start_mark.line + 1}", str(key_node.value)
        if key in children:
            raise MachineError(f"{place}: {prefix}{key} stands here for the second time")
        if isinstance(node, yaml.MappingNode):
            children[key] = _branch(node, label, f"{prefix}{key}.")._replace(place=place)
        elif isinstance(node, yaml.ScalarNode):
            null = node.tag == "tag:yaml.org,2002:null"
            children[key] = Leaf(place, None if null else str(node.value))
        elif all(isinstance(item, yaml.ScalarNode) for item in node.value):
            children[key] = Row(place, tuple(str(item.value) for item in node.value))
        else:
            raise MachineError(f"{place}: {prefix}{key} must be a list of numbers")
    return Branch(f"{label}:{mapping.start_mark.line + 1}", children)


def overlay(base: Branch, top: Branch) -> Branch:
    """Return ``base`` with everything that ``top`` says.

    A quantity is replaced as a whole, and so is a section whose ``kind`` is another one.
    """
    if _kind(top) not in (None, _kind(base)):
        return top
    children = dict(base.children)
    for key, item in top.children.items():
        below = children.get(key)
        if isinstance(item, Branch) and isinstance(below, Branch) and not _is_quantity(item):
            children[key] = overlay(below, item)
        else:
            children[key] = item
    return Branch(top.place, children)


def _kind(branch: Branch) -> str | None:
    """Return what a section says under ``kind``."""
    leaf = branch.children.get("kind")
    return leaf.text if isinstance(leaf, Leaf) else None


def _is_quantity(branch: Branch) -> bool:
    """Tell a number, or a row of them, with its unit and source from a section."""
    return any(key in branch.children for key in (*QUANTITY_KEYS, *ROW_KEYS))
