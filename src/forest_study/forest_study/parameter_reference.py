"""The parameters of all nodes as a page: `python -m forest_study.parameter_reference` prints its Markdown.

It is made from the tables from which the nodes declare them; no node runs.
"""

import json
from typing import Any

from forest_bag.play.player_parameters import PlayerParameters, StepPlayerParameters
from forest_bag.record.recorder_parameters import RecorderParameters
from forest_control.config.controller_node_parameters import (
    ControllerParameters,
    ProfileParameter,
    WorkspaceParameter,
)
from forest_control.config.controller_settings import Settings
from forest_control.config.cycle_parameters import CycleParameters, TaughtNames, TwistParameters
from forest_control.operator.device_joystick import DeviceParameters
from forest_control.operator.joystick_sources import JoystickParameters
from forest_control.operator.joystick_watch import WatchParameters
from forest_control.valve.valve_driver_parameters import DriverParameters
from forest_control.valve.valve_driver_parameters import Settings as DriverSettings
from forest_ident.diagnosis.monitor_parameters import MonitorParameters
from forest_ident.driving.operator_parameters import OperatorParameters
from forest_ident.online.online_parameters import OnlineParameters
from forest_msgs_py.clock.clock_parameters import ClockParameters, LeaderParameters, ListenerParameters
from forest_msgs_py.runtime.parameter_table import MachineParameter, Parameter, table_rows
from forest_sim.live.simulator_parameters import CommanderParameters, SimulatorParameters
from forest_station.server.station_parameters import StationParameters
from forest_study.closed_loop.link_model import DelayParameters, Quality
from forest_viewers.server.server_parameters import ServerParameters

# Node's name: how it is started, its tables.
NODES: dict[str, tuple[str, tuple[type[tuple[Any, ...]], ...]]] = {
    "simulator": (
        "ros2 run forest_sim simulator_node",
        (MachineParameter, SimulatorParameters, ClockParameters, LeaderParameters),
    ),
    "commander": ("ros2 run forest_sim commander_node", (CommanderParameters, ClockParameters)),
    "joystick": (
        "ros2 run forest_control joystick_node",
        (JoystickParameters, DeviceParameters, ClockParameters),
    ),
    "controller": (
        "ros2 run forest_control controller_node",
        (
            *(MachineParameter, ProfileParameter, Settings, WorkspaceParameter),
            *(ControllerParameters, WatchParameters),
            ClockParameters,
        ),
    ),
    "valve_driver": (
        "ros2 run forest_control valve_driver_node",
        (MachineParameter, DriverSettings, DriverParameters, ClockParameters),
    ),
    "cycle": ("ros2 run forest_control cycle_node", (MachineParameter, CycleParameters, TaughtNames)),
    "twist": ("ros2 run forest_control twist_node", (TwistParameters,)),
    "recorder": ("ros2 run forest_ident recorder_node", (RecorderParameters, ListenerParameters)),
    "player": ("forest-bag play BAG", (PlayerParameters,)),
    "step_player": (
        "ros2 run forest_bag step_player_node",
        (StepPlayerParameters, ClockParameters, LeaderParameters),
    ),
    "experiment_operator": (
        "ros2 run forest_ident experiment_operator_node",
        (MachineParameter, OperatorParameters, ClockParameters),
    ),
    "monitor": ("ros2 run forest_ident monitor_node", (MachineParameter, MonitorParameters, ClockParameters)),
    "online_identification": (
        "ros2 run forest_ident online_identification_node",
        (MachineParameter, OnlineParameters, ClockParameters),
    ),
    "viewer": ("ros2 run forest_viewers viewer_node", (MachineParameter,)),
    "foxglove": ("ros2 run forest_viewers foxglove_node", (ServerParameters,)),
    "station": ("ros2 run forest_station station_node", (MachineParameter, StationParameters)),
    "delay": ("ros2 run forest_study delay_node", (DelayParameters, Quality)),
}
HEAD = """# Parameters

Give a parameter at the start with `--ros-args -p NAME:=VALUE`. A value that is not allowed ends the
node with one sentence and exit code 2. Three numbers are of swing, boom and stick.
A *live* parameter may be set while the node runs: `ros2 param set /NODE NAME VALUE`.

The controller's `profile` gives other defaults than these to the settings that it names
(`forest_control/profiles`)."""


def node_rows(node: str) -> tuple[Parameter, ...]:
    """Return all parameters that a node declares."""
    return tuple(row for table in NODES[node][1] for row in table_rows(table))


def page() -> str:
    """Return the reference page of all nodes."""
    return "\n\n".join([HEAD, *map(_section, NODES)])


def _section(node: str) -> str:
    lines = [f"## {node}", "", f"`{NODES[node][0]}`", ""]
    lines += ["| parameter | default | allowed | live | meaning |", "|---|---|---|---|---|"]
    lines += map(_line, node_rows(node))
    return "\n".join(lines)


def _line(row: Parameter) -> str:
    default = "computed" if row.default is None else f"`{json.dumps(row.default)}`"
    live = "" if row.read_only else "yes"
    cells = (f"`{row.name}`", default, row.allowed, live, row.description)
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    print(page())
