"""Parts of a machine by their dotted path in its file: read a number or a section, or replace it.

A path like ``valve.backward.deadband_voltage`` names the way through the dataclasses. Identification and
studies speak of parameters by these paths, because the machine file and its reference do.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any

from forest_description.config.parameter import MachineError, parameter_of
from forest_description.hydraulics.valve_parameters import BackwardValve, Valve
from forest_description.machine import Machine
from forest_description.types import AXES

SECTIONS = ("valve", *(f"{axis}.valve" for axis in AXES))
"""Where a machine file may describe a valve: the shared one, and one for each axis."""


def part_of(machine: Machine, path: str) -> Any:
    """Return the section or number at a path; None where the machine has none."""
    part: Any = machine
    for name in path.split("."):
        part = getattr(part, name, None)
    return part


def with_part(machine: Machine, path: str, part: Any) -> Machine:
    """Return the machine with another section or number at a path.

    Raises:
        MachineError: the new part contradicts the rest.
    """
    name, _, rest = path.partition(".")
    if rest:
        part = with_part(getattr(machine, name), rest, part)
    return dataclasses.replace(machine, **{name: part})


def value_of(machine: Machine, key: str) -> float:
    """Return the number that a dotted key names, in SI [valves: V].

    Raises:
        MachineError: the machine has no such number.
    """
    value = part_of(machine, key)
    if not isinstance(value, float):
        raise MachineError(f"{machine.name} has no number {key}")
    return value


def with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """Return the machine with some numbers replaced; a number beyond its range is set to the range's end.

    An estimate may leave the range for a moment during a fit. The file's reader checks the final numbers.

    Raises:
        MachineError: a key names nothing, or the numbers contradict each other.
    """
    sections: dict[str, dict[str, float]] = {}
    for key, value in values.items():
        section, _, name = key.rpartition(".")
        owner = part_of(machine, section) if section else machine
        fields = {field.name: field for field in dataclasses.fields(owner)} if owner is not None else {}
        if name not in fields:
            raise MachineError(f"there is no number {key} in this machine")
        allowed = parameter_of(fields[name])
        if allowed is not None:
            value = min(max(value, allowed.low), allowed.high)
        sections.setdefault(section, {})[name] = value
    for section, changes in sections.items():
        owner = part_of(machine, section) if section else machine
        changed = dataclasses.replace(owner, **changes)
        machine = with_part(machine, section, changed) if section else changed
    return machine


def valve_section(machine: Machine, axis: int) -> str:
    """Return the path of an axis' valve: "valve", or its own section."""
    return f"{AXES[axis]}.valve" if machine.drives[axis].valve is not None else "valve"


def hose_section(machine: Machine, axis: int) -> str:
    """Return the path of an axis' hose: "hose", or its own section."""
    return f"{AXES[axis]}.hose" if machine.drives[axis].hose is not None else "hose"


def valve_at(machine: Machine, section: str) -> Valve:
    """Return the valve of a section ("valve", "boom.valve"); the shared one where the axis has none."""
    return part_of(machine, section) or machine.valve


def with_directions(machine: Machine, section: str) -> Machine:
    """Return the machine with the valve of a section described for both directions."""
    valve = valve_at(machine, section)
    if valve.backward is None:
        same = BackwardValve(valve.deadband_voltage, valve.minimum_resistance)
        valve = dataclasses.replace(valve, backward=same)
    return with_part(machine, section, valve)
