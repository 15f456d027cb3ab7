"""When a taught command counts, and each cause that ends its run; bounds as the page on safety has them."""

import pytest

from forest_control.operator.joystick_watch import Joystick, Watch, WatchParameters
from forest_control.operator.levers import Levers
from forest_control.operator.taught_command import NO_COMMAND, TaughtCommand
from forest_control.safety import taught_watch
from forest_control.safety.taught_watch import AWAY, LOST, NO_LIFE, assessed, ended, heard

TIP, P = (5.0, 0.0, 1.0), WatchParameters()
COMMAND = TaughtCommand(TIP, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 0.3, 1.0)
HELD = Watch(Joystick.ALIVE, fresh_since=10.0, moved=10.0, held=True, armed=True)


def at(now, watch, allowed=True, joystick=HELD, tip=TIP, p=P):
    return assessed(watch, allowed, joystick._replace(moved=joystick.moved + now - 10.0), tip, now, p)


@pytest.fixture
def running():
    watch, command = at(10.0, heard(taught_watch.REST, 5.0, COMMAND, 10.0))
    assert command == COMMAND
    return watch


def is_over(watch, now=10.0):
    """Whether no command of the run counts again, however fresh and good; another run's does."""
    again, command = at(now, heard(watch, 5.0, COMMAND, now))
    other, follows = at(now, heard(again, 6.0, COMMAND, now))
    return command == NO_COMMAND and follows == COMMAND and not other.cause


def test_before_any_command_there_is_none():
    assert at(10.0, taught_watch.REST)[1] == NO_COMMAND


@pytest.mark.parametrize(("age", "counts"), [(0.099, True), (0.101, False)])
def test_a_command_older_than_a_tenth_of_a_second_ends_its_run(running, age, counts):
    watch, command = at(10.0 + age, running)
    assert (command == COMMAND) == counts
    assert watch.cause == ("" if counts else LOST)
    assert counts or is_over(watch, 10.0 + age)


def test_whatever_forbids_motion_ends_the_run_without_a_cause_of_its_own(running):
    watch, command = at(10.0, running, allowed=False)
    assert command == NO_COMMAND
    assert not watch.cause
    assert is_over(watch)


@pytest.mark.parametrize("lever", range(3))
@pytest.mark.parametrize(("deflection", "counts"), [(0.049, True), (0.051, False), (-0.051, False)])
def test_a_lever_takes_over_at_once(running, lever, deflection, counts):
    levers = Levers(*(deflection * (i == lever) for i in range(3)))
    watch, command = at(10.0, running, joystick=HELD._replace(levers=levers))
    assert (command == COMMAND) == counts
    assert not watch.cause
    assert counts or is_over(watch)


def test_the_player_ends_its_run_by_a_command_without_speed(running):
    watch = heard(running, 5.0, NO_COMMAND, 10.0)
    assert at(10.0, watch)[1] == NO_COMMAND
    assert not watch.cause
    assert is_over(watch)


@pytest.mark.parametrize(("away", "counts"), [(0.099, True), (0.101, False)])
def test_a_path_that_is_far_from_the_tip_moves_nothing(running, away, counts):
    watch, command = at(10.0, running, tip=(5.0 + away, 0.0, 1.0))
    assert (command == COMMAND) == counts
    assert watch.cause == ("" if counts else AWAY)
    assert counts or is_over(watch)


@pytest.mark.parametrize(("still", "counts"), [(9.99, True), (10.01, False)])
def test_a_joystick_without_life_may_hang_with_its_deadman_held(running, still, counts):
    joystick = HELD._replace(moved=HELD.moved - still)
    watch, command = at(10.0, running, joystick=joystick)
    assert (command == COMMAND) == counts
    assert watch.cause == ("" if counts else NO_LIFE)
    assert at(10.0, running, joystick=joystick, p=P._replace(frozen_timeout=0.0))[1] == COMMAND
    assert at(10.0, running, joystick=joystick, p=P._replace(frozen_timeout=0.5))[1] == NO_COMMAND


def test_nonsense_ends_the_run_and_says_why(running):
    for watch in (
        heard(running, 0.0, NO_COMMAND, 10.0, "nonsense"),
        heard(running, 5.0, COMMAND._replace(tangent=(0.0, 2.0, 0.0)), 10.0),
    ):
        assert at(10.0, watch)[1] == NO_COMMAND
        assert watch.cause
        assert is_over(watch)


def test_a_place_without_bounds_moves_nothing(running):
    watch = heard(running, 5.0, COMMAND._replace(place=(1e300, -1e300, 1e300)), 10.0)
    watch, command = at(10.0, watch)
    assert command == NO_COMMAND
    assert watch.cause == AWAY


def test_an_older_run_is_not_heard(running):
    assert heard(running, 4.0, COMMAND._replace(speed=3.0), 10.0) == running
    assert heard(running, 4.0, NO_COMMAND, 10.0) == running


def test_a_cause_is_told_until_the_deadman_is_released_or_another_run_begins(running):
    lost, _ = at(11.0, running)
    assert at(11.0, lost)[0].cause == LOST
    assert not at(11.0, lost, allowed=False)[0].cause
    assert not heard(lost, 6.0, COMMAND, 11.0).cause


def test_to_end_what_has_ended_changes_nothing(running):
    over = ended(running, "first")
    assert ended(over, "second") == over
    assert ended(taught_watch.REST, "none") == taught_watch.REST
