"""Taught work with the real controller and machine: a path is driven once, and then played in many ways."""

import dataclasses
import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator.levers import REST, Levers
from forest_control.operator.operator_profile import Mode
from forest_control.servo.schemes import Scheme
from forest_control.taught.cycle import Cycle, Grapple, Path, Pose
from forest_control.taught.cycle_file import load_cycle, save_cycle
from forest_control.taught.player import Phase
from forest_control.taught.teaching import distances
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Operator
from forest_study.measures import deviation
from forest_study.tracking.taught_loop import TaughtLoop
from forest_study.tracking.tracking import noisy

C180 = load_machine("c180_hoses")
START = (5.5, 0.0, 0.8)
HELD, RELEASED = Operator(REST), Operator(REST, enabled=False)
STOPPED = 0.25  # [s] as docs/explanation/safety.md tells


def levers(time):
    return Levers(0.6 * math.sin(1.1 * time), 0.4 * math.sin(1.7 * time), 0.4 * math.cos(1.3 * time))


def cross_track(points, tips):
    """Return how far tips [m] were from the path through points [m]."""
    return deviation(distances(points, np.array(tips)))


def driven(folder, suite=None):
    """Drive and teach a path; return its waypoints and where the tip was."""
    loop = TaughtLoop(C180, START, folder, suite=suite)
    loop.drive(HELD, 0.3)
    loop.work.cycle, loop.work.label = "bow", "round"
    assert loop.work.record()
    begun = len(loop.tips)
    for k in range(round(4.0 / PERIOD)):
        loop.period(Operator(levers(k * PERIOD)))
    loop.drive(HELD, 0.5)
    assert loop.work.stop()
    (path,) = load_cycle("bow", folder).segments
    return path, loop.tips[begun:]


@pytest.fixture(scope="module")
def taught(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cycles")
    return folder, *driven(folder)


def playing(taught, **circumstances):
    """Return a loop in which the path is played from its start, and runs."""
    folder, path, _ = taught
    loop = TaughtLoop(C180, path.points[0], folder, **circumstances)
    loop.work.cycle = "bow"
    loop.drive(HELD, 0.3)
    assert loop.work.play()
    loop.until(Phase.RUNNING, 0.1)
    return loop


def speed(loop):
    return math.dist(loop.tips[-1], loop.tips[-2]) / PERIOD


def way(loop, seconds, operator=HELD):
    """Return how far the tip gets in some time [s] from where it is [m]; it may rock on its hoses."""
    before = loop.tips[-1]
    loop.drive(operator, seconds)
    return max(math.dist(tip, before) for tip in loop.tips[-round(seconds / PERIOD) :])


def test_what_is_driven_becomes_a_path_of_few_points_near_it(taught):
    _, path, tips = taught
    assert len(path.points) < 30
    assert cross_track(list(path.points), tips).rms_mm < 2.5
    assert cross_track(list(path.points), tips[:-150]).max_mm < 4.0  # after that the tip rocks to rest
    assert 0.15 < path.speed < 0.5


def test_what_is_taught_is_played_along_the_path_in_its_time(taught):
    _, path, tips = taught
    loop = playing(taught)
    loop.until(Phase.FINISHED, 20.0)
    away = cross_track(list(path.points), loop.tips)
    assert away.rms_mm < 2.0
    assert away.max_mm < 6.0
    assert cross_track(tips, loop.tips).rms_mm < 2.5
    assert math.dist(loop.tips[-1], path.points[-1]) < 0.002
    assert loop.events[-1] == "bow: finished"
    assert sum(phase == Phase.RUNNING for phase in loop.phases) * PERIOD < 4.0 + 3.5


def test_a_path_that_turns_back_is_kept_though_the_swing_hardly_moves(tmp_path):
    points = ((5.5, 0.0, 1.0), (5.5, 0.67, 1.0), (5.83, 0.69, 1.0), (5.28, 0.687, 1.0))
    save_cycle(Cycle("bow", (Path("there and back", points, 0.4),)), tmp_path)
    loop = playing((tmp_path, Path("", points, 0.4), None))
    loop.until(Phase.FINISHED, 20.0)
    assert cross_track(list(points), loop.tips).max_mm < 4.0


def test_with_noisy_sensors_path_and_play_are_as_good(tmp_path):
    suite = noisy(C180, 1)
    path, _ = driven(tmp_path, suite)
    loop = playing((tmp_path, path, None), suite=suite)
    loop.until(Phase.FINISHED, 20.0)
    assert cross_track(list(path.points), loop.tips).rms_mm < 3.0


def test_a_limit_that_acts_slows_the_tip_on_its_path(taught):
    """The controller allows a twentieth of the joint rates that the plan was made with."""
    slow = Settings(joint_rates=(0.02, 0.01, 0.01))
    loop = playing(taught, settings=slow)
    limited = []
    while loop.phase == Phase.RUNNING and len(limited) < 6000:
        loop.period(HELD)
        scaling = loop.loop.telemetry.output.scaling
        limited.append((scaling.limit, scaling.factor))
    assert loop.phase == Phase.FINISHED
    limits = {limit for limit, _ in limited}
    assert Limit.RATE in limits
    assert sum(factor < 0.9 for _, factor in limited) > 0.5 * len(limited)  # in force most of the time
    assert len(limited) * PERIOD > 12.0
    assert cross_track(list(taught[1].points), loop.tips).rms_mm < 2.0


def test_any_stick_pauses_at_once_and_drives_until_a_person_resumes(taught):
    loop = playing(taught)
    loop.drive(HELD, 1.5)
    was = np.array(loop.tips[-1])
    loop.drive(Operator(Levers(0.0, 0.6, 0.0)), 0.8)
    assert loop.phase == Phase.PAUSED
    assert "a stick moved" in loop.events[-1]
    assert loop.tips[-1][2] - was[2] > 0.15  # up, as the lever says
    loop.drive(HELD, 1.0)
    assert way(loop, 0.5) < 0.01
    assert loop.phase == Phase.PAUSED
    assert loop.work.resume()
    resumed = len(loop.tips)
    loop.until(Phase.FINISHED, 25.0)
    back = next(k for k in range(resumed, len(loop.tips)) if math.dist(loop.tips[k], was) < 0.05)
    assert cross_track(list(taught[1].points), loop.tips[back + 200 :]).rms_mm < 2.5


@pytest.mark.parametrize(("operator", "grace"), [(RELEASED, 0.0), (None, 0.15)], ids=["released", "lost"])
def test_a_released_deadman_or_a_lost_joystick_stops_the_tip_along_its_path(taught, operator, grace):
    loop = playing(taught)
    loop.drive(HELD, 1.5)
    assert speed(loop) > 0.15
    begun = len(loop.tips)
    loop.drive(operator, grace + STOPPED)
    assert speed(loop) < 0.05
    assert cross_track(list(taught[1].points), loop.tips[begun:]).max_mm < 8.0
    loop.drive(operator, 0.1)
    assert not any(loop.period(operator).voltages)
    assert loop.phase == Phase.PAUSED
    assert way(loop, 1.0) < 0.01  # pressed again: nothing goes on by itself
    assert loop.phase == Phase.PAUSED


def test_a_player_that_falls_silent_stops_the_tip_and_cannot_go_on_by_itself(taught):
    loop = playing(taught)
    loop.drive(HELD, 1.5)
    for _ in range(round((0.1 + STOPPED) / PERIOD)):
        loop.period(HELD, silent=True)
    assert speed(loop) < 0.05
    assert "taught command: none for 0.1 s" in loop.loop.controller.guard.causes["joystick"]
    stood = loop.tips[-1]
    for _ in range(20):
        loop.period(HELD, silent=True)
    assert not any(loop.period(HELD, silent=True).voltages)
    loop.until(Phase.PAUSED, 4.0)  # heard again, of the same run
    assert "does not get on" in loop.events[-1]
    assert math.dist(loop.tips[-1], stood) < 0.005
    assert loop.work.resume()
    loop.until(Phase.FINISHED, 20.0)
    assert not loop.loop.controller.guard.causes["joystick"]


def test_a_pause_holds_the_tip_and_the_button_goes_on(taught):
    loop = playing(taught)
    loop.drive(HELD, 1.0)
    loop.period(HELD, pressed=True)
    loop.drive(HELD, 0.5)
    assert loop.phase == Phase.PAUSED
    assert way(loop, 0.5) < 0.01
    loop.period(HELD, pressed=True)
    loop.until(Phase.FINISHED, 20.0)


def test_without_the_deadman_nothing_is_played(taught):
    folder, path, _ = taught
    loop = TaughtLoop(C180, path.points[0], folder)
    loop.work.cycle = "bow"
    loop.drive(RELEASED, 0.3)
    assert loop.work.play()
    loop.drive(RELEASED, 10.5)
    assert loop.phase == Phase.PAUSED
    assert "nobody held the deadman" in loop.events[-1]
    loop.drive(HELD, 1.0)  # too late: what was forgotten does not begin
    assert max(math.dist(tip, loop.tips[0]) for tip in loop.tips) < 0.005


@pytest.mark.parametrize(
    "scheme", [Scheme.IK_VELOCITY, Scheme.IK_POSITION, Scheme.JACOBIAN_VELOCITY, Scheme.JACOBIAN_POSITION]
)
def test_the_schemes_of_the_thesis_follow_as_well_as_they_can(taught, scheme):
    loop = playing(taught, settings=Settings(scheme=scheme))
    loop.until(Phase.FINISHED, 30.0)
    assert cross_track(list(taught[1].points), loop.tips).rms_mm < 25.0


def test_in_the_joint_scheme_nothing_moves_and_the_player_says_so(taught):
    loop = playing(taught, settings=Settings(scheme=Scheme.JOINT))
    loop.until(Phase.PAUSED, 4.0)
    assert "the joint scheme" in loop.events[-1]
    assert max(math.dist(tip, loop.tips[0]) for tip in loop.tips) < 0.005


def test_position_mode_goes_on_from_where_the_path_is_left(taught):
    loop = playing(taught, settings=Settings(mode=Mode.POSITION))
    loop.drive(HELD, 1.5)
    loop.work.pause()
    loop.drive(HELD, 0.5)
    assert way(loop, 1.0) < 0.01


def test_a_pose_is_taught_and_reached_and_the_grapple_waits_for_a_person(tmp_path):
    loop = TaughtLoop(C180, START, tmp_path)
    loop.work.cycle = "load"
    loop.drive(HELD, 0.3)
    assert loop.work.pose()
    assert loop.work.close()
    segments = (
        *load_cycle("load", tmp_path).segments,
        Pose("off", (5.5, 0.4, 0.8), 0.3),
        Grapple("let", "open", 0.5),
    )
    save_cycle(Cycle("load", segments), tmp_path)
    assert loop.work.play()
    loop.until(Phase.HOLDING, 1.0)
    loop.drive(HELD, 3.0)
    assert loop.phase == Phase.HOLDING
    assert "close: grapple close, until a person confirms" in loop.events[-1]
    assert loop.work.resume()
    loop.until(Phase.FINISHED, 10.0)
    assert math.dist(loop.tips[-1], (5.5, 0.4, 0.8)) < 0.005
    assert loop.events[-2:] == ["load: let: grapple open, for 0.5 s", "load: finished"]


def test_another_load_than_believed_leaves_the_tip_near_its_path(taught):
    from forest_sim.equations.plant_parameters import plant_parameters

    crane = dataclasses.replace(C180.manipulator, head_mass=2.0 * C180.manipulator.head_mass)
    loop = playing(taught, plant=plant_parameters(dataclasses.replace(C180, manipulator=crane)))
    loop.until(Phase.FINISHED, 20.0)
    assert cross_track(list(taught[1].points), loop.tips).rms_mm < 5.0
