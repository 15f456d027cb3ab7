"""A program's joint trajectories: of the topic, and goals of control_msgs' action FollowJointTrajectory.

The path is kept, and the time gives. So a tolerance along the path, where the joints should be at each time,
is refused, and `goal_time_tolerance` has no meaning. A pause ends no goal: a person may resume. A goal ends
when the tip has arrived, or when its run is over otherwise.
"""

import math
from collections.abc import Callable
from operator import sub
from typing import TYPE_CHECKING, Any

from forest_control.taught.joint_trajectory import NAME, TrajectoryRow
from forest_control.taught.taught_work import TaughtWork
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.types import AXES, Vec3
from forest_msgs_py.types import NS_PER_S

if TYPE_CHECKING:
    from forest_msgs_py.runtime.services import Goal

SUCCESSFUL, INVALID_GOAL, GOAL_TOLERANCE_VIOLATED = 0, -1, -5  # [1] error codes of the action

OUT_OF_REACH = math.nan, math.nan, math.nan  # [rad] of a tip that no links have


class TrajectoryGoals:
    """What a program asks of taught work, and how it ends.

    Args:
        work: that plays the trajectories.
        log: what `rclpy` calls a logger.
        event: publishes why something is refused.
    """

    def __init__(self, work: TaughtWork, log: Any, event: Callable[[str], None]) -> None:
        self._work, self._log, self._event = work, log, event
        self._goals: list[tuple[int, Goal]] = []  # under way, each with the number of its play
        self._tip = (0.0, 0.0, 0.0)  # [m] where it was watched last

    def hear(self, trajectory: Any) -> None:
        """Play a trajectory_msgs/JointTrajectory; one without points ends what is played."""
        if trajectory.points:
            self._play(trajectory)
        else:
            self.cancel()

    def begin(self, request: Any) -> bool:
        """Begin what a goal asks for; False: it is refused, and the event says why."""
        refused = _refusal(request)
        return self._told(False, f"{NAME}: {refused}") if refused else self._play(request.trajectory)

    def accept(self, goal: "Goal") -> None:
        """Keep the goal that has just begun."""
        self._goals.append((self._work.begun, goal))

    def cancel(self) -> bool:
        """End what is played; False: nothing is."""
        return self._told(*self._work.actions["stop"]())

    def watch(self, tip: Vec3) -> None:
        """End the goals that are over, with the tip at a place [m]."""
        self._tip = tip
        for one in tuple(self._goals):
            begun, goal = one
            if over := self._work.outcome(begun):
                self._goals.remove(one)
                arrived, said = over
                missed = self._missed(goal.request.goal_tolerance) if arrived else ""
                code = INVALID_GOAL if not arrived else GOAL_TOLERANCE_VIOLATED if missed else SUCCESSFUL
                goal.end(code == SUCCESSFUL, error_code=code, error_string=f"{NAME}: {missed or said}")

    def tell(self, stamp: int) -> None:
        """Publish as feedback where the joints are, and where beside them the path is, at a stamp [ns]."""
        if not self._goals or self._work.beside is None:
            return
        desired, actual = self._angles(self._work.beside), self._angles(self._tip)

        def fill(feedback: Any) -> None:
            feedback.header.stamp.sec, feedback.header.stamp.nanosec = divmod(stamp, NS_PER_S)
            feedback.joint_names = list(AXES)
            feedback.desired.positions, feedback.actual.positions = desired, actual
            feedback.error.positions = list(map(sub, desired, actual))

        for _, goal in self._goals:
            goal.tell(fill)

    def _play(self, trajectory: Any) -> bool:
        return self._told(*self._work.follow(*trajectory_of(trajectory)))

    def _told(self, done: bool, said: str) -> bool:
        """Tell what came of something that a program asked for, and return it."""
        if done:
            self._log.info(said)
        else:
            self._log.warning(said)
            self._event(said)
        return done

    def _missed(self, tolerances: Any) -> str:
        """Return which joint is farther from the trajectory's end than a goal allows, or ""."""
        away = dict(zip(AXES, map(sub, self._angles(self._tip), self._angles(self._work.end)), strict=True))
        for one in tolerances:
            if one.position > 0.0 and not abs(away[one.name]) <= one.position:
                return f"{one.name} ends {away[one.name]:.4f} rad away; allowed by the goal: {one.position:g}"
        return ""

    def _angles(self, tip: Vec3) -> Vec3:
        """Return the angles [rad] of stiff links whose tip is there; NaN out of their reach."""
        try:
            return inverse_kinematics(tip, self._work.p.links)
        except ValueError:
            return OUT_OF_REACH


def _refusal(request: Any) -> str:
    """Return why a goal cannot be kept, or ""."""
    if any(one.position > 0.0 for one in request.path_tolerance):
        return "a path_tolerance is given; allowed: none, the path is kept and not the time"
    if request.multi_dof_trajectory.points:
        return "a multi_dof_trajectory is given; allowed: none"
    strangers = sorted({one.name for one in request.goal_tolerance}.difference(AXES))
    return f"goal_tolerance of {', '.join(strangers)}; allowed: {', '.join(AXES)}" if strangers else ""


def trajectory_of(message: Any) -> tuple[list[str], list[TrajectoryRow]]:
    """Return the joints' names and the points of a trajectory_msgs/JointTrajectory."""
    rows = [
        TrajectoryRow(
            point.time_from_start.sec + point.time_from_start.nanosec / NS_PER_S,
            list(point.positions),
            list(point.velocities),
        )
        for point in message.points
    ]
    return list(message.joint_names), rows
