"""What lets the crane move, and each cause that stops it: its verdict, how soon, and how it goes on."""

import math

import pytest
from guard_rig import ANGLES, PERIOD_NS, PUSHED, P, Rig, hangs, nonsense

from forest_control.operator.levers import REST, Levers
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_guard import GOES_BACK, LOST_STATE, NOT_CENTRED, PRESSED, MotionGuard
from forest_control.safety.motion_permission import (
    NOBODY,
    Cause,
    MachineState,
    Override,
    Permission,
    PermissionParameters,
    Verdict,
    armed_watch,
    decide,
    reset_sensor_watch,
)
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

STATE_TIMEOUT, JOY_TIMEOUT, FROZEN_TIMEOUT = 0.1, 0.15, 10.0  # [s] as docs/safety.md tells


@pytest.fixture
def rig():
    return Rig().moving()


def set_to(**values):
    def broken(rig):
        for name, value in values.items():
            setattr(rig, name, value)

    return broken


# What happens, how it is broken, the verdict, after how long [s], its cause, and what is said.
CAUSES = {
    "state left over from a stall": (set_to(lag=0.101), Verdict.SKIP, 0.0, Cause.LEFT_OVER, ""),
    "stamp goes back": (
        set_to(stamp=lambda k: (k - 99) * PERIOD_NS),
        *(Verdict.SKIP, 0.0, Cause.DISORDER, "stamp goes back by"),
    ),
    "stamp stands still": (
        set_to(stamp=lambda _: 20_100 * PERIOD_NS),
        *(Verdict.SKIP, PERIOD, Cause.DISORDER, "stands still"),
    ),
    "state too soon": (
        set_to(stamp=lambda k: 20_004 * PERIOD_NS + k),
        *(Verdict.SKIP, 0.0, Cause.TOO_SOON, ""),
    ),
    "state cannot be read": (
        set_to(problem="joint state: none"),
        *(Verdict.STOP, 0.0, Cause.UNBELIEVABLE, "joint state: none"),
    ),
    "state cannot be true": (
        set_to(angles=(0.2, 40.0, -1.5)),
        *(Verdict.STOP, 0.0, Cause.UNBELIEVABLE, "boom is 40 rad; allowed"),
    ),
    "an angle jumps": (
        set_to(angles=(ANGLES[0], ANGLES[1] + 0.05, ANGLES[2])),
        *(Verdict.STOP, 0.0, Cause.UNBELIEVABLE, "boom jumps by 0.05"),
    ),
    "sensors frozen": (
        set_to(shakes=False),
        *(Verdict.STOP, 0.15, Cause.FAULT, "swing is the same to the last bit"),
    ),
    "driver silent": (
        set_to(driver_speaks=False),
        *(Verdict.STOP, 0.2, Cause.FAULT, "valve driver: no voltages"),
    ),
    "driver deaf": (
        set_to(volts=ZERO, rates=ZERO),
        *(Verdict.STOP, 1.5, Cause.FAULT, "valve driver: keeps the valves shut"),
    ),
    "emergency stop": (
        set_to(override=Override(emergency_stop=True)),
        *(Verdict.STOP, 0.0, Cause.EMERGENCY_STOP, PRESSED),
    ),
    "hands off": (set_to(override=Override(hands_off=True)), Verdict.STOP, 0.0, Cause.HANDS_OFF, ""),
    "deadman released": (set_to(held=False), Verdict.CONTROLLED_STOP, 0.0, Cause.OPERATOR, ""),
    "joystick lost": (
        set_to(speak=lambda: None),
        *(Verdict.CONTROLLED_STOP, JOY_TIMEOUT, Cause.OPERATOR, "joystick: nothing new"),
    ),
    "joystick hangs": (
        hangs,
        *(Verdict.CONTROLLED_STOP, FROZEN_TIMEOUT, Cause.OPERATOR, "joystick: held still to the last bit"),
    ),
    "joystick cannot be read": (nonsense, Verdict.CONTROLLED_STOP, 0.0, Cause.OPERATOR, "joy: nonsense"),
}


@pytest.mark.parametrize(("broken", "verdict", "after", "cause", "said"), CAUSES.values(), ids=CAUSES)
def test_each_cause_has_its_verdict_in_its_time_and_is_named(rig, broken, verdict, after, cause, said):
    broken(rig)
    decision, when = rig.until(verdict, after)
    assert when == pytest.approx(after, abs=1.01 * PERIOD)
    assert (decision.verdict, decision.cause) == (verdict, cause)
    assert decision.levers == REST
    told = "; ".join(filter(None, rig.guard.causes.values()))
    assert said in told
    assert bool(told) == bool(said)


STOPS = {name: cause for name, cause in CAUSES.items() if cause[1] in (Verdict.STOP, Verdict.CONTROLLED_STOP)}
REFUSED = ("state cannot be read", "state cannot be true", "an angle jumps")


@pytest.mark.parametrize("name", STOPS)
def test_what_has_stopped_the_crane_is_forgotten_once_a_person_has_acted(rig, name):
    """Centring is enough but behind a broken sensor.

    A lone refusal of a state is not felt: one bad sample of many would throw the operator out.
    """
    well = dict(vars(rig), speak=rig.sample)
    del well["step"], well["heard"]
    broken, verdict, after, _, _ = STOPS[name]
    broken(rig)
    rig.until(verdict, after)
    set_to(**well)(rig)
    rig.step += 1
    if name == "sensors frozen":
        rig.guard.permission = reset_sensor_watch(rig.guard.permission)  # as the controller does that stops
    again = rig.once()
    if name in REFUSED:
        assert again.verdict == Verdict.MOVE
        return
    assert again.verdict == Verdict.CONTROLLED_STOP
    assert rig.once().verdict == Verdict.CONTROLLED_STOP
    rig.levers = REST
    if name == "sensors frozen":  # centred sticks, as taught work's are all the time, are no act
        assert {rig.once().verdict for _ in range(50)} == {Verdict.CONTROLLED_STOP}
        assert rig.guard.causes["machine"] == "machine: a fault is over; allowed: release the deadman"
        rig.held = False
        rig.once()
        rig.held = True
        assert rig.until(Verdict.MOVE, 0.1)[0].levers == REST
        assert rig.guard.causes["machine"] == ""
    assert rig.until(Verdict.MOVE, 0.1)[0].levers == REST
    rig.levers = PUSHED
    assert rig.once().verdict == Verdict.MOVE


def test_without_a_joystick_it_holds_and_misses_nobody():
    rig = Rig()
    rig.speak = lambda: None
    for _ in range(100):
        decision = rig.once()
        assert decision[:3] == (Verdict.CONTROLLED_STOP, Cause.OPERATOR, True)
        assert not any(rig.guard.causes.values())
    assert rig.guard.is_nobody_there()


def test_the_deadman_pressed_with_deflected_levers_moves_nothing():
    rig = Rig()
    rig.levers = PUSHED
    assert {rig.once().verdict for _ in range(100)} == {Verdict.CONTROLLED_STOP}


def test_with_the_deadman_released_centred_levers_arm_nothing():
    rig = Rig()
    rig.held = False
    assert {rig.once().verdict for _ in range(10)} == {Verdict.CONTROLLED_STOP}
    assert not rig.guard.permission.joystick.armed


def test_a_joystick_that_cannot_be_read_is_known_as_such(rig):
    nonsense(rig)
    rig.once()
    assert rig.guard.joystick_values()["state"] == "bad"


def test_only_a_state_that_is_believed_is_handed_on(rig):
    assert rig.once().believed
    rig.override = Override(emergency_stop=True)
    decision = rig.once()
    assert decision.believed  # where the tip is, is told
    assert decision.dt == pytest.approx(PERIOD)
    rig.angles = (0.2, math.nan, -1.5)
    decision = rig.once()
    assert (decision.believed, decision.dt) == (False, 0.0)


def test_an_angle_that_stays_where_it_jumped_to_is_believed_once_the_state_was_lost_and_disarms(rig):
    rig.angles = ANGLES[0], ANGLES[1] + 0.05, ANGLES[2]
    refused = []
    for _ in range(40):
        rig.guard.is_lost(rig.now + PERIOD, NOBODY)  # as the controller asks before each state
        refused.append(rig.once().cause == Cause.UNBELIEVABLE)
    assert refused.index(False) * PERIOD == pytest.approx(STATE_TIMEOUT, abs=1.5 * PERIOD)
    assert not any(refused[refused.index(False) :])
    assert not rig.guard.permission.joystick.armed


@pytest.mark.parametrize("late", [0.03, 0.09])
def test_after_a_gap_an_angle_may_have_gone_as_far_as_in_its_time(rig, late):
    """By the clock, where there is no stamp; by the stamps, where states come at once."""
    before = rig.guard.permission

    def believed(moved, stamp, received):
        there = before.angles[0] + moved, before.angles[1], before.angles[2]
        state, driver = MachineState(there, ZERO, stamp, received), DriverSample(ZERO, received)
        _, one = decide(before, state, driver, ZERO, P, rig.guard.p, received, NOBODY)
        return one.cause != Cause.UNBELIEVABLE

    then, stamp = before.received, before.order.newest
    for when in ((0, then + late), (stamp + round(1e9 * late), then)):
        assert believed(5.0 * late + 0.0049, *when)
        assert not believed(5.0 * late + 0.0051, *when)
    assert believed(5.0 * PERIOD + 0.0049, 0, then)
    assert not believed(5.0 * PERIOD + 0.0051, 0, then)
    assert believed(1.0, 0, then + 0.101)


def test_a_state_that_does_not_come_is_missed_at_its_timeout_and_disarms(rig):
    seen = rig.now
    assert not rig.guard.is_lost(seen + STATE_TIMEOUT, NOBODY)
    assert rig.guard.permission.joystick.armed
    assert rig.guard.is_lost(seen + STATE_TIMEOUT + 1e-6, NOBODY)
    assert not rig.guard.permission.joystick.armed
    assert rig.guard.causes["machine"] == LOST_STATE


def test_while_the_state_is_lost_what_is_wrong_with_the_joystick_is_told_if_it_is_missed(rig):
    later = rig.now + JOY_TIMEOUT + STATE_TIMEOUT
    assert rig.guard.is_lost(later, NOBODY)
    assert rig.guard.causes["joystick"]
    assert not rig.guard.is_nobody_there()
    rig.held = False
    rig.once()
    assert not rig.guard.is_nobody_there()
    assert rig.guard.is_lost(rig.now + JOY_TIMEOUT + STATE_TIMEOUT, NOBODY)
    assert rig.guard.is_nobody_there()  # it went after the deadman was released
    assert not rig.guard.causes["joystick"]


def test_of_states_that_are_refused_the_cause_is_told_and_not_what_follows_from_it(rig):
    rig.problem = "joint state: none"
    for _ in range(30):
        rig.once()
    assert rig.guard.is_lost(rig.now, NOBODY)
    assert rig.guard.causes["machine"] == "joint state: none"
    assert rig.guard.is_lost(rig.now + STATE_TIMEOUT + 1e-6, NOBODY)
    assert rig.guard.causes["machine"] == LOST_STATE


def test_before_the_first_state_none_is_missed():
    guard = MotionGuard(PermissionParameters())
    assert not guard.has_begun()
    assert not guard.is_lost(1e9, NOBODY)


def test_a_joystick_that_goes_on_sending_is_not_waited_for_though_its_hand_is_late():
    guard = MotionGuard(PermissionParameters())
    assert guard.is_nobody_there()
    assert [guard.misses_joystick(age) for age in (0.02, 0.9, 1.1, math.inf)] == [False, False, True, True]


def test_a_joystick_whose_deadman_is_held_is_lost_rather_than_waited_for(rig):
    rig.moving()
    assert not rig.guard.misses_joystick(math.inf)


def test_a_joystick_stamp_that_goes_back_moves_nothing_new_and_is_told(rig):
    rig.speak = lambda: rig.sample()._replace(stamp=PERIOD_NS, levers=Levers(-1.0, 0.0, 0.0))
    decision = rig.once()
    assert decision.levers.swing > 0.0
    assert rig.guard.causes["joystick"] == GOES_BACK


def test_levers_of_a_slow_joystick_go_in_lines_from_sample_to_sample():
    rig = Rig()
    rig.speak = lambda: rig.sample() if rig.step % 10 == 0 else None
    for _ in range(100):
        rig.once()
    rig.levers = PUSHED
    seen = [rig.once().levers.swing for _ in range(60)]
    assert seen[0] == 0.0
    assert seen[-1] == PUSHED.swing
    assert sum(0.0 < swing < PUSHED.swing for swing in seen) >= 8


def test_a_reset_needs_centred_levers_and_the_deadman_released(rig):
    said = "the levers must be centred and the deadman released"
    assert rig.guard.against_reset() == said
    assert rig.guard.joystick_caution() == ""
    rig.levers = REST
    rig.once()
    assert rig.guard.against_reset() == said
    rig.held = False
    rig.once()
    assert rig.guard.against_reset() == ""
    assert rig.guard.joystick_values()["state"] == "alive"


def lifts(rig, rate, seconds):
    """Have the boom go at a rate [rad/s] under a valve that is wide open; return the last decision."""
    rig.volts, rig.command, rig.rates = (0.0, 9.0, 0.0), (0.0, 3.0, 0.0), (0.0, rate, 0.0)
    for _ in range(round(seconds / PERIOD)):
        decision = rig.once()
    return decision


def test_a_load_that_drives_a_joint_back_stops_the_crane_until_the_deadman_was_let_go(rig):
    assert lifts(rig, 0.2, 0.2).verdict == Verdict.MOVE  # it goes as commanded: the file is right
    rig.rates = (0.0, -0.2, 0.0)
    decision, after = rig.until(Verdict.STOP, 0.2)
    assert 0.01 < after < 0.15  # one sample alone proves nothing
    assert (decision.cause, decision.believed, decision.overloaded) == (Cause.OVERLOAD, True, True)
    assert rig.guard.causes["machine"].startswith("overload: boom went back ")
    rig.rates, rig.volts, rig.command, rig.levers = ZERO, ZERO, ZERO, REST
    for _ in range(100):  # centred levers alone, as in taught work, are no act of a person
        waiting = rig.once()
        assert (waiting.verdict, waiting.cause, waiting.overloaded) == (
            Verdict.CONTROLLED_STOP,
            Cause.OVERLOAD,
            True,
        )
        assert waiting.believed  # the tip is held where it is
    rig.held = False
    let_go = rig.once()
    assert (let_go.verdict, let_go.cause, let_go.overloaded) == (
        Verdict.CONTROLLED_STOP,
        Cause.OPERATOR,
        True,
    )
    rig.held = True
    moves = rig.once()
    assert (moves.verdict, moves.overloaded) == (Verdict.MOVE, False)
    assert rig.guard.causes["machine"] == ""


def test_a_joint_that_goes_by_itself_stops_the_crane_and_names_it_while_it_goes(rig):
    rig.volts, rig.command, rig.rates = ZERO, ZERO, (0.0, 0.0, -0.3)
    decision, after = rig.until(Verdict.STOP, 1.5)
    assert after == pytest.approx(1.17, abs=3.0 * PERIOD)  # 50 mrad, and what 0.3 rad/s makes in a second
    assert (decision.cause, decision.believed) == (Cause.FAULT, False)
    assert rig.guard.causes["machine"].startswith("machine: stick goes by itself")
    rig.rates = ZERO
    assert (
        rig.once().verdict == Verdict.CONTROLLED_STOP
    )  # the levers were not centred since, nor the deadman let go
    assert rig.guard.causes["machine"] == "machine: a fault is over; allowed: release the deadman"


def test_in_shadow_where_no_driver_has_ever_spoken_a_joint_that_goes_is_no_runaway():
    rig = Rig()
    rig.driver_speaks, rig.volts, rig.command = False, ZERO, ZERO
    rig.moving()
    rig.rates = (0.0, 0.0, -0.3)
    assert {rig.once().verdict for _ in range(400)} == {Verdict.MOVE}


def test_sensors_without_noise_are_not_judged_by_standing_still(rig):
    stuck = rig
    stuck.shakes = False
    assert stuck.until(Verdict.STOP, 0.5)[0].cause == Cause.FAULT
    exact = Rig()
    exact.guard = MotionGuard(PermissionParameters(noise_free=True))
    exact.moving()
    exact.shakes = False
    assert {exact.once().verdict for _ in range(200)} == {Verdict.MOVE}


def test_a_loop_begins_with_the_deadman_held_and_the_levers_centred():
    watch = armed_watch()
    assert (watch.armed, watch.held, watch.levers) == (True, True, REST)
    assert (watch.fresh_since, watch.moved) == (-PERIOD, -PERIOD)
    assert (watch.heartbeat, watch.repeats) == (0, False)
    state = MachineState(ANGLES, ZERO, PERIOD_NS, 0.0)
    pushed = watch._replace(levers=PUSHED)
    _, decision = decide(
        Permission(joystick=pushed), state, DriverSample(), ZERO, P, PermissionParameters(), 0.0, NOBODY
    )
    assert decision.verdict == Verdict.MOVE


def test_no_two_verdicts_or_causes_are_one():
    """Members of an enumeration with equal numbers would be the same."""
    assert [int(verdict) for verdict in Verdict] == [0, 1, 2, 3]
    assert [int(cause) for cause in Cause] == list(range(10))


def test_nobody_is_asked_for_centred_levers_while_the_emergency_stop_is_pressed(rig):
    rig.levers = PUSHED
    for _ in range(10):
        rig.once()
    rig.held = False
    rig.once()
    rig.held = True
    rig.once()
    assert rig.guard.joystick_caution() == NOT_CENTRED
    rig.guard.causes["emergency stop"] = PRESSED
    assert rig.guard.joystick_caution() == ""
