"""Parameters of the controller's node, beside its `Settings` and those of the joystick watch."""

from typing import Annotated, NamedTuple

from forest_control.config import profile_file, workspace_file
from forest_control.operator.levers import BUTTON_COUNT, LEFT_SHOULDER
from forest_msgs_py.runtime.parameter_table import Parameter, tunable
from forest_msgs_py.types import PERIOD


class ProfileParameter(NamedTuple):
    """The operator's profile, which gives the defaults of some settings."""

    profile: Annotated[
        str,
        tunable(
            f"operator's profile: {', '.join(profile_file.shipped())}, or path of a file;"
            " other given parameters win"
        ),
    ] = "default"


class WorkspaceParameter(NamedTuple):
    """Walls that the tip keeps out of."""

    workspace: Annotated[
        str,
        tunable(f"workspace limits: {', '.join(workspace_file.shipped())}, or path of a file; empty: none"),
    ] = ""


class ControllerParameters(NamedTuple):
    """Of `controller_node`."""

    period: Annotated[float, Parameter("nominal period of the state", "s", 1e-4, 0.1)] = PERIOD
    state_timeout: Annotated[float, Parameter("age at which the state is lost", "s", 0.01, 0.2)] = 0.1
    deadman_button: Annotated[
        int, Parameter("button to hold as the deadman", low=0, high=BUTTON_COUNT - 1)
    ] = LEFT_SHOULDER
    plain_arrays: Annotated[bool, Parameter("publish Float64MultiArray without stamp")] = False
    hands_off: Annotated[
        bool, tunable("disarmed, without valve commands: another node drives the valves")
    ] = False
    publish_description: Annotated[bool, Parameter("publish robot_description, where no simulator does")] = (
        False
    )
