"""A workspace file: ground, boxes and cylinders that the tip keeps out of, in metres in the base frame.

    ground: -1.6                                   # height of the ground, the boom's pivot is at 0
    stay_inside: {lower: [..], upper: [..]}        # a box that the tip does not leave
    boxes: [{lower: [x, y, z], upper: [x, y, z]}]  # that it keeps out of
    cylinders: [{centre: [x, y], radius: 0.9, lower: -1.6, upper: 1.5}]
    margin: 0.1                                    # kept from all of them
    approach: 4                                    # 1/s, allowed speed per distance

Every key may be absent. A box or a cylinder may have a `name`. Beside each number stands its source.
"""

from typing import Any, NamedTuple

from forest_control.config.setting_file import SettingFileError, is_number, shipped_in, shown, tree_of
from forest_control.limits.workspace import BOX, CYLINDER, MOST, NO_WALL, OPEN, PLANE, Wall, Workspace

KEYS = ("ground", "stay_inside", "boxes", "cylinders", "margin", "approach", "description")
FARTHEST = 1000.0  # [m] of a coordinate: a number beyond has another unit
WIDEST_MARGIN = 10.0  # [m] of the margin: a number beyond has another unit
APPROACH = 4.0  # [1/s] allowed speed per distance to a wall where a file names none; chosen
LEAST_APPROACH = 0.1  # [1/s] smallest of a file, as of the setting `approach`; chosen
MOST_APPROACH = 20.0  # [1/s] greatest of a file, as of the setting `approach`; chosen
LONGEST_NAME = 30  # [1] characters of a box's or cylinder's name: it stands beside the tip
LEAST_RADIUS = 0.001  # [m] of a cylinder: a smaller one is no obstacle


def shipped() -> tuple[str, ...]:
    """Return the names of the shipped workspaces."""
    return shipped_in("workspaces")


def load_workspace(name: str) -> Workspace:
    """Return a workspace: none for "", a shipped one by its name, or that of a file.

    Raises:
        SettingFileError: no such workspace, or something in it is not allowed.
    """
    if not name:
        return OPEN
    return _Reader(name).workspace(tree_of("workspace", name, "workspaces"))


class Told(NamedTuple):
    """What a workspace tells people."""

    ground: float | None = None  # height of the ground, without its margin [m]
    names: tuple[str, ...] = ()  # of boxes, then of cylinders; "": it has none


NOTHING_TOLD = Told()


def told(name: str) -> Told:
    """Return what a workspace tells people.

    Raises:
        SettingFileError: as `load_workspace`.
    """
    if not name:
        return NOTHING_TOLD
    reader, tree = _Reader(name), tree_of("workspace", name, "workspaces")
    reader.workspace(tree)  # refuses what is not allowed
    bodies = (*tree.get("boxes", ()), *tree.get("cylinders", ()))
    return Told(reader.ground(tree), tuple(reader.named(body, "name") for body in bodies))


class _Reader:
    """Takes a file's tree apart; every complaint names the file."""

    def __init__(self, name: str) -> None:
        self._name = name

    def workspace(self, tree: Any) -> Workspace:
        self._keys(tree, KEYS, "")
        margin = self._number(tree.get("margin", 0.0), "margin", 0.0, WIDEST_MARGIN)
        approach = self._number(
            tree.get("approach", APPROACH), "approach", LEAST_APPROACH, MOST_APPROACH, "1/s"
        )
        walls = []
        if (ground := self.ground(tree)) is not None:
            walls.append(Wall(PLANE, (0.0, 0.0, 1.0), (0.0,) * 3, ground + margin))
        if "stay_inside" in tree:
            walls += self._inside(tree["stay_inside"], margin)
        for i, box in enumerate(self._list(tree.get("boxes", []), "boxes")):
            walls.append(self._box(box, f"boxes[{i}]", margin))
        for i, cylinder in enumerate(self._list(tree.get("cylinders", []), "cylinders")):
            walls.append(self._cylinder(cylinder, f"cylinders[{i}]", margin))
        if len(walls) > MOST:
            self._refuse(f"{len(walls)} walls; allowed: up to {MOST} (stay_inside counts as 6)")
        return Workspace((*walls, *(NO_WALL,) * (MOST - len(walls))), approach, len(walls))

    def named(self, tree: Any, key: str) -> str:
        name = tree.get("name", "")
        if not isinstance(name, str) or len(name) > LONGEST_NAME:
            self._refuse(f"{key} is {shown(name)}; allowed: a text of at most {LONGEST_NAME} characters")
        return str(name)

    def ground(self, tree: Any) -> float | None:
        return self._number(tree["ground"], "ground") if "ground" in tree else None

    def _inside(self, tree: Any, margin: float) -> list[Wall]:
        low, high = self._corners(tree, "stay_inside")
        walls = []
        for i in range(3):
            normal = (float(i == 0), float(i == 1), float(i == 2))
            back = (-normal[0], -normal[1], -normal[2])
            walls.append(Wall(PLANE, normal, (0.0,) * 3, low[i] + margin))
            walls.append(Wall(PLANE, back, (0.0,) * 3, margin - high[i]))
            if low[i] + margin >= high[i] - margin:
                self._refuse(f"stay_inside: nothing is left between {low[i]:g} and {high[i]:g} m")
        return walls

    def _box(self, tree: Any, key: str, margin: float) -> Wall:
        low, high = self._corners(tree, key, ("name",))
        self.named(tree, f"{key}.name")
        first = low[0] - margin, low[1] - margin, low[2] - margin
        return Wall(BOX, first, (high[0] + margin, high[1] + margin, high[2] + margin), 0.0)

    def _corners(
        self, tree: Any, key: str, optional: tuple[str, ...] = ()
    ) -> tuple[list[float], list[float]]:
        self._keys(tree, optional, key, ("lower", "upper"))
        low, high = (self._point(tree[corner], f"{key}.{corner}", 3) for corner in ("lower", "upper"))
        if not all(a < b for a, b in zip(low, high, strict=True)):
            self._refuse(f"{key}: lower {low} is not below upper {high}; allowed: below in every coordinate")
        return low, high

    def _cylinder(self, tree: Any, key: str, margin: float) -> Wall:
        self._keys(tree, ("name",), key, ("centre", "radius", "lower", "upper"))
        self.named(tree, f"{key}.name")
        x, y = self._point(tree["centre"], f"{key}.centre", 2)
        radius = self._number(tree["radius"], f"{key}.radius", LEAST_RADIUS)
        low, high = (self._number(tree[end], f"{key}.{end}") for end in ("lower", "upper"))
        if not low < high:
            self._refuse(f"{key}: lower {low:g} is not below upper {high:g}")
        return Wall(CYLINDER, (x, y, low - margin), (0.0, 0.0, high + margin), radius + margin)

    def _keys(self, tree: Any, optional: tuple[str, ...], key: str, needed: tuple[str, ...] = ()) -> None:
        allowed = (*needed, *optional)
        where = f"{key}: " if key else ""
        if not isinstance(tree, dict):
            self._refuse(f"{where}{shown(tree)}; allowed: a mapping of {', '.join(allowed)}")
        unknown = [name for name in tree if name not in allowed]
        missing = [name for name in needed if name not in tree]
        if unknown or missing:
            what = f"unknown key {shown(unknown[0])}" if unknown else f"no {missing[0]}"
            self._refuse(f"{where}{what}; allowed: {', '.join(allowed)}")

    def _list(self, tree: Any, key: str) -> list[Any]:
        if not isinstance(tree, list):
            self._refuse(f"{key}: {shown(tree)}; allowed: a list")
        return list(tree)

    def _point(self, tree: Any, key: str, size: int) -> list[float]:
        if not isinstance(tree, list) or len(tree) != size:
            self._refuse(f"{key} is {shown(tree)}; allowed: {size} numbers in m")
        return [self._number(number, key) for number in tree]

    def _number(
        self, value: Any, key: str, low: float = -FARTHEST, high: float = FARTHEST, unit: str = "m"
    ) -> float:
        if not is_number(value, low, high):
            self._refuse(f"{key} is {shown(value)}; allowed: {low:g} .. {high:g} {unit}")
        return float(value)

    def _refuse(self, problem: str) -> None:
        raise SettingFileError(f"workspace {self._name!r}: {problem}")
