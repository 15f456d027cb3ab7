"""What the controller's node is set to: its parameters, machine, profile and walls, declared and loaded."""

from collections.abc import Callable, Mapping
from typing import Any

from forest_control.config.controller_parameters import (
    ControllerParameters,
    ProfileParameter,
    WorkspaceParameter,
)
from forest_control.config.profile_file import load_profile
from forest_control.config.settings import Parameters, Settings, parameters
from forest_control.config.workspace_file import load_workspace
from forest_control.operator.joystick_watch import WatchParameters
from forest_description.machine import load_machine
from forest_msgs_py.runtime.node_parameters import Tunables, declare
from forest_msgs_py.runtime.parameter_table import MachineParameter, table_of

# Settings that limit the motion, as /diagnostics tells them.
LIMITS = {"scheme": "", "tip_speed": " [m/s]", "joint_rates": " [rad/s]", "joint_margin": " [rad]"}


class ControllerConfiguration:
    """The node's parameters.

    Args:
        node: on which they are declared.

    Raises:
        ValueError: a parameter, or a file that one names, is not allowed.
    """

    def __init__(self, node: Any) -> None:
        self.machine = load_machine(declare(node, MachineParameter).machine)
        # An operator's profile gives what is not set.
        self._tunables = Tunables(node, {"profile": load_profile})
        profile = load_profile(self._tunables.declare(ProfileParameter).profile)
        settings = self._tunables.declare(Settings, profile)
        self.node, self.joystick = declare(node, ControllerParameters), declare(node, WatchParameters)
        self._workspace = load_workspace(self._tunables.declare(WorkspaceParameter).workspace)
        self.parameters = parameters(self.machine, settings, self._workspace)

    def watch(self, changed: Callable[[Parameters], None]) -> None:
        """Call with the controller's parameters whenever settings are set."""

        def on_set(values: Mapping[str, Any]) -> None:
            same = values["workspace"] == self._tunables.values["workspace"]
            workspace = self._workspace if same else load_workspace(values["workspace"])
            changed(parameters(self.machine, table_of(Settings, values), workspace))
            self._workspace = workspace

        self._tunables.watch(on_set)

    def limits(self, hands_off: bool) -> dict[str, Any]:
        """Return what limits the motion, for /diagnostics."""
        settings = {name + unit: self._tunables.values[name] for name, unit in LIMITS.items()}
        return {"state_timeout [s]": self.node.state_timeout, "hands_off": hands_off} | settings
