"""Editing a cycle segment by segment; what a person types is checked as its file would be."""

from collections.abc import Callable, Mapping
from typing import Any

from forest_control.config.setting_file import SettingFileError
from forest_control.taught.cycle import Cycle
from forest_control.taught.cycle_file import cycle_of, text_of
from forest_msgs_py.interfaces.yaml_text import parsed

Tree = list[dict[str, Any]]  # the segments of a file


def changed(taught: Cycle, segment: str, changes: Mapping[str, Any]) -> Cycle:
    """Return a cycle of which a segment's keys have other values, as its file would have them.

    Raises:
        SettingFileError: there is no such segment, or a value is not allowed.
    """

    def change(tree: Tree, at: int) -> None:
        tree[at] |= changes

    return _edited(taught, segment, change)


def without(taught: Cycle, segment: str) -> Cycle:
    """Return a cycle without a segment.

    Raises:
        SettingFileError: there is no such segment.
    """

    def delete(tree: Tree, at: int) -> None:
        del tree[at]

    return _edited(taught, segment, delete)


def moved(taught: Cycle, segment: str, by: int) -> Cycle:
    """Return a cycle in which a segment stands some places later, or earlier; at the ends it stays.

    Raises:
        SettingFileError: there is no such segment.
    """

    def move(tree: Tree, at: int) -> None:
        tree.insert(max(0, at + by), tree.pop(at))

    return _edited(taught, segment, move)


def _edited(taught: Cycle, segment: str, edit: Callable[[Tree, int], None]) -> Cycle:
    names = [one.name for one in taught.segments]
    if segment not in names:
        raise SettingFileError(
            f"cycle {taught.name!r}: no segment {segment!r}; allowed: {', '.join(names) or 'none'}"
        )
    tree = parsed(text_of(taught))
    edit(tree["segments"], names.index(segment))
    return cycle_of(taught.name, tree)
