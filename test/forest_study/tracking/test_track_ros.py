"""`forest-study track --through-ros`: the nodes over DDS give the figures of the loop without ROS."""

import json

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("llvmlite")

from forest_bag.read.timeseries import read_bag
from forest_control.operator.joystick_bag import read_joy_record
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import Scheme
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_study import cli
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.tracking import track_command, track_ros
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import noisy, track

WAY = "x,y,z\n5.5,0,1\n5.51,0.01,1.01\n"
MACHINE, MODEL = load_machine("c180_hoses"), load_machine("c180_thesis")
SEED, SPEED = 5, 0.3
SCHEME = Scheme.JACOBIAN_VELOCITY
OPTIONS = (
    *("--machine", MACHINE.name, "--model", "c180_thesis", "--speed", str(SPEED), "--scheme", SCHEME.label),
    *("--position-source", "joints"),
)


def alone(path, seed=SEED, static=False, adapt=True, model=MODEL, scheme=SCHEME, source=Source.JOINTS):
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
    for name in ("governed_rms_mm", "governed_max_mm", "velocity_rms"):
        assert run[name] == pytest.approx(run["without_ros"][name], rel=0, abs=1e-9)
    path, bag = path_named(str(way)), read_bag(out / f"way-seed{SEED}" / "bag")
    moved = alone(path)
    told = track_ros.trajectory(bag, len(moved.time))
    assert np.abs(told.tip - moved.tip).max() < 1e-12
    assert np.array_equal(bag.series(topics.GROUND_TRUTH_TIP_POSE).values[:, :3], told.tip)
    others = ({"seed": SEED + 1}, {"static": True}, {"adapt": False}, {"model": MACHINE})
    for other in (*others, {"scheme": Scheme.COORDINATED}, {"source": Source.CYLINDERS}):
        assert np.abs(alone(path, **other).voltages - told.voltages).max() > 1e-6, other


def test_the_joysticks_bag_holds_a_message_for_every_period(tmp_path):
    levers = np.array([[0.1 * k, 0.0, -0.3, k < 2] for k in range(3)])
    track_ros.write_joystick(tmp_path / "joystick", levers)
    record = read_joy_record(tmp_path / "joystick")
    assert record.times_ns == (0, 5_000_000, 10_000_000)
    series = read_bag(tmp_path / "joystick").series(topics.JOY)
    assert series.column("left_x") == pytest.approx([0.0, 0.1, 0.2])
    assert series.column("button_left_shoulder").tolist() == [1.0, 1.0, 0.0]


def test_drawn_machines_are_refused_in_one_sentence(tmp_path, capsys):
    more = ("--mismatch", "--through-ros", "--out", str(tmp_path / "out"))
    assert cli.main(["track", "--path", "radial", *more]) == 1
    said = capsys.readouterr().err
    assert "--through-ros does not go with --mismatch" in said
    assert said.count("\n") == 1


def test_other_figures_are_a_failure_that_names_the_run():
    one = {"path": "way", "seed": 3, "same": True, "differences": {"tip_m": 0.0}}
    other = {"path": "way", "seed": 4, "same": False, "differences": {"tip_m": 0.002}}
    track_command._judge([one])
    with pytest.raises(track_ros.GraphError, match=r"way, seed 4; the tip is up to 0\.002 m apart"):
        track_command._judge([one, other])


def test_two_runs_differ_by_what_is_farthest_apart_and_readings_of_nothing_are_equal():
    columns = [np.zeros(2), *(np.zeros((2, 3)) for _ in range(5)), np.full((2, 12), np.nan)]
    one = Trajectory(*columns)
    tip = np.array([[0.0, 0.0, 0.0], [0.0, -0.2, 0.1]])
    found = track_ros.differences(one, one._replace(tip=tip))
    assert found.pop("tip_m") == 0.2
    assert set(found.values()) == {0.0}


def test_steps_that_the_bag_lacks_are_told(tmp_path):
    track_ros.write_joystick(tmp_path / "joystick", np.zeros((1, 4)))
    with pytest.raises(track_ros.GraphError, match="lacks steps of the machine"):
        track_ros.trajectory(read_bag(tmp_path / "joystick"), 1)
