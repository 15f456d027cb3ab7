"""A machine as the text of a machine file: every number in SI, so that reading it gives the same machine.

For machines that are made by a program, as a test rig of a crane's parts, and shall be simulated by
a node, which knows machines by their files.
"""

import dataclasses
import json
from collections.abc import Iterator
from typing import Any

from forest_description.config.parameter import Parameter, may_be_left_out, parameter_of
from forest_description.machine import Machine

NAME = "name"  # of the machine: that of its file


def machine_text(machine: Machine, source: str) -> str:
    """Return the text of a machine's file.

    Args:
        machine: any; its numbers may be beyond the ranges for files, which is noticed when it is
            read.
        source: of every number, as the file tells it.
    """
    return "\n".join(_lines(machine, json.dumps(source, ensure_ascii=False), 0)) + "\n"


def entries(part: Any, source: str, prefix: str) -> dict[str, str]:
    """Return the text of every number and choice of a section, by dotted key.

    Args:
        part: a section of a machine.
        source: of every number, as the file tells it.
        prefix: dotted key of the section.
    """
    found = {f"{prefix}.kind": part.kind} if getattr(part, "kind", "") else {}
    for field in dataclasses.fields(part):
        value, allowed, key = getattr(part, field.name), parameter_of(field), f"{prefix}.{field.name}"
        if value is None:
            found |= {} if may_be_left_out(field) else {key: "null"}
        elif allowed is not None:
            found[key] = _number(value, allowed, json.dumps(source, ensure_ascii=False))
        elif isinstance(value, str):
            found[key] = json.dumps(value, ensure_ascii=False)
        else:
            found |= entries(value, source, key)
    return found


def _lines(part: Any, source: str, depth: int) -> Iterator[str]:
    """Yield the lines of a section, its kind first."""
    indent = "  " * depth
    if kind := getattr(part, "kind", ""):
        yield f"{indent}kind: {kind}"
    for field in dataclasses.fields(part):
        value, allowed = getattr(part, field.name), parameter_of(field)
        if depth == 0 and field.name == NAME:
            continue
        if value is None and may_be_left_out(field):
            continue
        if value is None:
            yield f"{indent}{field.name}: null"
        elif allowed is not None:
            yield f"{indent}{field.name}: {_number(value, allowed, source)}"
        elif isinstance(value, str):
            yield f"{indent}{field.name}: {json.dumps(value, ensure_ascii=False)}"
        else:
            yield f"{indent}{field.name}:"
            yield from _lines(value, source, depth + 1)


def _number(value: Any, allowed: Parameter, source: str) -> str:
    """Return a number, or a row of them, with unit and source."""
    row = isinstance(value, tuple)
    numbers = ", ".join(repr(float(one)) for one in value) if row else repr(float(value))
    key, text = ("values", f"[{numbers}]") if row else ("value", numbers)
    return f'{{{key}: {text}, unit: "{allowed.unit}", source: {source}}}'
