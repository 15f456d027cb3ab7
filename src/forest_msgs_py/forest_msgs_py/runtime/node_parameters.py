"""Parameters with a type, a range and a unit, refused in one clear line that names all of them.

The type of a parameter is the type of its default: bool, int, float, str, or a list of one of them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter


class ParameterError(ValueError):
    """A parameter's value is not allowed; the text names parameter, value and what is allowed."""


def declare(
    node: Node,
    name: str,
    default: Any,
    doc: str,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: Sequence[Any] | None = None,
    read_only: bool = True,
) -> Any:
    """Declare a parameter of the default's type and give its checked value.

    Whole numbers are accepted for floats, as people type them. The check comes before the range goes into the
    descriptor: rclpy's own refusal names neither the value nor the range.

    Raises:
        ParameterError: wrong type, not finite, out of range or not among the choices.
    """
    description = f"{doc} [{unit}]" if unit else doc
    loose = ParameterDescriptor(description=description, dynamic_typing=True)
    given = node.declare_parameter(name, default, loose).value
    allowed = _allowed(default, unit, low, high, choices)
    value = _converted(default, given)
    if value is None or not _inside(value, low, high, choices):
        raise ParameterError(f"parameter '{name}' is {given!r}; allowed: {allowed}")
    node.set_parameters([Parameter(name, value=value)])
    strict = ParameterDescriptor(
        description=description, additional_constraints=f"allowed: {allowed}", read_only=read_only
    )
    strict.type = node.get_parameter(name).type_.value
    _add_range(strict, default, low, high)
    node.set_descriptor(name, strict)
    return value


def declare_triple(
    node: Node,
    name: str,
    default: tuple[float, float, float],
    doc: str,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
) -> tuple[float, float, float]:
    """Declare a parameter of three numbers, as `declare` does.

    Raises:
        ParameterError: as `declare`, or not three numbers.
    """
    values = declare(node, name, list(default), doc, unit, low, high)
    if len(values) != 3:
        raise ParameterError(f"parameter '{name}' is {values!r}; allowed: 3 numbers")
    return values[0], values[1], values[2]


class Tunables:
    """Parameters that may be set while the node runs, checked at the start and later by the same rule.

    Args:
        node: whose parameters they are.
        bundles: by parameter: what its value stands for, as values of other parameters. To set it sets
            those, too; a ValueError of the function's refuses it.
    """

    def __init__(
        self, node: Node, bundles: Mapping[str, Callable[[Any], dict[str, Any]]] | None = None
    ) -> None:
        self._node = node
        self._bundles = dict(bundles or {})
        self._defaults: dict[str, Any] = {}
        self._rules: dict[str, tuple[str, float | None, float | None, Sequence[Any] | None]] = {}
        self.values: dict[str, Any] = {}

    def declare(
        self,
        name: str,
        default: Any,
        doc: str,
        unit: str = "",
        low: float | None = None,
        high: float | None = None,
        choices: Sequence[Any] | None = None,
    ) -> Any:
        """Declare a parameter, as `declare` does; a default of three numbers (a tuple) makes it a triple.

        Raises:
            ParameterError: as `declare` and `declare_triple`.
        """
        given = list(default) if isinstance(default, tuple) else default
        self._defaults[name], self._rules[name] = default, (unit, low, high, choices)
        found = declare(self._node, name, given, doc, unit, low, high, choices, read_only=False)
        self.values[name] = self._checked(name, found)
        return self.values[name]

    def watch(self, changed: Callable[[dict[str, Any]], None]) -> None:
        """Follow what is set from now on.

        Args:
            changed: is called with all values once some were set; a ValueError of its refuses them.
        """

        def on_set(parameters: list[Parameter]) -> SetParametersResult:
            mine = [parameter for parameter in parameters if parameter.name in self._defaults]
            try:
                values = self.values | {one.name: self._checked(one.name, one.value) for one in mine}
                if mine:
                    changed(values)
            except ValueError as error:
                return SetParametersResult(successful=False, reason=str(error))
            self.values = values
            return SetParametersResult(successful=True)

        self._node.add_pre_set_parameters_callback(self._unbundled)
        self._node.add_on_set_parameters_callback(on_set)

    def _unbundled(self, parameters: list[Parameter]) -> list[Parameter]:
        """Whole numbers become floats where those were declared, a bundle brings what it stands for."""
        given = {parameter.name for parameter in parameters}
        result = []
        for parameter in parameters:
            value = _converted(self._defaults.get(parameter.name), parameter.value)
            result.append(parameter if value is None else Parameter(parameter.name, value=value))
            if parameter.name in self._bundles:
                with contextlib.suppress(ValueError):  # which refuses it when it comes to the check
                    inside = self._bundles[parameter.name](parameter.value).items()
                    result += [
                        Parameter(name, value=_listed(one)) for name, one in inside if name not in given
                    ]
        return result

    def _checked(self, name: str, given: Any) -> Any:
        """The value in the default's type.

        Raises:
            ParameterError: it is not allowed.
        """
        default, (unit, low, high, choices) = self._defaults[name], self._rules[name]
        if name in self._bundles:
            self._bundles[name](given)
        value = _converted(default, given)
        if value is None or not _inside(value, low, high, choices):
            allowed = _allowed(default, unit, low, high, choices)
            raise ParameterError(f"parameter '{name}' is {given!r}; allowed: {allowed}")
        if not isinstance(default, tuple):
            return value
        if len(value) != len(default):
            raise ParameterError(f"parameter '{name}' is {value!r}; allowed: {len(default)} numbers")
        return tuple(value)


def _listed(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _converted(default: Any, given: Any) -> Any:
    """The value in the default's type, or None where it does not fit."""
    if isinstance(default, float) and isinstance(given, int) and not isinstance(given, bool):
        return float(given)
    if isinstance(default, (list, tuple)):
        items = list(given) if isinstance(given, (list, tuple)) or hasattr(given, "typecode") else [None]
        converted = [_converted(default[0], item) for item in items] if default else items
        return None if any(item is None for item in converted) else converted
    return given if type(given) is type(default) else None


def _inside(value: Any, low: float | None, high: float | None, choices: Sequence[Any] | None) -> bool:
    if isinstance(value, list):
        return all(_inside(item, low, high, choices) for item in value)
    if isinstance(value, float) and not math.isfinite(value):
        return False
    if choices is not None and value not in choices:
        return False
    return (low is None or value >= low) and (high is None or value <= high)


def _allowed(
    default: Any, unit: str, low: float | None, high: float | None, choices: Sequence[Any] | None
) -> str:
    kinds = {bool: "true or false", int: "a whole number", float: "a finite number", str: "a text"}
    if choices is not None:
        return "one of " + ", ".join(map(str, choices))
    kind = kinds.get(type(default), "a list of numbers or texts like the default")
    if low is None and high is None:
        return kind
    bounds = f"{'-inf' if low is None else f'{low:g}'} .. {'inf' if high is None else f'{high:g}'}"
    return f"{bounds} {unit}".rstrip()


def _add_range(descriptor: ParameterDescriptor, default: Any, low: float | None, high: float | None) -> None:
    """Ranges that ``ros2 param describe`` shows and a later ``ros2 param set`` respects; scalars only."""
    if low is None and high is None:
        return
    if isinstance(default, float):
        bounds = (-math.inf if low is None else float(low), math.inf if high is None else float(high))
        descriptor.floating_point_range = [FloatingPointRange(from_value=bounds[0], to_value=bounds[1])]
    elif isinstance(default, int):
        whole = (-(2**63) if low is None else int(low), 2**63 - 1 if high is None else int(high))
        descriptor.integer_range = [IntegerRange(from_value=whole[0], to_value=whole[1])]
