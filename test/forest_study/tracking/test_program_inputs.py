"""Programs move the tip: a joint trajectory and a stream of velocities, in the closed loop without ROS."""

import math

import numpy as np
import pytest

from forest_control.operator.levers import REST, Levers
from forest_control.operator.taught_command import NO_COMMAND
from forest_control.taught.joint_trajectory import TrajectoryRow
from forest_control.taught.player import Phase
from forest_control.taught.taught_work import Seen
from forest_control.taught.twist_follower import NO_WISH, TIMEOUT, Follower, TwistError, Wish, step, wish_of
from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_description.types import AXES, ZERO
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Operator
from forest_study.tracking.taught_loop import TaughtLoop

MACHINE = load_machine("c180_hoses")
START = (5.5, 0.0, 1.0)
POSE = pose_at(START, MACHINE)
HELD, RELEASED = Operator(REST), Operator(REST, enabled=False)


@pytest.fixture
def loop(tmp_path):
    return TaughtLoop(MACHINE, START, tmp_path)


class Program:
    """A program's stream of velocities beside a closed loop, heard as the node hears it."""

    def __init__(self, loop):
        self.loop, self.follower, self.wish = loop, Follower(), NO_WISH
        self.runs = 0

    def period(self, velocity, operator=HELD):
        """Run a period; no velocity: the program is silent."""
        loop, now = self.loop, self.loop.time
        if velocity is not None:
            self.wish = Wish(velocity, now)
        watch = loop.loop.controller.guard.permission.joystick
        centred = max(map(abs, operator.levers)) <= 0.05
        seen = Seen(loop.loop.telemetry.tip, 1.0 + now, watch.armed, centred)
        before = self.follower.run
        self.follower, command = step(self.follower, self.wish, seen, now)
        self.runs += self.follower.run != before
        if command is not None:
            loop.loop.controller.hear_taught(self.follower.run, command, now)
        loop.period(operator)

    def drive(self, velocity, seconds, operator=HELD):
        for _ in range(round(seconds / PERIOD)):
            self.period(velocity, operator)


@pytest.fixture
def program(loop):
    made = Program(loop)
    made.drive(ZERO, 0.3)
    return made


def speed(loop, seconds=0.1):
    """The mean speed of the tip over the last time [m/s]."""
    return math.dist(loop.tips[-1], loop.tips[-1 - round(seconds / PERIOD)]) / seconds


def test_a_joint_trajectory_is_followed_to_its_end_while_the_deadman_is_held(loop):
    loop.drive(HELD, 0.3)
    beside = (POSE[0] + 0.2, POSE[1], POSE[2] + 0.1)
    done, said = loop.work.follow(AXES, [TrajectoryRow(4.0, beside, ())])
    assert done
    assert "4.0 s asked for" in said
    happened = [loop.period(HELD) for _ in range(1600)]
    assert loop.phase == Phase.FINISHED, loop.events
    assert np.allclose(happened[-1].angles, beside, atol=2e-3)
    # Both joints get on together: the pose is on the straight line of the joint angles all the way.
    share = (np.array([one.angles for one in happened]) - POSE) / np.array([0.2, 1.0, 0.1])
    assert np.abs(share[:, 0] - share[:, 2]).max() < 0.03


def test_a_trajectory_is_refused_while_something_is_played_which_a_stop_ends(loop):
    loop.drive(HELD, 0.3)
    row = TrajectoryRow(4.0, (POSE[0] + 0.2, *POSE[1:]), ())
    assert loop.work.follow(AXES, [row])[0]
    loop.drive(HELD, 1.0)
    assert loop.work.follow(AXES, [row]) == (
        False,
        "joint trajectory is under way; allowed: a trajectory after stop",
    )
    assert loop.work.actions["stop"]()[0]
    loop.drive(HELD, 1.5)  # the swing rocks on its hoses for a second
    assert loop.phase == Phase.IDLE
    assert speed(loop) < 0.005


def test_what_is_no_trajectory_is_answered_with_a_sentence(loop):
    loop.drive(HELD, 0.3)
    done, said = loop.work.follow(("swing",), [TrajectoryRow(1.0, (0.0,), ())])
    assert (done, said) == (False, "joint trajectory: joints swing; allowed: swing, boom, stick")


def test_the_tip_goes_as_a_program_wishes(program):
    program.drive((0.0, 0.3, 0.1), 2.0)
    assert speed(program.loop) == pytest.approx(math.hypot(0.3, 0.1), rel=0.05)
    way = np.array(program.loop.tips[-400:]) - START
    along = np.array([0.0, 0.3, 0.1]) / math.hypot(0.3, 0.1)
    beside = way - np.outer(way @ along, along)
    assert np.linalg.norm(beside, axis=1).max() < 0.006


def test_zero_stops_the_tip_and_the_next_wish_moves_it_again(program):
    program.drive((0.0, 0.3, 0.0), 1.0)
    program.drive(ZERO, 1.5)
    assert speed(program.loop) < 0.01
    program.drive((0.0, -0.3, 0.0), 1.0)
    assert speed(program.loop) > 0.25
    assert program.runs == 2


def test_a_program_that_falls_silent_stops_the_tip_and_must_say_zero_before_it_moves_it_again(program):
    program.drive((0.0, 0.3, 0.0), 1.0)
    program.drive(None, TIMEOUT + 1.5)
    assert speed(program.loop) < 0.01
    program.drive((0.0, 0.3, 0.0), 0.5)
    assert speed(program.loop) < 0.01
    program.drive(ZERO, 0.1)
    program.drive((0.0, 0.3, 0.0), 1.0)
    assert speed(program.loop) > 0.25


def test_a_wish_that_stands_when_the_deadman_is_pressed_moves_nothing(loop):
    program = Program(loop)
    program.drive((0.0, 0.3, 0.0), 0.3, RELEASED)
    program.drive((0.0, 0.3, 0.0), 1.0)
    assert math.dist(loop.tips[-1], START) < 0.005


def test_a_released_deadman_stops_what_a_program_moves(program):
    program.drive((0.0, 0.3, 0.0), 1.0)
    program.drive((0.0, 0.3, 0.0), 0.25, RELEASED)
    assert max(map(abs, program.loop.loop.controller.command)) == 0.0


def test_a_stick_takes_the_tip_from_a_program(program):
    program.drive((0.0, 0.3, 0.0), 1.0)
    program.drive((0.0, 0.3, 0.0), 1.0, Operator(Levers(-0.5, 0.0, 0.0)))
    moved = np.diff(np.array(program.loop.tips[-20:]), axis=0)[:, 1].mean() / PERIOD
    assert moved < -0.2
    program.drive((0.0, 0.3, 0.0), 1.0)
    assert speed(program.loop) < 0.005


def test_a_limit_slows_the_tip_and_the_way_is_kept(program):
    """Upwards ahead, until the stick's end: the tip stays on the line that was wished."""
    wish = (0.6, 0.0, 0.15)
    program.drive(wish, 6.0)
    assert speed(program.loop) < 0.2 * math.hypot(*wish)
    way = np.array(program.loop.tips) - START
    along = np.array(wish) / math.hypot(*wish)
    beside = way - np.outer(way @ along, along)
    assert np.linalg.norm(beside, axis=1).max() < 0.02


@pytest.mark.parametrize(
    ("frame", "linear", "angular", "said"),
    [
        ("tool0", (0.1, 0.0, 0.0), ZERO, "frame 'tool0'; allowed: 'base_link'"),
        ("base_link", (math.nan, 0.0, 0.0), ZERO, "not finite; allowed: m/s"),
        ("base_link", (0.1, 0.0, 0.0), (0.0, 0.0, 0.2), "it turns; allowed: angular 0"),
        ("base_link", (0.1, 0.0, 0.0), (0.0, math.inf, 0.0), "not finite"),
    ],
)
def test_a_wish_that_cannot_be_followed_is_refused_by_name(frame, linear, angular, said):
    with pytest.raises(TwistError, match=said):
        wish_of(frame, linear, angular, 0.0)


def test_the_end_of_a_run_is_said_once():
    seen = Seen(START, 1.0, True, True)
    follower, _ = step(Follower(), Wish(ZERO, 0.0), seen, 0.0)
    follower, command = step(follower, Wish((0.1, 0.0, 0.0), 0.0), seen, 0.0)
    assert command.speed == 0.1
    follower, command = step(follower, NO_WISH, seen, 0.1)
    assert command == NO_COMMAND
    assert step(follower, NO_WISH, seen, 0.2)[1] is None


def test_a_tip_beside_its_way_is_led_back_to_it():
    """The way goes on in the wished direction from where it began, not from where the tip has strayed to."""
    follower, _ = step(Follower(), Wish(ZERO, 0.0), Seen(START, 1.0, True, True), 0.0)
    x, y, z = START
    for place in (START, (x + 0.01, y + 0.1, z - 0.02)):
        follower, command = step(follower, Wish((0.0, 0.3, 0.0), 0.0), Seen(place, 1.0, True, True), 0.0)
    assert command.place == pytest.approx((x, y + 0.1, z))
    assert command.tangent == (0.0, 1.0, 0.0)
