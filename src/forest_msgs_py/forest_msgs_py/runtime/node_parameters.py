"""Tables of parameters on a node: declared, checked, refused in one line, and followed when they are set."""

import contextlib
import math
from collections.abc import Callable, Mapping
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from forest_msgs_py.runtime.parameter_table import Parameter, Table, converted, table_of, table_rows


def declare(node: Node, table: type[Table], **defaults: Any) -> Table:
    """Declare a whole table on a node and return the checked values.

    Args:
        node: whose parameters they are.
        table: see `parameter_table`.
        defaults: in place of the table's own.

    Raises:
        ParameterError: a value is not allowed.
    """
    return table_of(table, {row.name: declare_one(node, row) for row in table_rows(table, defaults)})


def declare_one(node: Node, row: Parameter) -> Any:
    """Declare a parameter and return its checked value.

    The check comes before the range goes into the descriptor: rclpy's own refusal names neither value nor
    range.

    Raises:
        ParameterError: the value is not allowed.
    """
    loose = ParameterDescriptor(description=row.description, dynamic_typing=True)
    value = row.checked(node.declare_parameter(row.name, _ros_value(row.default), loose).value)
    node.set_parameters([RosParameter(row.name, value=_ros_value(value))])
    strict = ParameterDescriptor(
        description=row.description,
        additional_constraints=f"allowed: {row.allowed}",
        read_only=row.read_only,
        type=node.get_parameter(row.name).type_.value,
    )
    _add_range(strict, row)
    node.set_descriptor(row.name, strict)
    return value


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
        self._rows: dict[str, Parameter] = {}
        self.values: dict[str, Any] = {}  # as people type them

    def declare(self, table: type[Table], defaults: Mapping[str, Any] | None = None) -> Table:
        """Declare a whole table and return the checked values; `defaults` replace the table's own.

        Raises:
            ParameterError: a value is not allowed.
        """
        for row in table_rows(table, defaults):
            self._rows[row.name] = row
            self.values[row.name] = declare_one(self._node, row)
        return table_of(table, self.values)

    def watch(self, changed: Callable[[dict[str, Any]], None]) -> None:
        """Follow what is set from now on.

        Args:
            changed: is called with all values once some were set; a ValueError of its refuses them.
        """

        def on_set(parameters: list[RosParameter]) -> SetParametersResult:
            mine = [parameter for parameter in parameters if parameter.name in self._rows]
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

    def _unbundled(self, parameters: list[RosParameter]) -> list[RosParameter]:
        """Whole numbers become floats where those were declared, a bundle brings what it stands for."""
        given = {parameter.name for parameter in parameters}
        result = []
        for parameter in parameters:
            row = self._rows.get(parameter.name)
            value = converted(row.default, parameter.value) if row else None
            result.append(parameter if value is None else RosParameter(parameter.name, value=value))
            if parameter.name in self._bundles:
                with contextlib.suppress(ValueError):  # which refuses it when it comes to the check
                    inside = self._inside(parameter.name, parameter.value).items()
                    result += [
                        RosParameter(name, value=_ros_value(one)) for name, one in inside if name not in given
                    ]
        return result

    def _checked(self, name: str, given: Any) -> Any:
        """The value in the default's type.

        Raises:
            ValueError: it is not allowed.
        """
        if name in self._bundles:
            self._inside(name, given)
        return self._rows[name].checked(given)

    def _inside(self, name: str, given: Any) -> dict[str, Any]:
        """What a bundle brings; its type is checked first, for ROS asks here before it does so itself.

        Raises:
            ValueError: it is not allowed.
        """
        return self._bundles[name](self._rows[name].checked(given))


def _ros_value(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _add_range(descriptor: ParameterDescriptor, row: Parameter) -> None:
    """Ranges that ``ros2 param describe`` shows and a later ``ros2 param set`` respects; scalars only."""
    low, high = row.low, row.high
    if low is None and high is None:
        return
    if isinstance(row.default, float):
        bounds = (-math.inf if low is None else float(low), math.inf if high is None else float(high))
        descriptor.floating_point_range = [FloatingPointRange(from_value=bounds[0], to_value=bounds[1])]
    elif isinstance(row.default, int):
        whole = (-(2**63) if low is None else int(low), 2**63 - 1 if high is None else int(high))
        descriptor.integer_range = [IntegerRange(from_value=whole[0], to_value=whole[1])]
