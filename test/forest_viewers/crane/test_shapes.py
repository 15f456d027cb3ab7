"""What is drawn beside the crane lies where the crane and its limits are."""

import math

import pytest

from forest_control.config.workspace_file import load_workspace
from forest_control.limits.workspace import BOX, CYLINDER, PLANE, Wall, Workspace, clearance
from forest_description.derived.limits import joint_limits, workspace_limits
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_viewers.crane.shapes import LINE, THIN, scene_shapes, trail_shapes
from forest_viewers.crane.trail import Point, Trail

C180 = load_machine("c180_hoses")


WALLS = load_workspace("c180")


def shapes(namespace, workspace=WALLS):
    return [shape for shape in scene_shapes(C180, workspace) if shape.namespace == namespace]


def test_the_work_area_is_as_wide_and_high_as_the_limits_and_closed():
    outline, arc = shapes("work_area")
    limits, (swing, _, _) = workspace_limits(C180), joint_limits(C180)
    heights = [z for _, _, z in outline.points]
    assert max(math.hypot(x, y) for x, y, _ in outline.points) == pytest.approx(limits.reach_max, abs=0.02)
    assert min(heights) == pytest.approx(limits.height_min, abs=0.02)
    assert max(heights) == pytest.approx(limits.height_max, abs=0.02)
    assert outline.points[0] == pytest.approx(outline.points[-1])
    assert max(math.dist(a, b) for a, b in zip(outline.points, outline.points[1:], strict=False)) < 0.6
    x, y, _ = arc.points[-1]
    assert math.atan2(y, x) == pytest.approx(math.remainder(swing[1], 2.0 * math.pi))


@pytest.mark.parametrize(
    "wall",
    [
        Wall(BOX, (-2.0, -1.0, 0.0), (-1.0, 1.0, 3.0), 0.0),
        Wall(CYLINDER, (1.0, 2.0, -1.0), (0.0, 0.0, 2.0), 0.5),
        Wall(PLANE, (0.0, 0.0, 1.0), ZERO, -2.0),
        Wall(PLANE, (-1.0, 0.0, 0.0), ZERO, -4.0),
    ],
    ids=["box", "cylinder", "ground", "side"],
)
def test_a_wall_is_drawn_where_the_tip_stops(wall):
    (shape,) = shapes("walls", Workspace((wall,), 1.0, 1))
    for axis in range(3):
        if shape.size[axis] > 10.0:  # across an endless plane
            continue
        for side in (-0.5, 0.5):
            place = list(shape.centre)
            place[axis] += side * shape.size[axis]
            assert clearance(tuple(place), wall).distance == pytest.approx(0.0, abs=THIN)


def test_a_trail_of_one_point_is_no_line():
    points = (Point(0.0, ZERO), Point(1.0, (1.0, 0.0, 0.0)))
    (line,) = trail_shapes(Trail(points, points[:1]))
    assert (line.namespace, line.kind, line.points) == ("tip", LINE, (ZERO, (1.0, 0.0, 0.0)))
