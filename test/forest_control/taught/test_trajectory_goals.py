"""Goals of a program: what is refused, what is told meanwhile, and how each ends."""

import math
from types import SimpleNamespace as Message

import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.taught_command import taught_velocity
from forest_control.taught.taught_work import Seen, TaughtWork
from forest_control.taught.trajectory_goals import TrajectoryGoals
from forest_description.geometry.kinematics import inverse_kinematics, tip_position
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_msgs_py.types import PERIOD

P = parameters(load_machine("c180_hoses"), Settings())
HERE = (5.5, 0.0, 1.0)
POSE = inverse_kinematics(HERE, P.links)
TURN = 0.1  # rad of the swing, that is asked for
LONG = 30.0  # s


class Log:
    """Remembers what is said."""

    def __init__(self):
        self.infos, self.warnings = [], []
        self.info, self.warning = self.infos.append, self.warnings.append


class Goal:
    """An accepted goal in the hands of a client that never cancels: remembers what becomes of it."""

    def __init__(self, request):
        self.request, self.ends, self.told = request, [], []

    def tell(self, fill):
        feedback = Message(
            header=Message(stamp=Message()), desired=Message(), actual=Message(), error=Message()
        )
        fill(feedback)
        self.told.append(feedback)

    def end(self, success, **result):
        self.ends.append((success, result["error_code"], result["error_string"]))


class Rig:
    """A tip that is carried along the path that is commanded, and a program."""

    def __init__(self, folder):
        self.work, self.log, self.events = TaughtWork(folder, P), Log(), []
        self.goals = TrajectoryGoals(self.work, self.log, self.events.append)
        self.tip, self.time = HERE, 0.0
        self.once()

    def once(self, armed=True):
        self.time += PERIOD
        command = self.work.advance(Seen(self.tip, self.time, armed, centred=True), PERIOD).command
        if command is not None and command.speed:
            rates = taught_velocity(command, self.tip, 1.0)
            self.tip = tuple(x + PERIOD * rate for x, rate in zip(self.tip, rates, strict=True))
        self.goals.watch(self.tip)

    def until(self, done, most=LONG):
        end = self.time + most
        while not done():
            assert self.time < end
            self.once()

    def ask(self, request):
        """A client asks; the goal if it is accepted, else None."""
        if not self.goals.begin(request):
            return None
        goal = Goal(request)
        self.goals.accept(goal)
        return goal


@pytest.fixture
def rig(tmp_path):
    return Rig(tmp_path)


def request(turn=TURN, **others):
    point = Message(
        positions=[POSE[1], POSE[0] + turn, POSE[2]],
        velocities=[],
        time_from_start=Message(sec=1, nanosec=500_000_000),
    )
    trajectory = Message(joint_names=["boom", "swing", "stick"], points=[point])
    free = {"path_tolerance": [], "goal_tolerance": [], "multi_dof_trajectory": Message(points=[])}
    return Message(**{"trajectory": trajectory} | free | others)


def within(name, position):
    return [Message(name=name, position=position)]


def test_a_goal_succeeds_when_the_tip_has_arrived(rig):
    goal = rig.ask(request(goal_tolerance=within("swing", 0.01)))
    rig.until(lambda: goal.ends)
    assert goal.ends == [(True, 0, "joint trajectory: finished")]
    assert math.dist(rig.tip, tip_position((POSE[0] + TURN, *POSE[1:]), P.links)) < 0.01
    (said,) = rig.log.infos
    assert "1.5 s asked for" in said
    assert not rig.events


def test_a_goal_ends_once_and_a_later_one_has_its_own_end(rig):
    first = rig.ask(request())
    rig.until(lambda: first.ends)
    second = rig.ask(request(0.0))
    rig.until(lambda: second.ends)
    assert len(first.ends) == len(second.ends) == 1


def test_an_end_beyond_the_goal_s_tolerance_is_told_with_the_joint(rig):
    goal = rig.ask(request(goal_tolerance=[*within("boom", 0.1), *within("swing", 1e-9)]))
    rig.until(lambda: goal.ends)
    ((success, code, said),) = goal.ends
    assert (success, code) == (False, -5)
    assert said.startswith("joint trajectory: swing ends ")
    assert said.endswith("rad away; allowed by the goal: 1e-09")


def test_what_is_cancelled_ends_when_the_tip_rests(rig):
    goal = rig.ask(request())
    rig.until(lambda: rig.tip != HERE)
    assert rig.goals.cancel()
    assert not goal.ends  # it still brakes
    rig.until(lambda: goal.ends)
    assert goal.ends == [(False, -1, "joint trajectory: ended")]


def test_nothing_can_be_cancelled_where_nothing_is_played(rig):
    assert not rig.goals.cancel()
    assert "nothing is taught or played" in rig.events[-1]


def test_a_pause_ends_no_goal(rig):
    goal = rig.ask(request())
    rig.until(lambda: rig.tip != HERE)
    rig.once(armed=False)
    for _ in range(200):
        rig.once()
    assert not goal.ends
    rig.work.actions["resume"]()
    rig.until(lambda: goal.ends)
    assert goal.ends[0][0]


def test_a_goal_that_another_play_replaces_has_failed(rig):
    goal = rig.ask(request())
    rig.until(lambda: rig.tip != HERE)
    rig.once(armed=False)
    other = rig.ask(request())
    rig.once()
    assert goal.ends == [(False, -1, "joint trajectory: another was begun")]
    rig.until(lambda: other.ends)
    assert other.ends[0][0]


def test_a_second_goal_is_refused_while_one_is_under_way(rig):
    rig.ask(request())
    assert rig.ask(request()) is None
    assert "is under way; allowed: a trajectory after stop" in rig.events[-1]
    assert rig.log.warnings == rig.events


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"path_tolerance": within("swing", 0.1)}, "a path_tolerance is given; allowed: none"),
        ({"multi_dof_trajectory": Message(points=[0])}, "a multi_dof_trajectory is given; allowed: none"),
        ({"goal_tolerance": within("arm", 0.1)}, "goal_tolerance of arm; allowed: swing, boom, stick"),
        ({"trajectory": Message(joint_names=AXES, points=[])}, "0 points; allowed: 1 to"),
    ],
)
def test_a_goal_that_cannot_be_kept_is_refused_with_the_reason(rig, asked, said):
    assert rig.ask(request(**asked)) is None
    assert f"joint trajectory: {said}" in rig.events[-1]
    rig.once()
    assert rig.work.rests


def test_a_tolerance_of_zero_or_less_is_none(rig):
    free = [*within("swing", 0.0), *within("boom", -1.0)]
    goal = rig.ask(request(path_tolerance=free, goal_tolerance=free))
    rig.until(lambda: goal.ends)
    assert goal.ends[0][0]


def test_joints_and_path_are_told_as_feedback(rig):
    goal = rig.ask(request())
    rig.until(lambda: math.dist(rig.tip, HERE) > 0.2)
    x, y, z = rig.tip
    rig.tip = x, y, z + 0.01  # beside the path
    rig.once()
    rig.goals.tell(3_000_000_007)
    (told,) = goal.told
    assert (told.header.stamp.sec, told.header.stamp.nanosec) == (3, 7)
    assert told.joint_names == list(AXES)
    assert told.actual.positions == inverse_kinematics(rig.tip, P.links)
    assert tip_position(told.desired.positions, P.links)[2] == pytest.approx(HERE[2], abs=1e-3)
    assert told.error.positions == pytest.approx(
        [a - b for a, b in zip(told.desired.positions, told.actual.positions, strict=True)]
    )
    rig.until(lambda: goal.ends)
    rig.goals.tell(4)
    assert len(goal.told) == 1


def test_a_message_without_points_ends_what_is_played(rig):
    rig.goals.hear(request().trajectory)
    rig.until(lambda: rig.tip != HERE)
    rig.goals.hear(Message(joint_names=[], points=[]))
    rig.until(lambda: rig.work.rests)
    assert rig.log.infos[-1] == "joint trajectory: ending"


def test_a_tip_that_is_told_out_of_reach_harms_nobody(rig):
    """Anybody may publish where the tip is: the node must go on."""
    goal = rig.ask(request(goal_tolerance=within("swing", 0.01)))
    rig.until(lambda: rig.tip != HERE)
    rig.goals.watch((100.0, 0.0, 0.0))
    rig.goals.tell(1)
    assert all(map(math.isnan, goal.told[0].actual.positions))
    assert all(map(math.isnan, goal.told[0].error.positions))
    rig.until(lambda: rig.work.outcome(1) is not None)
    goal.ends.clear()
    rig.goals.accept(goal)
    rig.goals.watch((100.0, 0.0, 0.0))
    assert goal.ends[0][:2] == (False, -5)
