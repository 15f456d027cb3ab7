"""Segments are changed, moved and deleted; what is not allowed is refused as in a file."""

import pytest

from forest_control.config.setting_file import SettingFileError
from forest_control.taught.cycle import Cycle, Grapple, Pose
from forest_control.taught.editing import changed, moved, without

GO, TAKE = Pose("go", (5.0, 0.5, 1.0), 0.3), Grapple("take", "close", 2.0)
LOAD = Cycle("load", (GO, TAKE), "Logs: from the left")


def test_a_segment_gets_other_values_and_keeps_the_rest():
    assert changed(LOAD, "go", {"name": "out", "speed": 0.4}) == LOAD._replace(
        segments=(Pose("out", (5.0, 0.5, 1.0), 0.4), TAKE)
    )
    assert changed(LOAD, "take", {"wait": "confirmation"}).segments[1].wait == 0.0


@pytest.mark.parametrize(
    ("segment", "changes", "sentence"),
    [
        ("home", {}, "no segment 'home'; allowed: go, take"),
        ("go", {"speed": 99}, "segment 'go': speed is 99; allowed: 0.02 .. 3 m/s"),
        ("go", {"speed": "fast"}, "speed is 'fast'"),
        ("go", {"wait": 1}, "unknown key 'wait'"),
        ("go", {"name": " take "}, "two segments are named 'take'"),
        ("go", {"name": "\x07"}, "name is '.x07'; allowed: a text"),
        ("go", {"name": 3}, "name is 3; allowed: a text"),
        ("take", {"wait": -1}, "wait is -1"),
        ("take", {"path": []}, "allowed: a mapping with one of pose, path, grapple"),
    ],
)
def test_what_is_not_allowed_is_refused(segment, changes, sentence):
    with pytest.raises(SettingFileError, match=f"cycle 'load': .*{sentence}"):
        changed(LOAD, segment, changes)


def test_a_segment_moves_as_far_as_there_are_places():
    assert moved(LOAD, "take", -1).segments == (TAKE, GO)
    assert moved(LOAD, "take", -5).segments == (TAKE, GO)
    assert moved(LOAD, "go", 9).segments == (TAKE, GO)
    assert moved(LOAD, "go", -1) == LOAD


def test_a_segment_is_deleted_also_the_last_one():
    assert without(without(LOAD, "go"), "take").segments == ()
