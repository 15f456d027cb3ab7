"""The file of a cycle: YAML that people read and edit.

    description: Four logs from the left
    segments:
      - name: transport
        pose: [3.6, 0.0, 1.2]      # m: the tip goes there on a straight line
        speed: 0.4                 # m/s
      - name: reach
        path:                      # m: the tip goes from point to point, smoothly but for corners
          - [4.0, 1.0, 0.5]
          - [5.0, 2.0, 0.0]
        speed: 0.5
      - name: grasp
        grapple: close             # or open
        wait: confirmation         # of a person; or a time in s

Places are of the tip, in the base frame. `description` may be absent; of a grapple `wait`, too.
A cycle is shipped with this package, or is the file NAME.yaml in a folder of the user's.
"""

import os
import re
from pathlib import Path
from typing import Any, NoReturn

from forest_control.config.setting_file import SettingFileError, is_number, shipped_in, shown, tree_of
from forest_control.taught import cycle
from forest_control.taught.cycle import ACTIONS, CONFIRMATION, Cycle, Grapple, Pose, Segment
from forest_control.taught.tip_path import PathError, polyline
from forest_description.types import Vec3

FOLDER = "cycles"  # of the shipped ones, in this package
KINDS = {"pose": ("speed",), "path": ("speed",), "grapple": ("wait",)}  # with what belongs to each
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
FARTHEST = 1000.0  # [m] of a coordinate: a number beyond has another unit
SLOWEST = 0.02  # [m/s] of a segment: slower, the tip would not get on
FASTEST = 3.0  # [m/s] of a segment: as the greatest tip_speed
SHORTEST_WAIT, LONGEST_WAIT = 0.1, 600.0  # [s] of a grapple: a time beyond has another unit
SPEED = 0.3  # [m/s] of a segment where the file names none; chosen, not measured
CONFIRMED = "confirmation"
HEAD = "# Places of the tip in m (base frame: x ahead, y left, z up from the boom's pivot), m/s, s.\n"


def names(folder: Path) -> tuple[str, ...]:
    """Return the names of the cycles in a folder, and of the shipped ones that none there hides."""
    own = (path.stem for path in folder.glob("*.yaml") if NAME.fullmatch(path.stem))
    return tuple(sorted({*own, *shipped_in(FOLDER)}))


def checked_name(name: str) -> str:
    """Return a cycle's name.

    Raises:
        SettingFileError: it would be no file's.
    """
    if not NAME.fullmatch(name):
        raise SettingFileError(f"cycle {name!r}: allowed: a name of letters, digits, - and _")
    return name


def file_of(name: str, folder: Path) -> Path:
    """Return where a cycle of the user's is, or would be.

    Raises:
        SettingFileError: the name would be no file's.
    """
    return folder / f"{checked_name(name)}.yaml"


def load_cycle(name: str, folder: Path) -> Cycle:
    """Return a cycle by its name: the user's, or a shipped one.

    Raises:
        SettingFileError: there is none, or something in it is not allowed.
    """
    path = file_of(name, folder)
    if not path.exists() and name not in shipped_in(FOLDER):
        known = ", ".join(names(folder))
        raise SettingFileError(f"cycle {name!r}: there is none in {folder}; allowed: {known}")
    return cycle_of(name, tree_of("cycle", str(path) if path.exists() else name, FOLDER))


def cycle_of(name: str, tree: Any) -> Cycle:
    """Return the cycle that a file's tree tells of.

    Raises:
        SettingFileError: something in it is not allowed.
    """
    return _Reader(name).cycle(tree)


def save_cycle(taught: Cycle, folder: Path) -> Path:
    """Write a cycle's file and return its path; what was there is replaced as a whole or not at all.

    Raises:
        OSError: it cannot be written.
        SettingFileError: the name would be no file's, or what is written could not be read again.
    """
    path = file_of(taught.name, folder)
    folder.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".draft")
    with draft.open("w", encoding="utf-8", errors="backslashreplace") as file:
        file.write(text_of(taught))
        file.flush()
        os.fsync(file.fileno())
    try:
        cycle_of(taught.name, tree_of("cycle", str(draft), FOLDER))
    except SettingFileError:
        draft.unlink()
        raise
    draft.replace(path)
    return path


def text_of(taught: Cycle) -> str:
    """Return the file of a cycle."""
    lines = [HEAD.rstrip("\n")]
    if taught.description:
        lines.append(f"description: {_text(taught.description)}")
    lines.append("segments:" if taught.segments else "segments: []")
    for segment in taught.segments:
        lines.append(f"  - name: {_text(segment.name)}")
        lines += [f"    {line}" for line in _segment_lines(segment)]
    return "\n".join(lines) + "\n"


def _segment_lines(segment: Segment) -> list[str]:
    if isinstance(segment, Grapple):
        wait = CONFIRMED if segment.wait == CONFIRMATION else f"{segment.wait:g}"
        return [f"grapple: {segment.action}", f"wait: {wait}"]
    if isinstance(segment, Pose):
        return [f"pose: {_place(segment.tip)}", f"speed: {segment.speed:g}"]
    return ["path:", *(f"  - {_place(point)}" for point in segment.points), f"speed: {segment.speed:g}"]


def _place(point: Vec3) -> str:
    return f"[{point[0]:.4f}, {point[1]:.4f}, {point[2]:.4f}]"


def _text(words: str) -> str:
    """Return a text as YAML has it in quotes: a colon in it is none of YAML's."""
    return "'" + " ".join(words.split()).replace("'", "''") + "'"


class _Reader:
    """Takes a file's tree apart; every complaint names cycle and segment."""

    def __init__(self, name: str) -> None:
        self._name = name

    def cycle(self, tree: Any) -> Cycle:
        if not isinstance(tree, dict) or not set(tree) <= {"description", "segments"}:
            self._refuse(f"{shown(tree)}; allowed: a mapping of description, segments")
        segments = tree.get("segments")
        if not isinstance(segments, list):
            self._refuse(f"segments: {shown(segments)}; allowed: a list")
        read = tuple(self._segment(one, f"segment {n}") for n, one in enumerate(segments, start=1))
        labels = [one.name for one in read]
        if twice := [label for label in labels if labels.count(label) > 1]:
            self._refuse(f"two segments are named {twice[0]!r}; allowed: a name of its own for each")
        return Cycle(self._name, read, str(tree.get("description", "")))

    def _segment(self, tree: Any, where: str) -> Segment:
        kinds = [kind for kind in KINDS if isinstance(tree, dict) and kind in tree]
        if len(kinds) != 1:
            self._refuse(f"{where}: {shown(tree)}; allowed: a mapping with one of {', '.join(KINDS)}")
        (kind,) = kinds
        name = tree.get("name", where)
        name = " ".join(name.split()) if isinstance(name, str) else ""
        if not name or not name.isprintable():
            self._refuse(f"{where}: name is {shown(tree['name'])}; allowed: a text")
        where = f"segment {name!r}"
        allowed = ("name", kind, *KINDS[kind])
        if unknown := [key for key in tree if key not in allowed]:
            self._refuse(f"{where}: unknown key {shown(unknown[0])}; allowed: {', '.join(allowed)}")
        if kind == "grapple":
            return Grapple(name, self._action(tree[kind], where), self._wait(tree.get("wait"), where))
        speed = self._number(tree.get("speed", SPEED), f"{where}: speed", SLOWEST, FASTEST, "m/s")
        if kind == "pose":
            return Pose(name, self._point(tree[kind], f"{where}: pose"), speed)
        return cycle.Path(name, self._points(tree[kind], where), speed)

    def _points(self, tree: Any, where: str) -> tuple[Vec3, ...]:
        if not isinstance(tree, list):
            self._refuse(f"{where}: path is {shown(tree)}; allowed: a list of points [x, y, z] in m")
        points = [self._point(point, f"{where}: point {n}") for n, point in enumerate(tree, start=1)]
        try:
            polyline(where, points)
        except PathError as error:
            self._refuse(str(error))
        return tuple(points)

    def _point(self, tree: Any, where: str) -> Vec3:
        if not isinstance(tree, list) or len(tree) != 3:
            self._refuse(f"{where} is {shown(tree)}; allowed: three numbers [x, y, z] in m")
        x, y, z = (self._number(number, where, -FARTHEST, FARTHEST, "m") for number in tree)
        return x, y, z

    def _action(self, value: Any, where: str) -> str:
        if value not in ACTIONS:
            self._refuse(f"{where}: grapple is {shown(value)}; allowed: {', '.join(ACTIONS)}")
        return str(value)

    def _wait(self, value: Any, where: str) -> float:
        if value is None or value == CONFIRMED:
            return CONFIRMATION
        if not is_number(value, SHORTEST_WAIT, LONGEST_WAIT):
            bounds = f"{SHORTEST_WAIT:g} .. {LONGEST_WAIT:g} s"
            self._refuse(f"{where}: wait is {shown(value)}; allowed: {CONFIRMED}, or {bounds}")
        return float(value)

    def _number(self, value: Any, where: str, low: float, high: float, unit: str) -> float:
        if not is_number(value, low, high):
            self._refuse(f"{where} is {shown(value)}; allowed: {low:g} .. {high:g} {unit}")
        return float(value)

    def _refuse(self, problem: str) -> NoReturn:
        raise SettingFileError(f"cycle {self._name!r}: {problem}")
