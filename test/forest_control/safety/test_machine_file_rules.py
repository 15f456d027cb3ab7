"""What a machine's first samples say of its file: rules and their bounds, by hand-made samples."""

import math

import pytest
from unlike_joints import BACKWARD, FORWARD, UNLIKE, at

from forest_control.config import controller_settings
from forest_control.limits.load_weighing import UNREAD as NO_PRESSURES
from forest_control.safety import machine_answers, machine_file_check
from forest_control.safety.machine_answers import NO_ANSWERS, Answers
from forest_control.safety.machine_file_check import (
    PROVEN,
    STRANGE,
    FileCheck,
    is_wrong,
    objection,
    updated_check,
)
from forest_control.safety.overloaded_joint import Overload, commanded_rates
from forest_control.servo.joint_angle_filter import UNREAD
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

C180 = load_machine("c180_hoses")
P = controller_settings.parameters(C180, controller_settings.Settings())
ANGLES = (0.0, 0.5, -1.4)
LONG_OPEN = (9.0, 9.0, 9.0)  # [s] for which valves have been open
NO_OVERLOAD = Overload(open_time=LONG_OPEN)
FITTING = cylinder_length(ANGLES[1], P.linkages[0]), cylinder_length(ANGLES[2], P.linkages[1])


def after(
    check, seconds, rates=ZERO, command=ZERO, lengths=UNREAD, overload=NO_OVERLOAD, opens=1.0,
    pressures=NO_PRESSURES,
):  # fmt: skip
    voltages = tuple(opens * (volts + math.copysign(1.1, volts)) if volts else 0.0 for volts in command)
    for _ in range(round(seconds / PERIOD)):
        u = commanded_rates(ANGLES, command, P)
        check = updated_check(
            check, ANGLES, rates, lengths, u, voltages, overload, pressures, math.nan, P, PERIOD
        )
    return check


def test_lengths_that_do_not_fit_are_borne_for_a_moment_and_once_they_have_fitted_for_ever():
    strange = FITTING[0], 1.1 * FITTING[1]
    assert not is_wrong(after(FileCheck(), STRANGE - 2.0 * PERIOD, lengths=strange))
    wrong = after(FileCheck(), STRANGE + 2.0 * PERIOD, lengths=strange)
    assert objection(wrong).startswith("machine file: the length of the stick's cylinder")
    assert is_wrong(after(wrong, 1.0, lengths=FITTING))
    once = after(FileCheck(), PERIOD, lengths=FITTING)
    assert not is_wrong(after(once, 10.0, lengths=strange))
    assert not is_wrong(after(FileCheck(), 10.0))


def off(angle):
    """Lengths that belong to a boom's angle [rad] elsewhere than it is."""
    return cylinder_length(ANGLES[1] + angle, P.linkages[0]), FITTING[1]


def test_lengths_that_are_off_by_less_than_a_broken_transducer_s_are_found_in_any_pose():
    fitted, long = after(FileCheck(), PERIOD, lengths=FITTING), STRANGE + 2.0 * PERIOD
    assert not is_wrong(after(fitted, 10.0, lengths=off(0.028)))
    assert after(fitted, long, lengths=off(0.032)).wrong == machine_file_check.BOOM
    assert not is_wrong(after(fitted, STRANGE - 2.0 * PERIOD, lengths=off(0.032)))
    assert after(FileCheck(), long, lengths=off(-0.032)).wrong == machine_file_check.BOOM
    assert not is_wrong(after(fitted, 10.0, lengths=off(0.102)))  # it is broken
    hung = after(fitted, long, lengths=off(0.032))
    assert not is_wrong(after(hung, PERIOD, lengths=FITTING))
    assert is_wrong(after(after(FileCheck(), long, lengths=off(0.032)), 10.0, lengths=FITTING))
    assert is_wrong(after(FileCheck(), long, lengths=(9.0, FITTING[1])))  # of no angle


@pytest.mark.parametrize("joint", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_has_proven_right_is_not_asked_again(joint, side):
    def of(value):
        return tuple(value if i == joint else 0.0 for i in range(3))

    against = {"rates": of(-0.05 * side), "command": of(3.0 * side)}
    long = (PROVEN + 0.001) / 0.05
    assert not is_wrong(after(FileCheck(), long - 0.1, **against))
    assert after(FileCheck(), long, **against).wrong == machine_file_check.POLARITY + joint
    proven = after(FileCheck(), long, of(0.05 * side), of(3.0 * side))
    assert not is_wrong(after(proven, 5.0, **against))
    assert not is_wrong(after(FileCheck(), 5.0, of(-0.05 * side), of(1e-3 * side)))  # it only feeds leakage
    held = {
        "rates": of(-0.01 * side),
        "command": of((0.04, 0.09, 0.11)[joint] * side),
    }  # against what rocks it
    assert not is_wrong(after(FileCheck(), 5.0, **held))
    # Nobody has opened a valve: the hydraulics are off, or the controller only looks on.
    assert not is_wrong(after(FileCheck(), 60.0, **against, opens=0.0))


def test_a_joint_that_sinks_before_it_has_proven_right_is_the_file_s():
    overload = Overload(agreement=(0.0, -1.0, 0.0))
    up = (0.0, 3.0, 0.0)
    assert after(FileCheck(), PERIOD, command=up, overload=overload).wrong == machine_file_check.POLARITY + 1
    assert not is_wrong(after(FileCheck(), PERIOD, overload=overload))  # others have the valves
    proven = FileCheck(ways=(PROVEN, PROVEN, PROVEN))
    assert not is_wrong(after(proven, PERIOD, command=up, overload=overload))


@pytest.mark.parametrize(("side", "fed"), [(1.0, 0), (-1.0, 1)])
def test_a_boom_that_a_load_presses_back_is_not_the_file_s(side, fed):
    supply = P.speed_limits.supply_pressure
    for share, wrong in ((0.89, True), (0.91, False)):
        pressures = tuple(share * supply if port == fed else supply for port in (0, 1))
        pressures = (
            pressures if share < 0.9 else tuple(pressures[port] if port == fed else 0.0 for port in (0, 1))
        )
        back = {"rates": (0.0, -0.05 * side, 0.0), "command": (0.0, 3.0 * side, 0.0), "pressures": pressures}
        assert is_wrong(after(FileCheck(), 0.4, **back)) == wrong


def test_what_a_load_has_pressed_a_boom_back_by_is_not_held_against_the_file_later():
    supply = P.speed_limits.supply_pressure
    pressed = after(FileCheck(), 1.0, (0.0, -0.05, 0.0), (0.0, 3.0, 0.0), pressures=(0.95 * supply, 0.0))
    assert not is_wrong(pressed)
    assert not is_wrong(after(pressed, 1.0, pressures=(0.5 * supply, 0.0)))  # it stands
    lowered = after(pressed, 1.0, (0.0, -0.05, 0.0), (0.0, -3.0, 0.0), pressures=(0.5 * supply, 0.0))
    assert not is_wrong(lowered)
    assert lowered.ways[1] == PROVEN


every_joint = pytest.mark.parametrize("joint", [0, 1, 2])


UNASKED = FileCheck()


def look(
    check=UNASKED, rates=ZERO, u=(0.1, 0.2, 0.3), voltages=(5.0, 5.0, 5.0), lengths=UNREAD,
    overload=NO_OVERLOAD, pressures=NO_PRESSURES, supply=math.nan,
):  # fmt: skip
    """One sample of a crane whose joints are unlike."""
    return updated_check(
        check, ANGLES, rates, lengths, u, voltages, overload, pressures, supply, UNLIKE, PERIOD
    )


def test_a_swing_that_goes_back_faster_than_its_valve_would_lead_it_is_pulled():
    """At most twice its commanded rate counts against the file; of other joints, and ahead, all."""
    ways = look(rates=(-0.5, -0.9, -0.9)).ways
    assert ways == pytest.approx((-0.2 * PERIOD, -0.9 * PERIOD, -0.9 * PERIOD))
    assert look(rates=(-0.15, 0.6, 0.9)).ways == pytest.approx((-0.15 * PERIOD, 0.6 * PERIOD, 0.9 * PERIOD))
    assert look(rates=(0.5, 0.6, 0.9)).ways == pytest.approx((0.5 * PERIOD, 0.6 * PERIOD, 0.9 * PERIOD))
    assert look(rates=(0.5, 0.0, 0.0), u=(-0.1, 0.2, 0.3)).ways[0] == pytest.approx(-0.2 * PERIOD)


@every_joint
def test_a_way_counts_once_the_pump_has_had_its_time(joint):
    slow = UNLIKE._replace(speed_limits=UNLIKE.speed_limits._replace(build_up=0.3))
    for opened, counts in ((0.31, True), (0.29, False), (-0.31, True), (-0.29, False), (0.0, False)):
        over = Overload(open_time=at(joint, opened))
        found = updated_check(
            UNASKED,
            ANGLES,
            at(joint, 0.1),
            UNREAD,
            at(joint, 0.1),
            (5.0,) * 3,
            over,
            NO_PRESSURES,
            math.nan,
            slow,
            PERIOD,
        )
        assert (found.ways[joint] != 0.0) == counts


def test_each_joint_s_way_is_its_own_rate_s_towards_its_own_command():
    before = FileCheck(ways=(1e-3, 2e-3, 3e-3))
    ways = look(before, rates=(0.02, -0.03, 0.04)).ways
    assert ways == pytest.approx((1e-3 + 0.02 * PERIOD, 2e-3 - 0.03 * PERIOD, 3e-3 + 0.04 * PERIOD))
    assert look(before, rates=(-0.02, 0.03, -0.04), u=(-0.1, -0.2, -0.3)).ways == pytest.approx(ways)


@every_joint
def test_a_way_ends_where_its_command_turns_round(joint):
    forth = look(FileCheck(ways=(-1e-3, -1e-3, -1e-3)), rates=(-0.1, -0.1, -0.1))
    assert forth.ways == pytest.approx(3 * (-1e-3 - 0.1 * PERIOD,))
    back = look(forth, rates=(-0.1, -0.1, -0.1), u=at(joint, -0.1, 0.1))
    assert back.ways[joint] == pytest.approx(0.1 * PERIOD)
    # A command that only feeds leakage turns round, too; a shut valve or no command does not.
    fed = look(forth, u=at(joint, -1e-3, 1e-3))
    assert fed.ways == pytest.approx(at(joint, 0.0, forth.ways[0]))
    assert forth.sides == (1.0, 1.0, 1.0)
    assert look(FileCheck(sides=(1.0, -1.0, 0.0)), u=ZERO).sides == (1.0, -1.0, 0.0)
    proven = look(FileCheck(ways=(PROVEN, PROVEN, PROVEN), sides=(1.0, 1.0, 1.0)), u=(-0.1, -0.1, -0.1))
    assert proven.ways == (PROVEN, PROVEN, PROVEN)


@every_joint
def test_a_way_counts_behind_a_valve_that_is_open_and_a_command_that_is_none_of_leakage(joint):
    for volts, opened in (
        (FORWARD[joint] + 1e-3, True),
        (FORWARD[joint] - 1e-3, False),
        (-BACKWARD[joint] - 1e-3, True),
        (-BACKWARD[joint] + 1e-3, False),
    ):
        assert (look(rates=at(joint, 0.1), voltages=at(joint, volts)).ways[joint] > 0.0) == opened
    for u, counts in ((0.0101, True), (0.0099, False), (-0.0101, True), (-0.0099, False)):
        assert (look(rates=at(joint, 0.1), u=at(joint, u)).ways[joint] != 0.0) == counts


@every_joint
def test_a_joint_has_proven_right_after_15_mrad_and_is_wrong_after_as_many_the_other_way(joint):
    assert look(FileCheck(ways=at(joint, 0.0149)), rates=at(joint, 0.1)).ways[joint] == 0.015
    assert look(FileCheck(ways=at(joint, 0.015)), rates=at(joint, -0.1)).ways[joint] == 0.015
    assert not is_wrong(look(FileCheck(ways=at(joint, -0.0149))))
    assert look(FileCheck(ways=at(joint, -0.0151))).wrong == 3 + joint


@every_joint
def test_only_a_joint_that_was_asked_and_has_not_proven_right_is_wrong_by_going_back(joint):
    back = Overload(agreement=at(joint, -1.0))
    assert look(FileCheck(ways=at(joint, 0.0149)), overload=back).wrong == 3 + joint
    assert not is_wrong(look(FileCheck(ways=at(joint, 0.015)), overload=back))
    assert not is_wrong(look(u=at(joint, 0.0, 0.2), overload=back))


@pytest.mark.parametrize(
    ("volts", "pressures", "joint", "wrong"),
    [
        (0.65, (0.91, 0.0), 1, False),
        (0.65, (0.89, 1.0), 1, True),
        (-0.65, (0.0, 0.91), 1, False),
        (-0.65, (1.0, 0.89), 1, True),
        (0.65, (0.91, 0.0), 0, True),
        (0.65, (0.91, 0.0), 2, True),
    ],
)
def test_a_pressure_of_nine_tenths_of_the_pump_s_excuses_the_boom_alone(volts, pressures, joint, wrong):
    back = Overload(agreement=at(joint, -1.0))
    told = tuple(share * UNLIKE.speed_limits.supply_pressure for share in pressures)
    assert is_wrong(look(overload=back, voltages=(5.0, volts, 5.0), pressures=told)) == wrong


@pytest.mark.parametrize(
    ("boom", "stick", "fitted", "strange", "wrong"),
    [
        (0.029, -0.029, False, 0.29, 0),
        (0.031, 0.0, False, 0.29, 0),
        (0.031, 0.0, False, 0.31, 1),
        (-0.031, 0.0, True, 0.31, 1),
        (0.0, 0.031, False, 0.31, 2),
        (0.0, -0.031, True, 0.31, 2),
        (0.2, 0.0, False, 0.31, 1),
        (0.0, 0.2, False, 0.31, 2),
        (0.2, 0.0, True, 0.31, 0),  # a transducer broke
        (0.0, 0.2, True, 0.31, 0),
        (0.2, 0.031, True, 0.31, 2),
    ],
)
def test_lengths_that_do_not_fit_for_three_tenths_of_a_second_are_wrong(boom, stick, fitted, strange, wrong):
    lengths = tuple(
        cylinder_length(ANGLES[i] + off, UNLIKE.linkages[i - 1]) for i, off in ((1, boom), (2, stick))
    )
    found = look(FileCheck(strange=strange - PERIOD, fitted=fitted), lengths=lengths)
    assert found.wrong == wrong
    assert found.fitted == (fitted or max(abs(boom), abs(stick)) < 0.03)
    grows = any(0.03 < abs(off) <= (0.1 if fitted else 9.0) for off in (boom, stick))
    assert found.strange == pytest.approx(strange if grows else 0.0)


@every_joint
def test_what_a_machine_answers_is_noted_behind_open_valves_and_judged(joint):
    q, pressures, opened = ANGLES, (9e6, 4e6), at(joint, 5.0)
    u, v = (0.1, 0.2, 0.3), (0.09, 0.19, 0.29)
    asked = at(joint, u[joint])
    found = look(rates=v, u=u, voltages=opened, pressures=pressures).answers
    assert found == machine_answers.answered(NO_ANSWERS, q, asked, v, pressures, UNLIKE, PERIOD)
    slow = Answers(squares=at(joint, 8.1e-3), products=at(joint, 3.2e-3), responses=at(joint, 1.7e-3))
    assert look(FileCheck(answers=slow), u=ZERO).wrong == 6 + joint
    assert look(FileCheck(answers=Answers(way=0.031, borne=0.7, weight=1.0)), u=ZERO).wrong == 9


LOW, KEPT = 0.94 * UNLIKE.speed_limits.idle_pressure, 0.96 * UNLIKE.speed_limits.idle_pressure


@every_joint
def test_what_is_judged_without_the_pump_s_pressure_is_the_supply_s(joint):
    back = Overload(agreement=at(joint, -1.0))
    for supply, starved in ((LOW, True), (KEPT, False), (math.nan, False)):
        judged = look(FileCheck(fitted=True), overload=back, supply=supply)
        assert (judged.wrong, judged.starved) == (3 + joint, starved)
        assert objection(judged).startswith("supply: less than" if starved else "machine file: ")
        assert look(judged, supply=KEPT) == judged
    assert not look(supply=LOW).starved
    lengths = look(FileCheck(strange=9.0), lengths=off(0.05), supply=LOW)
    assert (lengths.wrong, lengths.starved) == (machine_file_check.BOOM, False)


@pytest.mark.parametrize("wrong", range(10))
def test_what_is_wrong_stays_so_but_lengths_that_once_fitted(wrong):
    for fitted in (False, True):
        before = FileCheck(wrong=wrong, fitted=fitted, strange=9.0)
        stays = wrong >= 3 or (wrong > 0 and not fitted)
        assert (look(before, lengths=FITTING) == before) == stays
        assert is_wrong(before) == (wrong != 0)


def test_each_thing_that_is_wrong_is_told_by_its_joint():
    answers = Answers(squares=(1.0, 1.0, 2.0), products=(0.2, 2.5, 7.0))
    assert [objection(FileCheck(wrong=wrong, answers=answers)).partition(";")[0] for wrong in range(10)] == [
        "",
        "machine file: the length of the boom's cylinder does not belong to its angle",
        "machine file: the length of the stick's cylinder does not belong to its angle",
        *(f"machine file: {name} goes against its commands" for name in ("swing", "boom", "stick")),
        "machine file: swing goes 0.2 times as fast as commanded",
        "machine file: boom goes 2.5 times as fast as commanded",
        "machine file: stick goes 3.5 times as fast as commanded",
        "machine file: the pressures bear less than boom and stick weigh",
    ]
    turned = [
        wrong for wrong in range(10) if "of one sign" in objection(FileCheck(wrong=wrong, answers=answers))
    ]
    assert turned == [3, 4, 5]  # of what only goes at another rate no wires are exchanged
