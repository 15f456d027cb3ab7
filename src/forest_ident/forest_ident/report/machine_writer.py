"""Write an identified machine as a file: estimates with source and interval, laid over the start's file."""

import dataclasses
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from forest_description.export import machine_yaml
from forest_description.hydraulics.hose import GeometricHose, MeasuredHose
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES
from forest_ident.estimators.parameter_estimate import NORMAL_95, Estimate, unit_of
from forest_ident.measurements.parameter_path import SECTIONS, part_of, value_of
from forest_ident.model_choice import candidates
from forest_ident.refinement.refinement_task import INERTIAS, VALVE
from forest_ident.refinement.result import Result
from forest_ident.refinement.stated_numbers import moments

OWN = "# Identified from records"
"""Begins a file that `write` made, and may make anew."""
HOSE = ("length", "bore", "turbulent_resistance", "laminar_resistance", "inertance", "capacitance")


def write(
    result: Result, start: str, file: Path, doubts: Mapping[str, str] = MappingProxyType({})
) -> Machine:
    """Write the identified machine; return it as it is read back from the file.

    Args:
        result: of the identification.
        start: name or file of the machine that it started from.
        file: to be written; its folder must be there.
        doubts: why a parameter is not trusted, by dotted key; its source says so.

    Raises:
        MachineError: the numbers do not make a machine; there is no file then.
        OSError: it cannot be written.
    """
    based_on = start
    if Path(start).suffix:
        based_on = os.path.relpath(Path(start).resolve(), file.resolve().parent)
    lines = [
        f"{OWN}; what is not here is as in {Path(based_on).name}.",
        f"based_on: {based_on}",
        f"description: {json.dumps(f'{result.start.description}, identified', ensure_ascii=False)}",
        "",
        *_lines(_tree(_added(load_machine(start), result.machine) | _entries(result, doubts)), 0),
    ]
    draft = file.with_name(f".{file.name}")
    draft.write_text("\n".join(lines) + "\n", encoding="utf-8")
    try:
        load_machine(draft)
        draft.replace(file)
    finally:
        draft.unlink(missing_ok=True)
    return load_machine(file)


def _entries(result: Result, doubts: Mapping[str, str]) -> dict[str, str]:
    """Return the text of each number by its dotted key, in the order of the file."""
    entries = {e.key: _estimate(e, e.warning) for e in _told(result)}
    entries |= {key: _estimate(estimate, doubts.get(key, "")) for key, estimate in result.estimates.items()}
    for section in ("hose", *(f"{axis}.hose" for axis in AXES)):
        entries |= _measured_hose(section, result)
    entries |= _calibration(result)
    for section in SECTIONS:
        entries |= _other_direction(section, result)
    return entries


def _told(result: Result) -> list[Estimate]:
    """Return the stated numbers as the records have them, a factor of inertia as the moments of its link."""
    found = []
    for key, e in result.told.items():
        if key not in INERTIAS:
            found.append(e)
            continue
        for name in moments(key.partition(".")[0]):
            path, size = f"manipulator.{name}", e.value * getattr(result.start.manipulator, name)
            error = abs(size) * e.standard_error / e.value
            found.append(e._replace(key=path, value=size, standard_error=error, unit=unit_of(path)))
    return found


def _added(before: Machine, now: Machine) -> dict[str, str]:
    """Return what `model_choice` added to the machine that the file is based on."""
    source, entries = "assumed: a usual size, from which the search began", {}
    for path in candidates.ADDED:
        part = part_of(now, path)
        if part in (None, 0.0) or part_of(before, path) not in (None, 0.0):
            continue
        if isinstance(part, float):
            entries[path] = _quantity(part, unit_of(path), source)
        else:
            entries |= machine_yaml.entries(part, source, path)
    return entries


def _quantity(value: float, unit: str, source: str) -> str:
    return f'{{value: {value:.9g}, unit: {unit}, source: "{source}"}}'


def _estimate(e: Estimate, doubt: str) -> str:
    _, low, high = e.formatted()
    told = (
        f"; {100.0 * e.stated:.0f} % of its variance from stated numbers, most from {e.most}"
        if e.stated > 0.005
        else ""
    )
    doubtful = f"; not trusted: {doubt}" if doubt else ""
    interval = "95 % interval withheld" if e.withheld else f"95 % interval {low} .. {high}"
    source = f"identified: {e.method}, {interval}{told}{doubtful}".replace('"', "'")
    return _quantity(e.value, e.unit, source)


def _measured_hose(section: str, result: Result) -> dict[str, str]:
    """Return the other numbers of a hose that the start describes by its bore, and that is estimated."""
    before, now = part_of(result.start, section), part_of(result.machine, section)
    estimated = any(key.startswith(f"{section}.") for key in result.estimates)
    if not (estimated and isinstance(before, GeometricHose) and isinstance(now, MeasuredHose)):
        return {}
    entries = {f"{section}.kind": "measured"}
    for part in HOSE:
        key = f"{section}.{part}"
        if key not in result.estimates:
            source = "as the bore had it" if part != "length" else "length of the measured piece"
            entries[key] = _quantity(getattr(now, part), unit_of(key), source)
    return entries


def _calibration(result: Result) -> dict[str, str]:
    """Return the sensors' offsets and gains; a start without any gets all keys. Thesis section 4.3.1."""
    now, before = result.machine.sensors.calibration, result.start.sensors.calibration
    if now is None or now == before:
        return {}
    found = {o.channel: o for o in result.calibration if math.isfinite(o.offset_error)}
    entries = {}
    for field in dataclasses.fields(now):
        key, o = f"sensors.calibration.{field.name}", found.get(field.name)
        if o is not None:
            entries[f"{key}.offset"] = _calibrated(o.offset, o.unit, o.offset_error)
            entries[f"{key}.gain"] = _calibrated(o.gain, "1", o.gain_error)
        elif before is None:
            entries[key] = "null"
    return entries


def _calibrated(value: float, unit: str, error: float) -> str:
    reach = NORMAL_95 * error
    interval = f"95 % interval {value - reach:.5g} .. {value + reach:.5g}"
    return _quantity(value, unit, f"calibrated: {interval if error > 0.0 else 'not looked for'}")


def _other_direction(section: str, result: Result) -> dict[str, str]:
    """Return the other number of a backward direction of which only one was estimated."""
    keys = [f"{section}.backward.{part}" for part in VALVE]
    if not any(key in result.estimates for key in keys):
        return {}
    missing = [key for key in keys if key not in result.estimates]
    return {
        key: _quantity(value_of(result.machine, key), unit_of(key), "as stated before") for key in missing
    }


def _tree(entries: dict[str, str]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for key, text in entries.items():
        *sections, last = key.split(".")
        branch = tree
        for name in sections:
            branch = branch.setdefault(name, {})
        branch[last] = text
    return tree


def _lines(tree: dict[str, Any], depth: int) -> list[str]:
    lines = []
    for key, item in tree.items():
        if isinstance(item, dict):
            lines += [f"{'  ' * depth}{key}:", *_lines(item, depth + 1)]
        else:
            lines.append(f"{'  ' * depth}{key}: {item}")
    return lines
