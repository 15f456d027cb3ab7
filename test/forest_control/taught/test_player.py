"""Claims about the player by itself: its phases, how fast the tip is led, and which piece of path is told.

The tip here goes exactly where it is led; with the crane: `test_taught_loop.py`.
"""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.taught_command import NO_COMMAND, SHARPEST, TaughtCommand, taught_velocity
from forest_control.taught.cycle import Grapple
from forest_control.taught.plan import RAMP, Hold, Leg, leg
from forest_control.taught.player import (
    BACK,
    BASE,
    BRAKE,
    FARTHEST,
    GAP,
    LEAST,
    NEAR,
    PATIENCE,
    PROGRESS,
    SETTLED,
    STUCK,
    Inputs,
    Phase,
    Place,
    State,
    piece,
    started,
    step,
)
from forest_control.taught.tip_path import TipPath
from forest_description.machine import load_machine

P = parameters(load_machine("c180_hoses"), Settings())
DT = 0.005
A, B, C = (5.5, 0.0, 1.0), (5.7, 0.25, 1.3), (5.5, 0.4, 0.9)
OUT, BACK_HOME, BOTH = (
    leg(1, "out", [A, B], 0.2, P),
    leg(2, "home", [B, A], 0.2, P),
    leg(1, "both", [A, B, C], 0.2, P),
)


class Rig:
    """A player whose tip goes where it is led, or stands."""

    def __init__(self, *steps, tip=A):
        self.state, event = started(steps)
        self.events, self.tip, self.time, self.command, self.runs = [event], tip, 100.0, NO_COMMAND, []

    def step(self, dt=DT, stands=False, armed=True, centred=True, **asked):
        self.time += dt
        was = self.state.phase
        self.state, said = step(self.state, Inputs(self.tip, self.time, armed, centred, **asked), P, dt)
        self.events += [said.event] * bool(said.event)
        if said.command is not None:
            self.command = said.command
        if self.state.phase != was:
            self.runs.append(self.state.run)
        if self.state.phase == Phase.RUNNING and self.command.speed and not stands:
            v = taught_velocity(self.command, self.tip, 1.0)
            self.tip = tuple(x + v_x * dt for x, v_x in zip(self.tip, v, strict=True))
        return said

    def until(self, done, most=20.0, **how):
        begun = self.time
        while not done(self.state):
            assert self.time < begun + most, self.state
            self.step(**how)
        return self.time - begun

    def to(self, phase, **how):
        return self.until(lambda state: state.phase == phase, **how)


def running(*steps, seconds=0.0):
    """Return a rig on its first leg for some time."""
    rig = Rig(*steps)
    rig.to(Phase.RUNNING)
    begun = rig.time
    rig.until(lambda _: rig.time >= begun + seconds - 1e-9)
    return rig


def oblique(length, radius=math.inf, stops=None):
    """Return a leg along a straight line or a circle whose direction has no zero in it, at 0.2 m/s."""
    along = np.array([2.0, -3.0, 6.0]) / 7.0
    across = np.array([3.0, 6.0, 2.0]) / 7.0

    def at(s):
        if radius == math.inf:
            return tuple(A + s * along)
        angle = s / radius
        return tuple(A + radius * (math.sin(angle) * along + (1.0 - math.cos(angle)) * across))

    ways = np.array([0.0, length])
    path = TipPath("tried", length, at, stops or (0.0, length))
    return Leg(1, "tried", path, ways, np.full(2, 0.04)), along, across


def test_the_bounds_are_those_of_the_documents():
    """Each is a choice: whoever changes it shall mean to."""
    assert (PATIENCE, NEAR, SETTLED, STUCK, PROGRESS) == (10.0, 0.01, 1.5, 3.0, 0.005)
    assert (FARTHEST, GAP, BRAKE, BACK, LEAST, BASE) == (0.09, 0.1, 1.0, 0.15, 0.02, 0.02)


def test_phases_have_the_numbers_that_cycle_status_carries():
    assert [(phase.name, phase.value) for phase in Phase] == [
        ("IDLE", 0),
        ("WAITING", 1),
        ("RUNNING", 2),
        ("HOLDING", 3),
        ("PAUSED", 4),
        ("FINISHED", 5),
        ("RECORDING", 6),
    ]


def test_what_nobody_has_played_stays_idle():
    assert State() == State(Phase.IDLE, (), 0, None, None, 0.0, 0.0, 0.0, 0.0, 0.0, -math.inf, False, "")
    after, said = step(State(), Inputs(A, 1.0, True, True, go=True, pause=True), P, DT)
    assert (after.phase, said.command, said.event) == (Phase.IDLE, None, "")
    assert Inputs(A, 1.0, True, True) == Inputs(A, 1.0, True, True, False, False)


@pytest.mark.parametrize(("armed", "centred"), [(False, True), (True, False), (False, False)])
def test_it_waits_for_deadman_and_centred_sticks_for_its_patience_only(armed, centred):
    rig = Rig(OUT)
    assert rig.to(Phase.PAUSED, armed=armed, centred=centred) == pytest.approx(PATIENCE, abs=2 * DT)
    assert rig.command == NO_COMMAND
    assert rig.events[-1] == "paused: nobody held the deadman with centred sticks within 10 s"
    rig.step()
    assert rig.state.phase == Phase.PAUSED


def test_a_person_who_resumes_is_waited_for_as_long_as_at_first():
    rig = Rig(OUT)
    rig.to(Phase.PAUSED, armed=False)
    rig.step(go=True)
    assert (rig.state.phase, rig.state.cause, rig.state.elapsed) == (Phase.WAITING, "", 0.0)
    assert rig.to(Phase.PAUSED, armed=False) == pytest.approx(PATIENCE, abs=2 * DT)


def test_the_times_of_waiting_add_up_and_the_step_at_the_patience_itself_still_waits():
    rig = Rig(OUT)
    rig.step(dt=PATIENCE, armed=False)
    assert rig.state.phase == Phase.WAITING
    rig.step(armed=False)
    assert rig.state.phase == Phase.PAUSED
    assert rig.state.elapsed == 0.0


def test_a_pause_while_it_waits_says_no_command():
    rig = Rig(OUT)
    said = rig.step(pause=True)
    assert (rig.state.phase, said.event, said.command) == (Phase.PAUSED, "paused: asked for", None)


def test_a_cycle_goes_from_step_to_step_each_segment_is_told_once_and_a_run_keeps_its_number():
    hold = Hold(3, "take", Grapple("take", "close", 0.5))
    legs = leg(1, "way", [A, B], 0.2, P), leg(1, "way", [B, C], 0.2, P), leg(4, "on", [C, A], 0.2, P)
    rig = Rig(*legs[:2], hold, legs[2])
    rig.to(Phase.RUNNING)
    number = rig.state.run
    assert number == rig.time
    rig.to(Phase.HOLDING)
    assert rig.state.run == number
    assert rig.command == NO_COMMAND
    assert rig.to(Phase.WAITING) == pytest.approx(0.5, abs=2 * DT)
    rig.to(Phase.FINISHED)
    assert rig.runs[-2] > number  # waited for the deadman again: another run
    assert rig.events == [
        "segment way",
        "take: grapple close, for 0.5 s",
        "segment on",
        "finished",
    ]
    assert math.dist(rig.tip, A) < NEAR


def test_two_segments_without_a_hold_between_them_are_one_run_and_both_are_told():
    rig = running(OUT, BACK_HOME)
    number = rig.state.run
    rig.until(lambda state: state.at == 1)
    assert (rig.state.phase, rig.state.run, rig.state.speed) == (Phase.RUNNING, number, 0.0)
    assert rig.command == piece(Place(BACK_HOME), LEAST)
    rig.to(Phase.FINISHED)
    assert rig.events == ["segment out", "segment home", "finished"]
    assert rig.command == NO_COMMAND


def test_a_cycle_of_one_segment_tells_it():
    assert Rig(OUT).events == ["segment out"]


def test_a_cycle_may_begin_with_the_grapple():
    rig = Rig(Hold(1, "let", Grapple("let", "open", 0.3)), BACK_HOME, tip=B)
    assert rig.state.phase == Phase.HOLDING
    assert rig.to(Phase.WAITING) == pytest.approx(0.3, abs=2 * DT)
    assert rig.events == ["let: grapple open, for 0.3 s", "segment home"]


def test_a_hold_that_waits_for_a_person_waits_for_ever_and_a_person_may_end_one_with_a_time():
    rig = Rig(Hold(1, "take", Grapple("take", "close")), OUT)
    rig.step(dt=3600.0)
    assert rig.state.phase == Phase.HOLDING
    rig.step(go=True)
    assert rig.state.phase == Phase.WAITING
    rig = Rig(Hold(1, "take", Grapple("take", "close", 0.5)), OUT)
    rig.step(dt=0.5)  # the time itself is enough
    assert rig.state.phase == Phase.WAITING
    rig = Rig(Hold(1, "take", Grapple("take", "close", 5.0)), OUT)
    rig.step(go=True)
    assert rig.state.phase == Phase.WAITING


def test_a_leg_begins_and_ends_with_its_ramp_and_has_its_speed_between():
    rig = running(OUT)
    assert rig.state.speed == 0.0
    speeds = []
    while rig.state.phase == Phase.RUNNING and rig.state.near == 0.0:
        rig.step()
        speeds.append(rig.state.speed)
    assert speeds[0] == LEAST
    rising = [v for v in speeds[:80] if LEAST < v < 0.199]
    assert np.diff(rising) == pytest.approx(RAMP * DT)
    assert max(speeds) == pytest.approx(0.2)
    assert min(speeds[80:]) == pytest.approx(0.1, abs=0.005)  # braked until it is near: v^2 = 2 RAMP NEAR
    assert rig.to(Phase.FINISHED) == pytest.approx(SETTLED, abs=3 * DT)


def test_it_leads_a_tip_from_rest_however_short_the_way_between_two_stops_is():
    """At the stop itself a leg allows nothing: its speed a step further is asked for, at most half way."""
    ways, square = np.array([0.0, 0.004, 0.01]), np.array([0.0, 0.01, 0.04])
    one, _, _ = oblique(0.01)
    short = Rig(one._replace(ways=ways, square=square))
    short.to(Phase.RUNNING)
    short.state = short.state._replace(speed=1.0)
    short.step(stands=True)
    assert short.state.speed == pytest.approx(math.sqrt(np.interp(0.005, ways, square)))
    long, _, _ = oblique(1.0)
    rig = Rig(long._replace(ways=np.array([0.0, 0.5, 1.0]), square=np.array([0.0, 1.0, 0.0])))
    rig.to(Phase.RUNNING)
    rig.state = rig.state._replace(speed=1.0)
    rig.step(stands=True)
    assert rig.state.speed == pytest.approx(math.sqrt(0.02))


def test_a_pause_brakes_the_tip_along_its_path_and_then_a_person_resumes():
    rig = running(OUT, seconds=1.0)
    before = rig.state.speed
    rig.step(pause=True)
    assert rig.state.speed == pytest.approx(before - BRAKE * DT)
    assert rig.to(Phase.PAUSED) == pytest.approx((before - LEAST) / BRAKE, abs=3 * DT)
    assert rig.command == NO_COMMAND
    assert (rig.state.cause, rig.state.pausing) == ("asked for", False)
    place = rig.state.place
    rig.step()
    assert rig.state.phase == Phase.PAUSED
    rig.step(go=True)
    rig.step()
    assert (rig.state.phase, rig.state.back, rig.state.place) == (Phase.RUNNING, None, place)
    rig.step()
    assert rig.state.speed == LEAST
    rig.to(Phase.FINISHED)


@pytest.mark.parametrize(
    ("interrupted", "cause"),
    [
        ({"armed": False}, "the deadman was released, or the crane was stopped"),
        ({"centred": False}, "a stick moved"),
        ({"dt": GAP + 0.001}, "the player was held up for 0.1 s"),
    ],
)
def test_deadman_stick_or_a_gap_end_a_run_at_once_and_say_so(interrupted, cause):
    rig = running(OUT, seconds=1.0)
    said = rig.step(**interrupted)
    assert (rig.state.phase, rig.state.cause, said.command) == (Phase.PAUSED, cause, NO_COMMAND)
    assert said.event == f"paused: {cause}"
    rig = running(OUT, seconds=1.0)
    rig.step(dt=GAP)
    assert rig.state.phase == Phase.RUNNING


def test_a_tip_that_is_not_where_it_is_led_ends_the_run():
    for beside, phase in ((FARTHEST - 0.001, Phase.RUNNING), (FARTHEST + 0.001, Phase.PAUSED)):
        one, _, across = oblique(1.0)
        rig = running(one, seconds=1.0)
        rig.tip = tuple(np.array(one.path.at(rig.state.place.way)) + beside * across)
        rig.step()
        assert rig.state.phase == phase
    assert rig.state.cause == "the tip is too far from the path"


def test_where_the_tip_does_not_get_on_the_run_ends_and_progress_is_no_creeping():
    rig = running(OUT, seconds=1.0)
    assert rig.to(Phase.PAUSED, stands=True) == pytest.approx(STUCK, abs=4 * DT + PROGRESS / 0.2)
    assert rig.state.cause == "the tip does not get on: a limit, the joint scheme, or a fault"
    one, _, _ = oblique(1.0)
    for creep, progress in ((0.95, False), (1.05, True)):
        rig = running(one, seconds=1.0)
        rig.state = rig.state._replace(place=Place(one, rig.state.reached), stuck=1.0)
        rig.tip = one.path.at(rig.state.reached + creep * PROGRESS)
        rig.step(stands=True)
        assert rig.state.stuck == (0.0 if progress else 1.0 + DT)


def test_time_without_progress_counts_from_the_last_progress():
    rig = running(OUT, seconds=1.0)
    rig.until(lambda state: state.stuck > 0.9 * STUCK, stands=True)
    rig.until(lambda state: state.stuck == 0.0)
    rig.step(stands=True)
    assert rig.to(Phase.PAUSED, stands=True) > 0.9 * STUCK


def test_an_arrival_is_to_have_been_near_without_a_break():
    one, along, _ = oblique(0.3)
    rig = running(one, seconds=0.5)
    end = np.array(one.path.at(0.3))
    rig.tip = tuple(end - 0.9 * NEAR * along)
    for _ in range(round((SETTLED - 0.1) / DT)):
        rig.step(stands=True)
    assert (rig.state.phase, rig.state.stuck) == (Phase.RUNNING, 0.0)
    rig.tip = tuple(end - 1.1 * NEAR * along)
    rig.step(stands=True)
    assert rig.state.near == 0.0
    rig.tip = tuple(end - 0.9 * NEAR * along)
    assert rig.to(Phase.FINISHED, stands=True) == pytest.approx(SETTLED, abs=3 * DT)


def test_a_corner_is_a_stop_from_which_the_leg_goes_on():
    rig = running(BOTH)
    corner = BOTH.path.stops[1]
    rig.until(lambda state: state.place.stop == 2)
    assert rig.state.place.way == corner
    assert (rig.state.speed, rig.state.near, rig.state.stuck, rig.state.reached) == (0.0, 0.0, 0.0, -math.inf)
    assert rig.command.speed == LEAST
    assert math.dist(rig.tip, B) < NEAR
    before = np.array(rig.command.tangent)
    assert before @ (np.subtract(C, B) / math.dist(B, C)) == pytest.approx(1.0)
    rig.to(Phase.FINISHED)
    assert math.dist(rig.tip, C) < NEAR


def test_after_the_levers_the_tip_goes_back_slowly_to_where_it_left():
    rig = running(OUT, seconds=1.5)
    rig.step(centred=False)
    place = rig.state.place
    left_at = place.leg.path.at(place.way)
    rig.tip = (left_at[0], left_at[1] + 0.3, left_at[2])
    rig.step(go=True)
    rig.to(Phase.RUNNING)
    assert rig.state.back is not None
    assert rig.state.back.leg.name == "way back to out"
    assert rig.state.place == place
    speeds = []
    while rig.state.back is not None:
        rig.step()
        speeds.append(rig.state.speed)
        assert rig.state.phase == Phase.RUNNING
        assert rig.state.place == place
    assert max(speeds) == pytest.approx(BACK)
    assert math.dist(rig.tip, left_at) < NEAR
    assert rig.command == piece(place, LEAST)
    rig.to(Phase.FINISHED)
    assert math.dist(rig.tip, B) < NEAR


def test_a_way_back_that_cannot_be_gone_is_refused_in_a_sentence():
    rig = running(OUT, seconds=1.0)
    rig.step(centred=False)
    rig.tip = (0.0, 0.0, 3.0)
    rig.step(go=True)
    rig.step()
    assert rig.state.phase == Phase.PAUSED
    assert "way back to out" in rig.state.cause


@pytest.mark.parametrize(("off", "back"), [(0.019, False), (0.021, True)])
def test_near_its_leg_the_tip_needs_no_way_back(off, back):
    rig = Rig(OUT, tip=(A[0], A[1] - off, A[2]))
    rig.to(Phase.RUNNING)
    assert (rig.state.back is not None) == back


def test_where_the_path_is_beside_the_tip_is_found_whatever_its_direction():
    one, along, across = oblique(1.0)
    rig = running(one, seconds=1.0)
    way = rig.state.place.way
    rig.tip = tuple(np.array(one.path.at(way)) + 0.013 * along + 0.02 * across)
    rig.step(stands=True)
    assert rig.state.place.way == pytest.approx(way + 0.013)
    rig.tip = tuple(np.array(one.path.at(way)) - 0.007 * along)
    rig.step(stands=True)
    assert rig.state.place.way == pytest.approx(way - 0.007)


def test_the_place_stays_between_the_stop_before_and_the_next():
    one, along, _ = oblique(1.0, stops=(0.0, 0.3, 0.7, 1.0))
    rig = Rig(one)
    rig.to(Phase.RUNNING)
    for stop, way, ahead, kept in ((2, 0.69, 0.05, 0.7), (2, 0.31, -0.05, 0.3), (1, 0.01, -0.05, 0.0)):
        rig.state = rig.state._replace(place=Place(one, way, stop))
        rig.tip = tuple(np.array(one.path.at(way)) + ahead * along)
        rig.step(stands=True)
        assert rig.state.place.way == pytest.approx(kept)
        assert rig.state.place.stop == stop


def test_a_piece_of_a_line_is_the_line():
    one, along, _ = oblique(1.0)
    told = piece(Place(one, 0.4), 0.15)
    assert told == TaughtCommand(
        pytest.approx(one.path.at(0.4)),
        pytest.approx(tuple(along)),
        pytest.approx((0.0, 0.0, 0.0), abs=1e-9),
        0.15,
        pytest.approx(0.6),
    )


@pytest.mark.parametrize("radius", [0.3, 2.0])
def test_a_piece_of_a_circle_has_its_direction_and_curvature(radius):
    one, along, across = oblique(0.5, radius)
    told, angle = piece(Place(one, 0.2), 0.15), 0.2 / radius
    tangent = math.cos(angle) * along + math.sin(angle) * across
    curvature = (math.cos(angle) * across - math.sin(angle) * along) / radius
    assert told.place == pytest.approx(one.path.at(0.2))
    assert told.tangent == pytest.approx(tuple(tangent), abs=1e-9)
    assert told.curvature == pytest.approx(tuple(curvature), rel=3.0 * (BASE / radius) ** 2, abs=1e-9)


def test_near_a_stop_a_piece_is_measured_where_there_is_room():
    """The place told lies a base off, and what is left counts from there."""
    one, _, _ = oblique(1.0, stops=(0.0, 0.3, 0.7, 1.0))
    for way, at in ((0.3, 0.3 + BASE), (0.7, 0.7 - BASE), (0.5, 0.5)):
        told = piece(Place(one, way, 2), 0.1)
        assert told.place == pytest.approx(one.path.at(at))
        assert told.left == pytest.approx(0.7 - at)
    short, _, _ = oblique(0.01)
    told = piece(Place(short, 0.0), 0.1)
    assert told.place == pytest.approx(short.path.at(0.005))
    assert told.left == pytest.approx(0.005)
    last, _, _ = oblique(0.31, stops=(0.0, 0.3, 0.31))
    assert piece(Place(last, 0.3, 2), 0.1).place == pytest.approx(last.path.at(0.305))


def test_from_a_stop_the_speed_is_asked_for_no_farther_than_half_way_to_the_next():
    one, _, _ = oblique(0.308, stops=(0.0, 0.3, 0.308))
    one = one._replace(ways=np.array([0.0, 0.3, 0.304, 0.308]), square=np.array([0.0, 0.0, 0.01, 0.0]))
    state = State(Phase.RUNNING, (one,), place=Place(one, 0.3, 2), speed=0.08)
    state, _ = step(state, Inputs(one.path.at(0.3), 1.0, True, True), P, DT)
    assert 0.08 < state.speed <= 0.1


def test_a_hairpin_is_told_no_sharper_than_the_controller_believes():
    """Of a circle of 3 cm the true curvature is 33 1/m; a base of 4 cm is most of it."""
    one, _, _ = oblique(0.1, 0.03)
    size = math.hypot(*piece(Place(one, 0.05), 0.1).curvature)
    assert size == pytest.approx(SHARPEST / 1.001)
    one, _, _ = oblique(0.1, 0.1)
    assert 9.0 < math.hypot(*piece(Place(one, 0.05), 0.1).curvature) < 10.0
