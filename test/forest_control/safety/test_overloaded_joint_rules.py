"""When a joint goes against its commands, or stands, behind its open valve: by hand-made samples."""

import math

import pytest
from unlike_joints import BACKWARD, FORWARD, LAGS, RATED, UNLIKE, at

from forest_control.config import controller_settings
from forest_control.limits.actuator_speed_limits import build_up_time
from forest_control.limits.load_weighing import UNREAD
from forest_control.safety.overloaded_joint import (
    Overload,
    commanded_rates,
    goes_back,
    is_fed,
    is_overloaded,
    objection,
    opens,
    updated_overload,
)
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

P = controller_settings.parameters(load_machine("c180_hoses"), controller_settings.Settings())


UNLADEN = (0.0, 0.0)


def gone(rates, volts, seconds, u=ZERO, pressures=UNLADEN):
    overload = Overload()
    for _ in range(round(seconds / PERIOD)):
        overload = updated_overload(overload, u, rates, volts, pressures, P, PERIOD)
    return overload


@pytest.mark.parametrize(("joint", "name"), list(enumerate(("swing", "boom", "stick"))))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_goes_against_its_command_is_named_by_how_strongly_it_does(joint, name, side):
    def of(value):
        return tuple(value if i == joint else 0.0 for i in range(3))

    least = math.sqrt((2e-3, 1e-3, 2e-3)[joint])  # [rad/s] at a gain of -1
    volts, u, back = of(side * 2.0), of(side * 1.05 * least), of(-side * 1.05 * least)
    assert is_overloaded(gone(back, volts, 3.0, u))
    assert objection(gone(back, volts, 3.0, u)).startswith(f"overload: {name} went back though its valve")
    assert not goes_back(gone(back, volts, 3.0, of(side * 0.94 * least)), joint)
    assert not goes_back(gone(of(-side * 0.94 * least), volts, 3.0, u), joint)
    assert objection(gone(of(side * least), volts, 3.0, u)) == ""
    assert not is_overloaded(gone(back, of(side * 0.2), 3.0, u))  # its valve is shut
    assert not goes_back(gone(back, volts, 0.1, u), joint)  # a moment is nothing


@pytest.mark.parametrize(("joint", "least", "most"), [(0, 0.09, 0.11), (1, 0.08, 0.09), (2, 0.08, 0.09)])
def test_what_goes_three_times_as_strongly_against_its_command_is_named_soon(joint, least, most):
    rate = 3.0 * math.sqrt((2e-3, 1e-3, 2e-3)[joint])
    u, rates, volts = (tuple(x if i == joint else 0.0 for i in range(3)) for x in (rate, -rate, 3.0))
    assert not is_overloaded(gone(rates, volts, least, u))
    assert is_overloaded(gone(rates, volts, most, u))


@pytest.mark.parametrize(
    ("joint", "times", "seconds"),
    [(0, 1.0, 0.3), (1, 1.0, 0.067), (1, 10.0, 0.067), (2, 1.0, 0.067), (2, 10.0, 0.067)],
)
def test_however_well_boom_or_stick_has_gone_it_is_named_as_soon_as_it_goes_back(joint, times, seconds):
    """But a swing's good ways count: a log sways it to and fro."""
    rate = 3.0 * math.sqrt((2e-3, 1e-3, 2e-3)[joint])
    overload, late = Overload(), 0
    for k in range(300):
        v = -rate if k >= 200 else times * rate
        overload = updated_overload(
            overload, at(joint, rate), at(joint, v), at(joint, 3.0), UNLADEN, P, PERIOD
        )
        late += k >= 200 and not goes_back(overload, joint)
    assert late * PERIOD == pytest.approx(seconds, abs=0.006)


def rocked(joint, gain, late, u, frequency, seconds):
    """Tell whether a joint that rocks with its command, late by a part of the period, was ever named."""
    overload = Overload()
    for k in range(round(seconds / PERIOD)):
        now, later = (math.cos(2.0 * math.pi * (frequency * k * PERIOD - x)) for x in (0.0, late))
        told, rates, volts = (
            tuple(x if i == joint else 0.0 for i in range(3))
            for x in (u * now, gain * u * later, math.copysign(3.0, now))
        )
        overload = updated_overload(overload, told, rates, volts, UNLADEN, P, PERIOD)
        if goes_back(overload, joint):
            return True
    return False


@pytest.mark.parametrize("late", [0.0, 0.25, 0.4])
@pytest.mark.parametrize("frequency", [3.0, 5.0])
def test_what_rocks_on_its_oil_almost_half_a_period_behind_its_command_answers(frequency, late):
    for joint in range(3):
        assert not rocked(joint, 1.0, late, 0.05, frequency, 3.0)


@pytest.mark.parametrize("late", [0.0, 0.1, 0.25])
def test_what_rocks_behind_a_valve_that_is_wired_the_other_way_does_not(late):
    for joint in range(3):
        assert rocked(joint, -3.0, late, 0.2, 2.0, 3.0)


@pytest.mark.parametrize(("side", "fed"), [(1.0, 0), (-1.0, 1)])
@pytest.mark.parametrize("joint", [0, 1, 2])
def test_of_a_boom_that_bears_a_load_as_great_as_the_pump_s_only_a_wide_valve_counts(joint, side, fed):
    """Its servo goes against it as it sinks, while a person puts the load down."""

    def named(share, volts):
        pressures = tuple(share * P.speed_limits.supply_pressure if i == fed else 0.0 for i in (0, 1))
        at_once = at(joint, -0.1 * side), at(joint, side * volts), 0.5, at(joint, 0.1 * side)
        return is_overloaded(gone(*at_once, pressures if not math.isnan(share) else UNREAD))

    law = P.speed_limits.axes[1].valve
    edge = (law.forward if side > 0.0 else law.backward).deadband_voltage
    wide = edge + 0.4 * (P.rated_voltages[1] - edge)
    for share in (0.89, 0.91, math.nan):
        assert named(share, wide + 0.01)
        assert named(share, wide - 0.01) == (joint != 1 or share < 0.9)


@pytest.mark.parametrize(("joint", "name"), list(enumerate(("swing", "boom", "stick"))))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_stands_behind_an_open_valve_is_named(joint, name, side):
    def of(value):
        return tuple(value if i == joint else 0.0 for i in range(3))

    wide, u = of(side * 4.0), of(side * 0.1)
    assert not is_overloaded(gone(ZERO, wide, 0.38, u))
    assert not is_overloaded(gone(ZERO, wide, 0.295, of(side * 0.5)))  # a full lever: it may still begin
    assert is_overloaded(gone(ZERO, wide, 0.34, of(side * 0.5)))
    assert objection(gone(ZERO, wide, 0.41, u)).startswith(f"overload: {name} stands though its valve")
    assert is_overloaded(gone(of(side * 0.005), wide, 1.0, u))  # a twentieth of its rate
    assert not is_overloaded(gone(of(side * 0.02), wide, 9.0, u))  # it is slow
    assert not is_overloaded(gone(ZERO, of(side * 0.2), 9.0, u))  # its valve is within the overlap
    assert not is_overloaded(gone(ZERO, of(-side * 4.0), 9.0, u))  # open the other way


BEFORE = Overload(
    lagged_command=(0.11, 0.12, -0.13),
    agreement=(1e-4, -1e-4, 2e-4),
    deficit=(0.01, 0.012, 0.014),
    deficit_time=(0.1, 0.12, 0.14),
    filtered_rate=(0.02, 0.03, -0.04),
    filtered_command=(0.25, 0.35, -0.45),
)
OPENED, U = (6.0, 5.0, 4.0), (0.3, 0.4, 0.5)
TOGETHER = 0.4, 0.3, 0.3  # [s]
every_joint = pytest.mark.parametrize("joint", [0, 1, 2])


def step(before=BEFORE, u=U, rates=(-0.05, -0.06, -0.07), voltages=OPENED):
    return updated_overload(before, u, rates, voltages, UNLADEN, UNLIKE, PERIOD)


def test_a_command_asks_each_joint_for_its_share_of_the_rated_speed():
    q = (0.1, 0.5, -1.4)
    swing, boom, stick = commanded_rates(q, (1.0, 2.0, 3.0), UNLIKE)
    assert swing == pytest.approx(1.0 / 10.0 * 2.0)
    assert boom == pytest.approx(2.0 / 8.0 * 0.2 / lever_arm(q[1], UNLIKE.linkages[0]))
    assert stick == pytest.approx(3.0 / 6.0 * 0.1 / lever_arm(q[2], UNLIKE.linkages[1]))


@every_joint
def test_a_valve_opens_beyond_its_overlap_on_either_side(joint):
    assert opens(FORWARD[joint] + 1e-3, joint, UNLIKE)
    assert not opens(FORWARD[joint] - 1e-3, joint, UNLIKE)
    assert opens(-BACKWARD[joint] - 1e-3, joint, UNLIKE)
    assert not opens(-BACKWARD[joint] + 1e-3, joint, UNLIKE)


def test_a_joint_owes_what_it_was_told_less_ten_times_what_it_goes():
    gone = [
        before + (1.0 - math.exp(-PERIOD / 0.1)) * (v - before)
        for before, v in zip(BEFORE.filtered_rate, (-0.05, -0.06, -0.07), strict=True)
    ]
    found = step()
    assert found.filtered_rate == pytest.approx(gone)
    told = [
        before + (1.0 - math.exp(-PERIOD / 0.1)) * (u - before)
        for before, u in zip(BEFORE.filtered_command, U, strict=True)
    ]
    assert found.filtered_command == pytest.approx(told)
    owed = [
        before + (abs(u) - 10.0 * abs(v)) * PERIOD
        for before, u, v in zip(BEFORE.deficit, told, gone, strict=True)
    ]
    assert found.deficit == pytest.approx(owed)
    other = BEFORE._replace(filtered_command=(-0.25, -0.35, 0.45))
    assert step(other, u=(-0.3, -0.4, -0.5), voltages=(-6.0, -5.0, -4.0)).deficit == pytest.approx(owed)
    assert found.deficit_time == pytest.approx([before + PERIOD for before in BEFORE.deficit_time])


@every_joint
def test_a_joint_owes_nothing_behind_a_shut_valve_or_without_a_command_or_once_it_has_gone_enough(joint):
    for changed in (
        {"voltages": at(joint, 0.45, 5.0)},
        {"u": at(joint, 0.0, 0.5)},
        {"u": at(joint, -0.5, 0.5)},
        {"before": BEFORE._replace(filtered_rate=at(joint, 9.0))},
    ):
        found = step(**changed)
        assert [owed == 0.0 for owed in found.deficit] == [i == joint for i in range(3)]
        assert [since == 0.0 for since in found.deficit_time] == [i == joint for i in range(3)]


def test_what_a_joint_owes_counts_from_below_zero_by_its_spool_s_lag():
    assert step(before=Overload(), rates=ZERO).deficit_time == pytest.approx([PERIOD - lag for lag in LAGS])


def test_a_load_sensing_pump_rises_by_its_margin_in_its_response_time():
    """18 MPa of the loader's are seven margins and a fifth above its idle 2.2 MPa, of 50 ms each."""
    of = {name: build_up_time(load_machine(name).pump) for name in ("c180", "forwarder", "loader")}
    assert of == {"c180": 0.0, "forwarder": pytest.approx(0.27), "loader": pytest.approx(0.3591, abs=1e-4)}
    p = controller_settings.parameters(load_machine("loader"), controller_settings.Settings())
    assert p.speed_limits.build_up == of["loader"]


SLOW_PUMP = UNLIKE._replace(speed_limits=UNLIKE.speed_limits._replace(build_up=0.3))


@every_joint
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_valve_counts_as_fed_once_it_was_open_to_one_side_for_as_long_as_the_pump_needs(joint, side):
    def opened(before, volts):
        over = BEFORE._replace(open_time=before)
        return updated_overload(over, U, ZERO, at(joint, side * volts), UNLADEN, SLOW_PUMP, PERIOD)

    told = opened(at(joint, side * 0.1), 5.0).open_time[joint]
    assert told == pytest.approx(side * (0.1 + PERIOD))
    assert opened(at(joint, -side * 0.1), 5.0).open_time[joint] == pytest.approx(side * PERIOD)
    assert opened(at(joint, side * 0.1), 0.45).open_time == ZERO
    for before, fed in ((0.301, True), (0.294, False)):
        assert is_fed(opened(at(joint, side * before), 5.0), joint, SLOW_PUMP) == fed
    assert not is_fed(opened(ZERO, 0.0), joint, UNLIKE)


@every_joint
@pytest.mark.parametrize(("opened", "counts"), [(0.301, True), (0.29, False)])
def test_times_count_once_the_pump_has_had_its_time(joint, opened, counts):
    over = BEFORE._replace(open_time=at(joint, opened, 0.5))
    found = updated_overload(over, U, (-0.05, -0.06, -0.07), OPENED, UNLADEN, SLOW_PUMP, PERIOD)
    assert found.deficit_time[joint] == pytest.approx(
        BEFORE.deficit_time[joint] + (PERIOD if counts else 0.0)
    )
    forgotten = BEFORE.agreement[joint] * math.exp(-PERIOD / TOGETHER[joint])
    assert (found.agreement[joint] == pytest.approx(forgotten)) != counts


@every_joint
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_joint_that_pays_what_it_owes_has_only_started_late(joint, side):
    late = Overload(
        deficit=at(joint, 0.04), deficit_time=at(joint, 0.4), filtered_command=at(joint, 0.4 * side)
    )
    assert is_overloaded(late._replace(filtered_rate=at(joint, 0.039 * side)))
    assert not is_overloaded(late._replace(filtered_rate=at(joint, 0.041 * side)))
    assert is_overloaded(late._replace(filtered_rate=at(joint, -0.041 * side)))  # it goes back


def test_what_trembles_is_no_command_that_a_joint_could_owe():
    overload, wide = Overload(), (4.0, 4.0, 4.0)
    for k in range(400):
        side = 1.0 if k % 40 < 20 else -1.0  # 5 Hz
        volts, u = (tuple(side * x for x in of) for of in (wide, (0.05, 0.05, 0.05)))
        rates = (0.012 * side, 0.012 * side, 0.012 * side)
        overload = updated_overload(overload, u, rates, volts, UNLADEN, P, PERIOD)
        assert not is_overloaded(overload)


def test_a_product_is_of_the_command_behind_a_low_pass_of_50_ms_and_the_spool_s_lag():
    """A shut valve asks for nothing."""
    for volts, asked in ((OPENED, U), (ZERO, ZERO)):
        found = step(voltages=volts)
        w = [
            before + (1.0 - math.exp(-PERIOD / (0.05 + lag))) * (now - before)
            for before, now, lag in zip(BEFORE.lagged_command, asked, LAGS, strict=True)
        ]
        assert found.lagged_command == pytest.approx(w)
        now = [x * v for x, v in zip(w, (-0.05, -0.06, -0.07), strict=True)] if volts == OPENED else ZERO
        assert found.agreement == pytest.approx(
            [
                before + (1.0 - math.exp(-PERIOD / long)) * (product - before)
                for before, long, product in zip(BEFORE.agreement, TOGETHER, now, strict=True)
            ]
        )


@every_joint
@pytest.mark.parametrize(
    ("times", "owed", "since", "said"),
    [
        (-1.01, 0.0, 0.0, "went back"),
        (-0.99, 0.0, 0.0, ""),
        (1.01, 0.0, 0.0, ""),
        (0.0, 0.031, 0.31, "stands"),
        (0.0, 0.029, 0.31, ""),
        (0.0, 0.031, 0.29, ""),
    ],
)
def test_the_bounds_of_an_overload(joint, times, owed, since, said):
    least = (2e-3, 1e-3, 2e-3)[joint]
    overload = Overload(
        agreement=at(joint, times * least), deficit=at(joint, owed), deficit_time=at(joint, since)
    )
    assert is_overloaded(overload) == bool(said)
    assert [goes_back(overload, i) for i in range(3)] == [i == joint and "back" in said for i in range(3)]
    begin = f"overload: {('swing', 'boom', 'stick')[joint]} {said}"
    assert objection(overload).startswith(begin) if said else objection(overload) == ""


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_whether_a_valve_is_wide_is_told_by_the_boom_s_own(side):
    edge = FORWARD[1] if side > 0.0 else BACKWARD[1]
    wide = edge + 0.4 * (RATED[1] - edge)
    for volts, counts in ((wide + 1e-3, True), (wide - 1e-3, False)):
        opened = at(1, side * volts, 5.0)
        found = updated_overload(BEFORE, U, (-0.05, -0.06, -0.07), opened, UNREAD, UNLIKE, PERIOD)
        forgotten = BEFORE.agreement[1] * math.exp(-PERIOD / 0.3)
        assert (found.agreement[1] == pytest.approx(forgotten)) != counts
