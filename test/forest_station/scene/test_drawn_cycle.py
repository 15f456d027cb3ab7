"""What the page shows of a cycle: words, and a line that follows the plan."""

import math
from itertools import pairwise
from pathlib import Path

import pytest

from forest_control.taught.cycle import Cycle, Pose
from forest_control.taught.cycle_file import load_cycle
from forest_description.derived.limits import start_tip
from forest_description.machine import load_machine
from forest_station.scene.drawn_cycle import MOST, drawn_cycle

C180, NOWHERE = load_machine("c180_hoses"), Path("none")


def test_a_shipped_cycle_is_told_in_words_and_drawn_from_its_first_place():
    shown = drawn_cycle(load_cycle("reach-grasp", NOWHERE), C180, "c180")
    assert shown["trouble"] == ""
    kinds = [segment["kind"] for segment in shown["segments"]]
    assert kinds == ["path", "grapple", "path", "grapple", "pose"]
    assert shown["segments"][1]["text"] == "grapple close, until confirmed"
    assert shown["segments"][0]["text"] == "2.77 m, 10 s"
    line = shown["line"]
    assert line[0] == pytest.approx([5.0, 0.0, 0.8])
    assert line[-1] == pytest.approx(shown["segments"][-1]["end"])
    assert max(math.dist(a, b) for a, b in pairwise(line)) <= 0.02
    assert len(line) < MOST


def test_where_a_first_pose_is_reached_from_is_not_drawn():
    poses = Cycle("poses", (Pose("a", (5.0, 0.5, 1.0), 0.3), Pose("b", (5.0, -0.5, 1.0), 0.3)))
    line = drawn_cycle(poses, C180, "")["line"]
    assert line[0] == pytest.approx([5.0, 0.5, 1.0])
    assert drawn_cycle(poses._replace(segments=poses.segments[:1]), C180, "")["line"] == []


def test_a_single_pose_at_which_the_tip_stands_is_no_trouble():
    shown = drawn_cycle(Cycle("home", (Pose("here", start_tip(C180), 0.3),)), C180, "")
    assert shown["trouble"] == shown["segments"][0]["text"] == ""


def test_what_cannot_be_played_is_shown_with_the_reason():
    far = Cycle("far", (Pose("away", (50.0, 0.0, 1.0), 0.3),))
    shown = drawn_cycle(far, C180, "")
    assert "Segment 'away':" in shown["trouble"]
    assert shown["line"] == []
    assert shown["segments"][0]["text"] == ""
    assert "no segment" in drawn_cycle(Cycle("new"), C180, "")["trouble"]
    assert "neither shipped" in drawn_cycle(far, C180, "no walls")["trouble"]
