"""When a joint counts as driven back, or as standing, behind its open valve: by hand-made samples."""

import math

import pytest
from unlike_joints import BACKWARD, FORWARD, LAGS, RATED, UNLIKE, at

from forest_control.config import controller_settings
from forest_control.limits.actuator_speed_limits import build_up_time
from forest_control.safety.overloaded_joint import (
    LONG,
    WAY,
    Overload,
    commanded_rates,
    goes_back,
    is_fed,
    is_overloaded,
    objection,
    opens,
    watched,
)
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

P = controller_settings.parameters(load_machine("c180_hoses"), controller_settings.Settings())


def gone(rates, volts, seconds, u=ZERO):
    overload = Overload()
    for _ in range(round(seconds / PERIOD)):
        overload = watched(overload, u, rates, volts, P, PERIOD)
    return overload


@pytest.mark.parametrize(("joint", "name"), list(enumerate(("swing", "boom", "stick"))))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_each_joint_in_either_direction_by_way_and_time(joint, name, side):
    def of(value):
        return tuple(value if i == joint else 0.0 for i in range(3))

    long = LONG[joint] + P.speed_limits.axes[joint].spool.lag
    quick, slow = 2.0 * WAY / long, 0.5 * WAY / long
    sunk = gone(of(-side * quick), of(side * 8.0), long + 2.0 * PERIOD)
    assert is_overloaded(sunk)
    assert objection(sunk).startswith(f"overload: {name} went back by")
    assert not is_overloaded(gone(of(-side * quick), of(side * 8.0), long - 2.0 * PERIOD))
    assert not is_overloaded(gone(of(-side * slow), of(side * 8.0), 1.5 * long))
    assert is_overloaded(gone(of(-side * slow), of(side * 8.0), 3.0 * long))
    assert objection(gone(of(side * quick), of(side * 8.0), 1.0)) == ""
    assert not is_overloaded(gone(of(-side * quick), of(side * 4.0), 1.0))  # under half of the opening
    after = watched(sunk, ZERO, of(side * quick), of(side * 8.0), P, PERIOD)
    assert (after.ways, after.times, after.owed) == (ZERO, ZERO, ZERO)


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
    ways=(1e-3, 2e-3, 3e-3),
    times=(0.04, 0.05, 0.06),
    owed=(0.01, 0.012, 0.014),
    since=(0.1, 0.12, 0.14),
    gone=(0.02, 0.03, -0.04),
    told=(0.25, 0.35, -0.45),
)
OPENED, U = (6.0, 5.0, 4.0), (0.3, 0.4, 0.5)
every_joint = pytest.mark.parametrize("joint", [0, 1, 2])


def step(before=BEFORE, u=U, rates=(-0.05, -0.06, -0.07), voltages=OPENED):
    return watched(before, u, rates, voltages, UNLIKE, PERIOD)


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
        for before, v in zip(BEFORE.gone, (-0.05, -0.06, -0.07), strict=True)
    ]
    found = step()
    assert found.gone == pytest.approx(gone)
    told = [
        before + (1.0 - math.exp(-PERIOD / 0.1)) * (u - before)
        for before, u in zip(BEFORE.told, U, strict=True)
    ]
    assert found.told == pytest.approx(told)
    owed = [
        before + (abs(u) - 10.0 * abs(v)) * PERIOD
        for before, u, v in zip(BEFORE.owed, told, gone, strict=True)
    ]
    assert found.owed == pytest.approx(owed)
    other = BEFORE._replace(told=(-0.25, -0.35, 0.45))
    assert step(other, u=(-0.3, -0.4, -0.5), voltages=(-6.0, -5.0, -4.0)).owed == pytest.approx(owed)
    assert found.since == pytest.approx([before + PERIOD for before in BEFORE.since])


@every_joint
def test_a_joint_owes_nothing_behind_a_shut_valve_or_without_a_command_or_once_it_has_gone_enough(joint):
    for changed in (
        {"voltages": at(joint, 0.45, 5.0)},
        {"u": at(joint, 0.0, 0.5)},
        {"u": at(joint, -0.5, 0.5)},
        {"before": BEFORE._replace(gone=at(joint, 9.0))},
    ):
        found = step(**changed)
        assert [owed == 0.0 for owed in found.owed] == [i == joint for i in range(3)]
        assert [since == 0.0 for since in found.since] == [i == joint for i in range(3)]


def test_what_a_joint_owes_and_its_way_back_count_from_below_zero_by_its_spool_s_lag():
    late = [PERIOD - lag for lag in LAGS]
    assert step(before=Overload(), rates=ZERO).since == pytest.approx(late)
    assert step(before=Overload()).times == pytest.approx(late)


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
        over = BEFORE._replace(opened=before)
        return watched(over, U, ZERO, at(joint, side * volts), SLOW_PUMP, PERIOD)

    told = opened(at(joint, side * 0.1), 5.0).opened[joint]
    assert told == pytest.approx(side * (0.1 + PERIOD))
    assert opened(at(joint, -side * 0.1), 5.0).opened[joint] == pytest.approx(side * PERIOD)
    assert opened(at(joint, side * 0.1), 0.45).opened == ZERO
    for before, fed in ((0.301, True), (0.294, False)):
        assert is_fed(opened(at(joint, side * before), 5.0), joint, SLOW_PUMP) == fed
    assert not is_fed(opened(ZERO, 0.0), joint, UNLIKE)


@every_joint
@pytest.mark.parametrize(("opened", "counts"), [(0.301, True), (0.29, False)])
def test_times_count_once_the_pump_has_had_its_time(joint, opened, counts):
    over = BEFORE._replace(opened=at(joint, opened, 0.5))
    found = watched(over, U, (-0.05, -0.06, -0.07), OPENED, SLOW_PUMP, PERIOD)
    added = PERIOD if counts else 0.0
    assert found.since[joint] == pytest.approx(BEFORE.since[joint] + added)
    assert found.times[joint] == pytest.approx(BEFORE.times[joint] + added)
    assert found.ways[joint] > BEFORE.ways[joint]


@every_joint
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_joint_that_pays_what_it_owes_has_only_started_late(joint, side):
    late = Overload(owed=at(joint, 0.04), since=at(joint, 0.4), told=at(joint, 0.4 * side))
    assert is_overloaded(late._replace(gone=at(joint, 0.039 * side)))
    assert not is_overloaded(late._replace(gone=at(joint, 0.041 * side)))
    assert is_overloaded(late._replace(gone=at(joint, -0.041 * side)))  # it goes back


def test_what_trembles_is_no_command_that_a_joint_could_owe():
    overload, wide = Overload(), (4.0, 4.0, 4.0)
    for k in range(400):
        side = 1.0 if k % 40 < 20 else -1.0  # 5 Hz
        volts, u = (tuple(side * x for x in of) for of in (wide, (0.05, 0.05, 0.05)))
        overload = watched(overload, u, (0.012 * side, 0.012 * side, 0.012 * side), volts, P, PERIOD)
        assert not is_overloaded(overload)


def test_a_way_back_grows_with_its_time():
    found = step()
    assert found.ways == pytest.approx([1e-3 + 0.05 * PERIOD, 2e-3 + 0.06 * PERIOD, 3e-3 + 0.07 * PERIOD])
    assert found.times == pytest.approx([before + PERIOD for before in BEFORE.times])


@every_joint
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_way_back_counts_from_two_fifths_of_the_opening_on(joint, side):
    edge = FORWARD[joint] if side > 0.0 else BACKWARD[joint]
    bound = edge + 0.4 * (RATED[joint] - edge)
    for beyond, counts in ((1e-3, True), (-1e-3, False)):
        found = step(rates=at(joint, -0.05 * side), voltages=at(joint, side * (bound + beyond)))
        assert (found.ways[joint] > 0.0) == (found.times[joint] > 0.0) == counts
    for v in (0.0, 0.05 * side):
        assert step(rates=at(joint, v), voltages=at(joint, 5.0 * side)).ways[joint] == 0.0


@every_joint
@pytest.mark.parametrize(
    ("way", "share", "owed", "since", "said"),
    [
        (0.0051, 1.01, 0.0, 0.0, "went back by 0.005 rad"),
        (0.0049, 1.01, 0.0, 0.0, ""),
        (0.0051, 0.99, 0.0, 0.0, ""),
        (0.0, 0.0, 0.031, 0.31, "stands"),
        (0.0, 0.0, 0.029, 0.31, ""),
        (0.0, 0.0, 0.031, 0.29, ""),
    ],
)
def test_the_bounds_of_an_overload(joint, way, share, owed, since, said):
    long = (0.5, 0.1, 0.1)[joint]
    overload = Overload(
        ways=at(joint, way), times=at(joint, share * long), owed=at(joint, owed), since=at(joint, since)
    )
    assert is_overloaded(overload) == bool(said)
    assert [goes_back(overload, i) for i in range(3)] == [i == joint and "back" in said for i in range(3)]
    begin = f"overload: {('swing', 'boom', 'stick')[joint]} {said}"
    assert objection(overload).startswith(begin) if said else objection(overload) == ""
