"""The walls of the controller's workspace file, as the page draws them."""

from forest_control.limits.workspace import BOX, CYLINDER, PLANE, Wall, Workspace
from forest_station.scene.scene_elements import BoxWall, CylinderWall, DrawnWall, PlaneWall


def drawn_walls(workspace: Workspace, names: tuple[str, ...] = ()) -> list[DrawnWall]:
    """Return the walls in the file's order, with the margin that the tip keeps.

    Args:
        workspace: with the walls.
        names: of boxes, then of cylinders; "": it is called by its number.
    """
    walls = workspace.walls[: workspace.number]
    planes = sum(wall.kind == PLANE for wall in walls)  # they come first
    called = ("",) * planes + names + ("",) * len(walls)
    return [
        _drawn(wall, number, name) for number, (wall, name) in enumerate(zip(walls, called, strict=False), 1)
    ]


def _drawn(wall: Wall, number: int, name: str) -> DrawnWall:
    first, second = list(wall.first), list(wall.second)
    if wall.kind == PLANE:
        return PlaneWall(kind="plane", name=_side(wall), normal=first, offset=wall.radius)
    if wall.kind == BOX:
        return BoxWall(kind="box", name=name or f"box {number}", lower=first, upper=second)
    assert wall.kind == CYLINDER
    return CylinderWall(
        kind="cylinder",
        name=name or f"cylinder {number}",
        centre=first[:2],
        radius=wall.radius,
        bottom=first[2],
        top=second[2],
    )


def _side(wall: Wall) -> str:
    """Return what a person calls a plane, by where it keeps the tip from."""
    upwards = wall.first[2]
    if upwards == 0.0:
        return "side"
    return "ground" if upwards > 0.0 else "ceiling"
