"""Claims about whose profile a joystick source is played to."""

import argparse
import shutil
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from forest_bringup import graph
from forest_bringup.profile_choice import profile_for, recorded_profile
from forest_control.config.profile_file import KEYS, load_profile

COORDINATED = Path(__file__).resolve().parents[2] / "bags" / "coordinated"


def option(*words):
    parser = argparse.ArgumentParser()
    graph.add_graph_options(parser)
    return parser.parse_args(words).profile


def test_the_thesis_levers_are_exact_a_persons_are_not(tmp_path):
    assert profile_for("thesis", None) == {"profile": "exact"}
    assert profile_for(str(tmp_path / "levers.csv"), None) == {}  # the controller's default
    assert profile_for(None, None) == {}
    assert profile_for("thesis", "operator") == {"profile": "operator"}


def test_a_bags_joystick_is_played_to_the_profile_that_was_recorded():
    told = profile_for(str(COORDINATED), None)
    exact = {
        key: list(value) if isinstance(value, tuple) else value
        for key, value in load_profile("exact").items()
    }
    assert told == exact
    assert set(told) == set(KEYS)
    assert profile_for(str(COORDINATED), "fine") == {"profile": "fine"}


def test_a_bag_that_tells_no_parameters_is_played_to_the_default(tmp_path):
    assert recorded_profile(tmp_path / "none") == {}
    bag = tmp_path / "cut"
    shutil.copytree(COORDINATED, bag)
    whole = next(bag.glob("*.mcap")).read_bytes()
    next(bag.glob("*.mcap")).write_bytes(
        whole.replace(b"parameters/controller.yaml", b"parameters/controllor.yaml")
    )
    assert recorded_profile(bag) == {}
    next(bag.glob("*.mcap")).write_bytes(
        whole.replace(b"/controller:\n  ros__parameters:", b"[controller:\n  ros__parameters:")
    )
    assert recorded_profile(bag) == {}


def test_the_controller_is_told():
    controller, driver = graph.control("c180", "joint", False, False, profile_for("thesis", None))
    assert 'profile:="exact"' in controller.arguments
    assert not any("profile" in word for word in driver.arguments)


def test_a_profile_is_a_shipped_one_or_a_file_else_it_is_named_in_one_sentence(tmp_path, monkeypatch, capsys):
    (tmp_path / "mine.yaml").write_text("tip_speed: 1\n")
    (tmp_path / "wrong.yaml").write_text("tip_speed: 99\n")
    monkeypatch.chdir(tmp_path)
    assert option() is None
    assert option("--profile", "fine") == "fine"
    assert option("--profile", "mine.yaml") == str(tmp_path / "mine.yaml")
    for wrong, said in (("nobody", "neither shipped"), ("wrong.yaml", "tip_speed is 99; allowed")):
        with pytest.raises(SystemExit):
            option("--profile", wrong)
        assert said in capsys.readouterr().err.splitlines()[-1]
