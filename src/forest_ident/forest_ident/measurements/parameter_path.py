"""Numbers of a machine by their dotted key in its file: read one, or make a machine with other ones.

A key like ``valve.backward.deadband_voltage`` names the way through the dataclasses. Identification and
studies speak of parameters by these keys, because the machine file and its reference do.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from forest_description.components.valve_parameters import BackwardValve
from forest_description.config.parameter import parameter_of
from forest_description.machine import Machine, MachineError


def value_of(machine: Machine, key: str) -> float:
    """Return the number that a dotted key names, in SI [valves: V].

    Raises:
        MachineError: the machine has no such number.
    """
    part: Any = machine
    for name in key.split("."):
        part = getattr(part, name, None)
    if not isinstance(part, float):
        raise MachineError(f"{machine.name} has no number {key}")
    return part


def with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """Return the machine with some numbers replaced; a number beyond its range stands at the range's end.

    An estimate on its way through a fit may leave the range for a moment; what is written to a file is
    checked again when the file is read.

    Raises:
        MachineError: a key names nothing, or the numbers contradict each other.
    """
    for key, value in values.items():
        machine = _replaced(machine, key.split("."), value, key)
    return machine


def _replaced(part: Any, names: list[str], value: float, key: str) -> Any:
    first, *rest = names
    fields = {field.name: field for field in dataclasses.fields(part)} if part is not None else {}
    if first not in fields:
        raise MachineError(f"there is no number {key} in this machine")
    if rest:
        inner = _replaced(getattr(part, first), rest, value, key)
        return dataclasses.replace(part, **{first: inner})
    allowed = parameter_of(fields[first])
    if allowed is not None:
        value = min(max(value, allowed.low), allowed.high)
    return dataclasses.replace(part, **{first: value})


def with_directions(machine: Machine, section: str) -> Machine:
    """Return the machine with the valve of a section ("valve", "boom.valve") told for both directions."""
    axis, _, _ = section.rpartition(".")
    owner: Any = getattr(machine, axis) if axis else machine
    valve = owner.valve if owner.valve is not None else machine.valve
    if valve.backward is None:
        same = BackwardValve(valve.deadband_voltage, valve.minimum_resistance)
        valve = dataclasses.replace(valve, backward=same)
    owner = dataclasses.replace(owner, valve=valve)
    return dataclasses.replace(machine, **{axis: owner}) if axis else owner
