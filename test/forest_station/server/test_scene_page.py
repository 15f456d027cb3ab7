"""Claims about the live scene: walls and slow zone follow the controller's settings."""

import pytest

from forest_control.config.workspace_file import load_workspace
from forest_description.machine import load_machine
from forest_station.scene.drawn_walls import drawn_walls
from forest_station.server.scene_page import current_scene

MACHINE = load_machine()


def scene(settings):
    """Return the scene under some settings of the controller, and the warnings."""
    warnings = []
    return current_scene(MACHINE, lambda _node, name: settings.get(name), warnings.append), warnings


def test_walls_and_slow_zone_are_those_of_the_controller():
    drawn, warnings = scene({"workspace": "c180", "tip_speed": 1.0})
    assert drawn["walls"] == drawn_walls(load_workspace("c180"))
    assert drawn["slow_zone"] == pytest.approx(1.0 / load_workspace("c180").approach)
    assert warnings == []


def test_before_the_controller_is_heard_the_crane_is_drawn_without_walls():
    drawn, warnings = scene({})
    assert (drawn["machine"], drawn["walls"], warnings) == ("c180", [], [])


def test_walls_that_cannot_be_read_here_are_told():
    drawn, (warning,) = scene({"workspace": "/nowhere/walls.yaml"})
    assert drawn["walls"] == []
    assert "walls that cannot be drawn here" in warning
    assert "/nowhere/walls.yaml" in warning
