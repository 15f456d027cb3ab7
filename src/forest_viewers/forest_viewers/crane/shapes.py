"""What is drawn beside the crane: trails, the work area, the walls.

Each shape stands in a frame of the URDF and in a namespace, which a viewer can hide by itself.
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.limits.workspace import BOX, CYLINDER, Wall, Workspace
from forest_description.derived.limits import Interval, joint_limits, workspace_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_viewers.crane.trail import Trail

LINE, CUBE, CYLINDER_SHAPE = 4, 1, 3  # [1] as in visualization_msgs/Marker
BASE, TURNING = "base_link", "platform"
TRAIL_LIFETIME, SCENE_LIFETIME = 1.0, 5.0  # [s] after which a viewer drops what nobody renews
THIN = 0.02  # [m] of lines and plane walls
WIDE = 20.0  # [m] of a plane wall: beyond any crane's reach
CORNERS = 49  # points of an arc
Color = tuple[float, float, float, float]
TIP_COLOR: Color = (0.10, 0.55, 0.95, 1.0)
COMMAND_COLOR: Color = (0.95, 0.55, 0.10, 1.0)
AREA_COLOR: Color = (0.30, 0.70, 0.30, 0.8)
WALL_COLOR: Color = (0.80, 0.20, 0.20, 0.25)


class Shape(NamedTuple):
    """One marker: a line through `points`, or a body of `size` at `centre` [m]."""

    namespace: str
    number: int
    kind: int
    frame: str
    color: Color
    lifetime: float  # [s]
    size: Vec3
    centre: Vec3 = (0.0, 0.0, 0.0)
    points: tuple[Vec3, ...] = ()


def trail_shapes(trail: Trail) -> list[Shape]:
    """Return the lines of tip and command; one without two points is left out."""
    lines = (("tip", trail.tip, TIP_COLOR), ("command", trail.command, COMMAND_COLOR))
    return [
        Shape(
            name,
            0,
            LINE,
            BASE,
            color,
            TRAIL_LIFETIME,
            (THIN, 0.0, 0.0),
            points=tuple(p.place for p in points),
        )
        for name, points, color in lines
        if len(points) > 1
    ]


def scene_shapes(machine: Machine, workspace: Workspace) -> list[Shape]:
    """Return work area and walls."""
    walls = [_wall(number, wall) for number, wall in enumerate(workspace.walls[: workspace.number])]
    return [*_work_area(machine), *walls]


def _work_area(machine: Machine) -> list[Shape]:
    """Return the reach: its outline in the crane's plane, which turns with it, and the widest arc."""
    swing, boom, stick = joint_limits(machine)
    ends = (boom, stick)
    outline: list[Vec3] = []
    for moved, at, back in ((0, 1, False), (1, 1, True), (0, 0, True), (1, 0, False)):
        # boom up with the stick stretched, stick folded, boom down, stick stretched again
        for angle in _steps(ends[moved], back):
            other = ends[1 - moved][at]
            pose = (0.0, angle, other) if moved == 0 else (0.0, other, angle)
            outline.append(tip_position(pose, machine.manipulator.links))
    reach = workspace_limits(machine).reach_max
    arc = tuple((reach * math.cos(q), reach * math.sin(q), 0.0) for q in _steps(swing, False))
    line = (THIN, 0.0, 0.0)
    return [
        Shape("work_area", 0, LINE, TURNING, AREA_COLOR, SCENE_LIFETIME, line, points=tuple(outline)),
        Shape("work_area", 1, LINE, BASE, AREA_COLOR, SCENE_LIFETIME, line, points=arc),
    ]


def _steps(interval: Interval, back: bool) -> list[float]:
    found: list[float] = np.linspace(*interval, CORNERS).tolist()
    return found[::-1] if back else found


def _wall(number: int, wall: Wall) -> Shape:
    """Return a wall where the tip stops: its margin is in it."""
    kind = CUBE
    if wall.kind == BOX:
        size = _vector(wall.second, wall.first, -1.0)
        centre = _vector(wall.first, size, 0.5)
    elif wall.kind == CYLINDER:
        bottom, top = wall.first[2], wall.second[2]
        kind, size = CYLINDER_SHAPE, (2.0 * wall.radius, 2.0 * wall.radius, top - bottom)
        centre = (wall.first[0], wall.first[1], 0.5 * (bottom + top))
    else:
        x, y, z = (THIN if component else WIDE for component in wall.first)  # all are across an axis
        size = x, y, z
        centre = _vector((0.0, 0.0, 0.0), wall.first, wall.radius)
    return Shape("walls", number, kind, BASE, WALL_COLOR, SCENE_LIFETIME, size, centre)


def _vector(a: Vec3, b: Vec3, factor: float) -> Vec3:
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]
