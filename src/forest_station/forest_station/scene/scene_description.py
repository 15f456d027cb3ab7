"""What the page draws: a machine, or any robot description, also one that was recorded."""

from forest_control.config.workspace_file import NOTHING_TOLD, Told
from forest_control.limits.workspace import OPEN, Workspace
from forest_description.machine import Machine
from forest_description.urdf.robot_description import robot_description
from forest_station.scene.drawn_walls import drawn_walls
from forest_station.scene.hoses import hoses_of
from forest_station.scene.scene_elements import Scene
from forest_station.scene.surroundings import surroundings
from forest_station.scene.urdf_tree import joints_of, links_of, robot_of
from forest_station.scene.work_area import work_area

PILLAR = 0.28
"""Assumed height of the boom's pivot over the ground where nobody tells it, per reach: 2.2 m of a C-180."""
TIP_SPEED = 0.5
"""Assumed greatest speed of the tip [m/s]: how far from a wall it begins to brake."""


def scene_of(
    machine: Machine, workspace: Workspace = OPEN, tip_speed: float = TIP_SPEED, told: Told = NOTHING_TOLD
) -> Scene:
    """Return the scene of a machine; arguments as `scene_from_urdf`."""
    scene = scene_from_urdf(robot_description(machine), workspace, tip_speed, told)
    if (chart := machine.capacity) is not None:
        scene["capacity"] = [list(point) for point in zip(chart.reach, chart.load, strict=True)]
    return scene


def scene_from_urdf(
    text: str, workspace: Workspace = OPEN, tip_speed: float = TIP_SPEED, told: Told = NOTHING_TOLD
) -> Scene:
    """Return the scene of a robot description.

    Args:
        text: URDF with the joints swing, boom and stick and a link tip.
        workspace: Walls of the controller, as `forest_control.config.workspace_file` reads them.
        tip_speed: Greatest speed of the tip [m/s]; with the workspace's approach it tells where
            the tip begins to brake before a wall.
        told: Height of the ground, and what walls are called. A wall before the ground lies higher,
            by its margin.

    Raises:
        SceneError: The text is no such URDF.
    """
    robot = robot_of(text)
    links, joints = links_of(robot), joints_of(robot)
    reach = max(r for r, _ in work_area(joints, 0.0)["section"])
    ground = -PILLAR * reach if told.ground is None else told.ground
    return Scene(
        machine=robot.get("name", ""),
        links=links,
        joints=joints,
        hoses=hoses_of(links, joints),
        ground=ground,
        walls=drawn_walls(workspace, told.names),
        slow_zone=tip_speed / workspace.approach,
        work_area=work_area(joints, ground),
        capacity=[],
        surroundings=surroundings(reach, ground),
    )
