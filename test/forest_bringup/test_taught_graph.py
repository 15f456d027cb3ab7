"""Programs beside the live graph: they teach, and they move the tip while a person holds the deadman."""

import contextlib
import math
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from page_examples import examples

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Duration
from peer import Peer
from trajectory_msgs.msg import JointTrajectoryPoint

from forest_control.cli.main import main
from forest_control.taught.cycle_file import load_cycle
from forest_control.taught.player import Phase
from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import read_float_array

PAGES = Path(__file__).resolve().parents[2] / "docs" / "how-to"
TEACHING, DRIVING = PAGES / "teach-a-cycle.md", PAGES / "drive-from-a-program.md"
STARTED_S = 90.0  # at which the test fails rather than hangs; on a busy machine a graph starts slowly
HELD_S = 600.0  # longer than the test
CRANE = load_machine("c180_hoses")  # c180 ends as far from a place as its swing's gear has play


@pytest.fixture
def peer(ros_context, wait_until):
    one = Peer(ros_context, wait_until)
    yield one
    one.close()


def programs(page):
    return [one.text for one in examples(page) if one.kind == "python"]


@contextlib.contextmanager
def program(text):
    """A page's program runs meanwhile, and ends well."""
    with subprocess.Popen([sys.executable, "-c", text]) as process:
        try:
            yield
            assert process.wait(STARTED_S) == 0
        finally:
            process.kill()


@pytest.fixture
def held_joystick(tmp_path):
    """A hand, in a process of its own, that holds the deadman and lets the levers all but alone."""
    levers = tmp_path / "held.csv"
    rows = (f"{0.5 * row},0,0,{1e-3 * (row % 2)}" for row in range(int(2 * HELD_S)))
    levers.write_text("\n".join(("time_s,swing,boom,stick", *rows)))
    return levers


def trajectory(angles, seconds):
    point = JointTrajectoryPoint(positions=angles, time_from_start=Duration(sec=seconds))
    return topics.message_class(topics.JOINT_TRAJECTORY)(joint_names=AXES, points=[point])


def place_of(pose):
    return pose.pose.position.x, pose.pose.position.y, pose.pose.position.z


def is_armed(status):
    return read_float_array(topics.CONTROLLER_STATUS, status, 0, ("armed",)).values == (1.0,)


def is_finished(status):
    return read_float_array(topics.CYCLE_STATUS, status, 0, ("phase",)).values == (Phase.FINISHED,)


def test_programs_teach_and_move_the_tip(start_graph, held_joystick, peer, wait_until, tmp_path, capsys):
    options = ("--cycles", str(tmp_path), "--twist", "--joystick", str(held_joystick))
    graph = start_graph("--machine", CRANE.name, *options)
    _teach(wait_until, tmp_path, capsys)
    tips, twists = peer.hear(topics.TIP_POSE), peer.hear(topics.TIP_TWIST)
    statuses, played = peer.hear(topics.CONTROLLER_STATUS), peer.hear(topics.CYCLE_STATUS)
    peer.until(lambda: statuses and is_armed(statuses[-1]))
    velocity, joint_trajectory, goal = programs(DRIVING)
    with program(velocity):
        peer.until(lambda: twists[-1].twist.linear.y > 0.2)
    peer.until(lambda: abs(twists[-1].twist.linear.y) < 0.02)
    before = place_of(tips[-1])
    swing, boom, stick = pose_at(before, CRANE)
    wanted = tip_position((swing - 0.1, boom, stick), CRANE.manipulator.links)
    with program(joint_trajectory):
        peer.until(lambda: math.dist(wanted, place_of(tips[-1])) < 0.01)
    if find_spec("control_msgs"):  # the ROS wheels have none
        peer.until(lambda: played and is_finished(played[-1]))
        with program(goal):
            peer.until(lambda: math.dist(place_of(tips[-1]), before) < 0.01)
    peer.speak(topics.JOINT_TRAJECTORY).publish(trajectory((math.nan, boom, stick), 2))
    peer.until(lambda: "allowed: 3 finite numbers" in graph.text())
    assert graph.poll() is None, graph.text()


def _teach(wait_until, tmp_path, capsys):
    teach = ["cycle", "record", "home", "--what", "pose", "--label", "here"]
    wait_until(lambda: main(teach) == 0, STARTED_S)
    (pose,) = load_cycle("home", tmp_path).segments
    assert pose.name == "here"
    assert math.dist(pose.tip, start_tip(CRANE)) < 0.05
    assert "home: here is taught" in capsys.readouterr().out
    (teaching,) = programs(TEACHING)
    told = subprocess.run([sys.executable, "-c", teaching], capture_output=True, text=True, check=True)
    assert "homing: drop is taught" in told.stdout
    assert [one.name for one in load_cycle("homing", tmp_path).segments] == ["home", "drop"]
    assert main(["cycle", "resume"]) == 1
    assert "nothing waits for a person" in capsys.readouterr().err
