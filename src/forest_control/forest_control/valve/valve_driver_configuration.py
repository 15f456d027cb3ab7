"""What the valve driver's node is set to: its parameters and its machine, declared and loaded."""

from typing import Any

from forest_control.valve.unlearnt_valves import told
from forest_control.valve.valve_driver_parameters import DriverParameters, Settings, parameters
from forest_description.machine import load_machine
from forest_msgs_py.runtime.node_parameters import Tunables, declare
from forest_msgs_py.runtime.parameter_table import MachineParameter


class DriverConfiguration:
    """The node's parameters; `core` follows what is set while it runs.

    Args:
        node: on which they are declared.

    Raises:
        ValueError: a parameter, or the machine's file, is not allowed.
    """

    def __init__(self, node: Any) -> None:
        self.machine = load_machine(declare(node, MachineParameter).machine)
        self._tunables = Tunables(node)
        self._use(self._tunables.declare(Settings)._asdict())
        self._tunables.watch(self._use)
        self.node = declare(node, DriverParameters)
        self._unlearnt = told(self.machine)
        if self._unlearnt:
            node.get_logger().info(f"adapt learns nothing at {self._unlearnt}")

    def _use(self, values: dict[str, Any]) -> None:
        self.core = parameters(self.machine, Settings(**values))

    def pressure_settings(self) -> dict[str, Any]:
        """Return what the driver makes of the pressures, for /diagnostics."""
        settings = {name: self._tunables.values[name] for name in ("compensate", "adapt")}
        return settings | ({"not learnt": self._unlearnt} if self._unlearnt else {})
