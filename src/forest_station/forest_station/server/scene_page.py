"""The scene of the live crane, with the walls that its controller keeps."""

from collections.abc import Callable
from typing import Any

from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace
from forest_control.limits.workspace import OPEN
from forest_description.machine import Machine
from forest_station.scene.elements import Scene
from forest_station.scene.scene_description import TIP_SPEED, scene_of


def current_scene(machine: Machine, setting: Callable[[str, str], Any], warn: Callable[[str], None]) -> Scene:
    """Return the scene of a machine as its controller is set.

    Args:
        machine: That is drawn.
        setting: Gives a node's parameter, None if nobody knows it.
        warn: Is told when the controller's workspace cannot be read here: no walls are drawn then.
    """
    try:
        workspace = load_workspace(setting("controller", "workspace") or "")
    except SettingFileError as error:
        workspace = OPEN
        warn(f"The controller keeps walls that cannot be drawn here: {error}")
    return scene_of(machine, workspace, setting("controller", "tip_speed") or TIP_SPEED)
