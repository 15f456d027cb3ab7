"""What the controller's node is set to: its parameters, machine, profile and walls, declared and loaded."""

from collections.abc import Callable, Mapping
from typing import Any

from forest_control.config.controller_node_parameters import (
    ControllerParameters,
    ProfileParameter,
    WorkspaceParameter,
)
from forest_control.config.controller_settings import Parameters, Settings, parameters
from forest_control.config.profile_file import load_profile
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
        self._get = node.get_parameter
        # An operator's profile gives what is not set.
        self._tunables = Tunables(node, {"profile": load_profile})
        profile = load_profile(self._tunables.declare(ProfileParameter).profile)
        settings = self._tunables.declare(Settings, profile)
        self.node, self.joystick = declare(node, ControllerParameters), declare(node, WatchParameters)
        self._walls = self._tunables.declare(WorkspaceParameter).workspace  # that `_workspace` was read from
        self._workspace = load_workspace(self._walls)
        self.parameters = parameters(self.machine, settings, self._workspace)

    def watch(self, changed: Callable[[Parameters], None], moves: Callable[[], bool]) -> None:
        """Follow what is set from now on.

        Args:
            changed: is called with the controller's parameters whenever settings are set.
            moves: tells whether the crane is driven: then walls stay as they are. One that appeared before a
                moving tip would ask for a stop that no valve can make.
        """

        def on_set(values: Mapping[str, Any]) -> None:
            walls: str = values["workspace"]
            if walls != self._walls:  # a file is read when it is named, not with each other setting
                workspace = load_workspace(walls)
                if moves():
                    raise ValueError("workspace: the crane is driven; allowed: with the deadman released")
                self._workspace, self._walls = workspace, walls
            changed(parameters(self.machine, table_of(Settings, values), self._workspace))

        self._tunables.watch(on_set)

    def hands_off(self) -> bool:
        """Tell whether somebody else has the valves."""
        return bool(self._get("hands_off").value)

    def limits(self) -> dict[str, Any]:
        """Return what limits the motion, for /diagnostics."""
        settings = {name + unit: self._tunables.values[name] for name, unit in LIMITS.items()}
        return {"state_timeout [s]": self.node.state_timeout, "hands_off": self.hands_off()} | settings
