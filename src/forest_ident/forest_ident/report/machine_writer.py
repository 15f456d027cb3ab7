"""An identified machine as a file: what was found, its source and interval, laid over the start's file."""

import dataclasses
import json
import math
import os
from pathlib import Path
from typing import Any

from forest_description.components.hose import GeometricHose, MeasuredHose
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES
from forest_ident.estimators.parameter_estimate import NORMAL_95, Estimate
from forest_ident.measurements.parameter_path import value_of
from forest_ident.refinement.result import Result

HOSE_PARTS = ("length", "bore", "turbulent_resistance", "laminar_resistance", "inertance", "capacitance")
HOSE_UNITS = ("m", "m", "Pa*s2/m6", "Pa*s/m3", "Pa*s2/m3", "m3/Pa")


def write(result: Result, start: str, file: Path) -> Machine:
    """Write the identified machine and return it as the file gives it back.

    Args:
        result: of the identification.
        start: name or file of the machine that it started from.
        file: to be written; its folder must be there.

    Raises:
        MachineError: the numbers do not make a machine; the file is left for inspection.
        OSError: it cannot be written.
    """
    based_on = start
    if Path(start).suffix:
        based_on = os.path.relpath(Path(start).resolve(), file.resolve().parent)
    tree = _tree(result)
    lines = [
        f"# Identified from records; what is not here is as in {Path(based_on).name}.",
        f"based_on: {based_on}",
        f"description: {json.dumps(f'{result.start.description}, identified', ensure_ascii=False)}",
        "",
        *_lines(tree, 0),
    ]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return load_machine(file)


def _tree(result: Result) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for key, estimate in result.estimates.items():
        _put(tree, key, _quantity(estimate))
    for section in ("hose", *(f"{axis}.hose" for axis in AXES)):
        _measured(tree, section, result)
    _calibrated(tree, result)
    for section in ("valve", *(f"{axis}.valve" for axis in AXES)):
        _both_ways(tree, section, result)
    return tree


def _calibrated(tree: dict[str, Any], result: Result) -> None:
    """Tell the sensors' offsets and gains; a start without any gets all keys. Thesis section 4.3.1."""
    now, was = result.machine.sensors.calibration, result.start.sensors.calibration
    if now is None or now == was:
        return
    found = {o.channel: o for o in result.calibration if math.isfinite(o.offset_error)}
    for field in dataclasses.fields(now):
        key = f"sensors.calibration.{field.name}"
        if field.name in found:
            o = found[field.name]
            for part, unit, error in (("offset", o.unit, o.offset_error), ("gain", "1", o.gain_error)):
                value, reach = getattr(o, part), NORMAL_95 * error
                how = (
                    f"95 % interval {value - reach:.5g} .. {value + reach:.5g}"
                    if error > 0.0
                    else "not looked for"
                )
                text = f'{{value: {value:.9g}, unit: {unit}, source: "calibrated: {how}"}}'
                _put(tree, f"{key}.{part}", text)
        elif was is None:
            _put(tree, key, "null")


def _both_ways(tree: dict[str, Any], section: str, result: Result) -> None:
    """Complete a backward direction of which only one number was found."""
    if not any(key.startswith(f"{section}.backward.") for key in result.estimates):
        return
    for part, unit in (("deadband_voltage", "V"), ("minimum_resistance", "Pa*s2/m6")):
        key = f"{section}.backward.{part}"
        if key not in result.estimates:
            value = value_of(result.machine, key)
            _put(tree, key, f'{{value: {value:.9g}, unit: {unit}, source: "as told before"}}')


def _measured(tree: dict[str, Any], section: str, result: Result) -> None:
    """Tell a hose that was known by its bore as the measured one it is now."""
    axis = section.partition(".")[0] if "." in section else ""
    was = getattr(result.start, axis).hose if axis else result.start.hose
    now = getattr(result.machine, axis).hose if axis else result.machine.hose
    found = any(key.startswith(f"{section}.") for key in result.estimates)
    if not (found and isinstance(was, GeometricHose) and isinstance(now, MeasuredHose)):
        return
    _put(tree, f"{section}.kind", "measured")
    for part, unit in zip(HOSE_PARTS, HOSE_UNITS, strict=True):
        if f"{section}.{part}" not in result.estimates:
            value = getattr(now, part)
            source = "as the bore had it" if part != "length" else "length of the measured piece"
            _put(tree, f"{section}.{part}", f'{{value: {value:.9g}, unit: {unit}, source: "{source}"}}')


def _quantity(e: Estimate) -> str:
    _, low, high = e.formatted()
    doubt = f"; {e.warning}" if e.warning else ""
    source = f"identified: {e.method}, 95 % interval {low} .. {high}{doubt}"
    return f'{{value: {e.value:.9g}, unit: {e.unit}, source: "{source}"}}'


def _put(tree: dict[str, Any], key: str, text: str) -> None:
    *sections, last = key.split(".")
    for name in sections:
        tree = tree.setdefault(name, {})
    tree[last] = text


def _lines(tree: dict[str, Any], depth: int) -> list[str]:
    lines = []
    for key, item in tree.items():
        if isinstance(item, dict):
            lines += [f"{'  ' * depth}{key}:", *_lines(item, depth + 1)]
        else:
            lines.append(f"{'  ' * depth}{key}: {item}")
    return lines
