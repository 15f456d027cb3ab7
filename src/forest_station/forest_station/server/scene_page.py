"""The scene of the live crane, with the walls that its controller keeps."""

from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace
from forest_control.limits.workspace import OPEN
from forest_station.scene.elements import Scene
from forest_station.scene.scene_description import TIP_SPEED, scene_of
from forest_station.server.station import Station


def current_scene(station: Station) -> Scene:
    """Return the scene as the controller is set; a workspace that cannot be read here is told in the log."""
    name = station.setting("controller", "workspace") or ""
    try:
        workspace = load_workspace(name)
    except SettingFileError as error:
        workspace = OPEN
        text = f"The controller keeps walls that cannot be drawn here: {error}"
        station.tell("log", {"node": "station", "level": "warning", "text": text})
    tip_speed = station.setting("controller", "tip_speed") or TIP_SPEED
    return scene_of(station.graph.machine, workspace, tip_speed)
