"""`forest-study track --through-ros`: the nodes over DDS give the figures of the loop without ROS."""

import json

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("llvmlite")

from forest_control.joystick_bag import read_joy_record
from forest_control.position_source import Source
from forest_control.schemes import Scheme
from forest_description.machine import load_machine
from forest_msgs_py import topics
from forest_msgs_py.series import read_bag
from forest_study import cli, graph, track_ros
from forest_study.paths import path_named
from forest_study.track import noisy, track

WAY = "x,y,z\n5.5,0,1\n5.51,0.01,1.01\n"
MACHINE, MODEL = load_machine("c180"), load_machine("c180_thesis")
SEED, SPEED = 5, 0.3
OPTIONS = ("--model", "c180_thesis", "--speed", str(SPEED), "--scheme", "jacobian_velocity")


def alone(
    path,
    seed=SEED,
    static=False,
    adapt=True,
    model=MODEL,
    scheme=Scheme.JACOBIAN_VELOCITY,
    source=Source.CYLINDERS,
):
    suite = noisy(MACHINE, seed, static)
    return track(path, SPEED, scheme, MACHINE, model, suite, laps=2, adapt=adapt, source=source).moved


def test_the_nodes_give_the_figures_of_the_loop_without_ros_and_no_option_is_lost(
    tmp_path, own_domain, capsys
):
    way, out = tmp_path / "way.csv", tmp_path / "out"
    way.write_text(WAY)
    more = ("--noise", "--seed", str(SEED), "--adapt", "--laps", "2", "--through-ros")
    assert cli.main(["track", "--path", str(way), *OPTIONS, *more, "--out", str(out)]) == 0
    assert "the figures are the same" in capsys.readouterr().out
    (run,) = json.loads((out / "track.json").read_text())["runs"]
    assert run["same"]
    assert len(run["laps"]) == 2
    for name in ("rms_mm", "max_mm", "velocity_rms"):
        assert run[name] == pytest.approx(run["without_ros"][name], rel=0, abs=1e-9)
    path, bag = path_named(str(way)), read_bag(out / f"way-seed{SEED}" / "bag")
    moved = alone(path)
    told = track_ros.trajectory(bag, len(moved.time))
    assert np.abs(told.tip - moved.tip).max() < 1e-12
    assert np.array_equal(bag.series(topics.GROUND_TRUTH_TIP_POSE).values, told.tip)
    others = ({"seed": SEED + 1}, {"static": True}, {"adapt": False}, {"model": MACHINE})
    for other in (*others, {"scheme": Scheme.COORDINATED}):
        assert np.abs(alone(path, **other).voltages - told.voltages).max() > 1e-3, other
    by_joints = alone(path, source=Source.JOINTS)  # some hundredths of a milliradian elsewhere
    assert np.abs(by_joints.voltages - told.voltages).max() > 1e-6


def test_the_controller_is_told_its_source(tmp_path):
    settings = track_ros.GraphSettings("c180", "c180", "joint", "joints", SPEED, False, False, False, 0)
    nodes = track_ros._nodes(settings, (5.5, 0.0, 1.0), tmp_path)
    told = set(graph.parameter("position_source", "joints"))
    assert [told <= set(node.arguments) for node in nodes].count(True) == 1


def test_the_joysticks_bag_holds_a_message_for_every_period(tmp_path):
    levers = np.array([[0.1 * k, 0.0, -0.3, k < 2] for k in range(3)])
    track_ros.write_joystick(tmp_path / "joystick", levers)
    record = read_joy_record(tmp_path / "joystick")
    assert record.times_ns == (0, 5_000_000, 10_000_000)
    series = read_bag(tmp_path / "joystick").series(topics.JOY)
    assert series.column("left_x") == pytest.approx([0.0, 0.1, 0.2])
    assert series.column("button_left_shoulder").tolist() == [1.0, 1.0, 0.0]


def test_steps_that_the_bag_lacks_are_told(tmp_path):
    track_ros.write_joystick(tmp_path / "joystick", np.zeros((1, 4)))
    with pytest.raises(track_ros.Failure, match="lacks steps of the machine"):
        track_ros.trajectory(read_bag(tmp_path / "joystick"), 1)
