"""The numbers of `forest_control`: constants of its modules, and the settings of controller and valve driver.

Whole numbers are codes and sizes: none of these. A constant is called `room.module.NAME`; a setting
`controller.name` or `valve_driver.name`, as on the nodes.
Modules take each other's constants by name when they are imported, so a change must reach each of them.
What a NamedTuple took as a default keeps its value.
"""

import importlib
import math
import pkgutil
import sys
from functools import lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from forest_compile.entry import RuntimeNumber
from forest_control.config import controller_settings
from forest_control.valve import valve_driver_parameters
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_study.results import StudyError

ROOMS = ("servo", "valve", "limits", "pipeline", "safety", "config")
NODES: dict[str, dict[str, Any]] = {
    "controller": controller_settings.Settings()._asdict(),
    "valve_driver": valve_driver_parameters.Settings()._asdict(),
}
MODULE = "forest_control."

Number = float | tuple[float, ...]
Changes = dict[str, Number]


class Settings(NamedTuple):
    """Settings with what was changed."""

    control: controller_settings.Settings
    drive: valve_driver_parameters.Settings


def numbers(rooms: tuple[str, ...], machine: Machine) -> Changes:
    """Return names and values of the constants of some rooms, and of a machine's nodes' settings if named."""
    found: Changes = {}
    for room in rooms:
        if room in NODES:
            ruled = controller_settings.with_rules(machine, controller_settings.Settings())
            pairs = (ruled._asdict() if room == "controller" else NODES[room]).items()
            found |= {f"{room}.{name}": value for name, value in pairs if _is_number(value)}
        else:
            for module in _modules(room):
                place = module.__name__.removeprefix(MODULE)
                found |= {f"{place}.{name}": value for name, value in _own(module)}
    return found


def changed(changes: Changes) -> Settings:
    """Change constants of this process, before anything is computed with them; return the settings.

    Raises:
        StudyError: there is no such constant or setting.
    """
    given: dict[str, dict[str, Any]] = {node: {} for node in NODES}
    for key, value in changes.items():
        place, _, name = key.rpartition(".")
        if place in NODES and name in NODES[place]:
            given[place][name] = value
        else:
            _change_constant(place, name, value)
    _forget()
    return Settings(
        controller_settings.Settings(**given["controller"]),
        valve_driver_parameters.Settings(**given["valve_driver"]),
    )


def _forget() -> None:
    """Forget what modules have kept of computations with other constants."""
    for module in [module for room in ROOMS for module in _modules(room)]:
        for kept in [one for one in vars(module).values() if hasattr(one, "cache_clear")]:
            kept.cache_clear()


def at_runtime() -> Floats:
    """Let kernels read all constants that are no whole numbers when they run; return their values.

    One kernel then serves all changes. It is for a process that computes nothing else.
    """
    values: list[float] = []

    def placed(value: Number) -> Number:
        if isinstance(value, tuple):
            return tuple(map(placed, value))  # type: ignore[arg-type]
        if not isinstance(value, float):
            return value
        values.append(value)
        return RuntimeNumber(value, len(values) - 1)

    for module in [module for room in ROOMS for module in _modules(room)]:
        for name, value in sorted(_own(module)):
            _replace(module, name, placed(value))
    return np.array(values)


def scaled(value: Number, factor: float) -> Number:
    """Return a number, or each of several, times a factor."""
    return tuple(factor * one for one in value) if isinstance(value, tuple) else factor * value


def _change_constant(place: str, name: str, value: Number) -> None:
    try:
        owner = importlib.import_module(MODULE + place)
        getattr(owner, name)
    except (ImportError, AttributeError, ValueError):
        raise StudyError(
            f"{place}.{name} is no constant of forest_control and no setting; "
            "allowed: names as in the table, such as servo.inching.LOOK or controller.lead"
        ) from None
    _replace(owner, name, value)


def _replace(owner: ModuleType, name: str, value: Number) -> None:
    """Give a constant another value in its own module, and in those that have imported it."""
    before = getattr(owner, name)
    for module in [module for key, module in list(sys.modules.items()) if key.startswith("forest_")]:
        if getattr(module, name, None) is before and (module is owner or name not in dict(_own(module))):
            setattr(module, name, value)


def _modules(room: str) -> list[ModuleType]:
    package = importlib.import_module(MODULE + room)
    names = sorted(one.name for one in pkgutil.iter_modules(package.__path__))
    return [importlib.import_module(f"{package.__name__}.{name}") for name in names]


def _own(module: ModuleType) -> list[tuple[str, Number]]:
    """Return the numbers that a module's own lines assign."""
    source = _source(module)
    return [
        (name, value)
        for name, value in vars(module).items()
        if name.isupper() and _is_number(value) and (f"\n{name} =" in source or f"\n{name}: " in source)
    ]


@lru_cache
def _source(module: ModuleType) -> str:
    return module.__spec__.loader.get_source(module.__name__)  # type: ignore[union-attr, no-any-return]


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        return bool(value) and type(value) is tuple and all(map(_is_number, value))
    return type(value) is float and not math.isnan(value)
