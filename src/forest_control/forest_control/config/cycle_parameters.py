"""Parameters of the nodes for taught work and for a program's tip velocity."""

from typing import Annotated, NamedTuple

from forest_control.config import workspace_file
from forest_control.operator.levers import BUTTON_COUNT
from forest_msgs_py.runtime.parameter_table import Parameter, tunable

_CENTRE = Parameter("deflection of a stick that counts as none", "", 0.001, 0.5)


class CycleParameters(NamedTuple):
    """Of `cycle_node`."""

    directory: Annotated[str, Parameter("directory of the user's cycles")] = "cycles"
    button: Annotated[
        int, Parameter("button of the joystick: play, pause, resume, confirm", low=0, high=BUTTON_COUNT - 1)
    ] = 0
    centre: Annotated[float, _CENTRE] = 0.05


class TaughtNames(NamedTuple):
    """Of `cycle_node`: what its services are about."""

    cycle: Annotated[str, tunable("name of the cycle that is taught or played")] = ""
    label: Annotated[str, tunable("name of the next segment that is taught; empty: its kind")] = ""
    workspace: Annotated[
        str,
        tunable(f"workspace limits of the plans: {', '.join(workspace_file.shipped())}, or path of a file"),
    ] = ""


class TwistParameters(NamedTuple):
    """Of `twist_node`."""

    centre: Annotated[float, _CENTRE] = 0.05
