"""How a machine answers its first commands: what is far from its file, and what is not asked again."""

import math

import pytest

from forest_control.config import controller_settings
from forest_control.limits.load_weighing import UNREAD, own_weight
from forest_control.safety.machine_answers import (
    NO_ANSWERS,
    Answers,
    answered,
    gain,
    is_of_another_rate,
    is_too_light,
)
from forest_control.safety.overloaded_joint import commanded_rates
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

HANGS, FOLDED = (
    controller_settings.parameters(load_machine(name), controller_settings.Settings())
    for name in ("c180", "c180_hoses")
)
P = HANGS
Q = (0.1, 0.5, -1.4)


def after(seconds, u, v, answers=NO_ANSWERS, pressures=UNREAD, p=P):
    for _ in range(round(seconds / PERIOD)):
        answers = answered(answers, Q, u, v, pressures, p, PERIOD)
    return answers


@pytest.mark.parametrize("joint", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("share", "other"), [(0.3, True), (0.5, False), (1.8, False), (2.3, True), (-0.5, False)]
)
def test_a_joint_of_far_another_rate_is_told_within_two_seconds(joint, side, share, other):
    def of(value):
        return tuple(side * value if i == joint else 0.0 for i in range(3))

    answers = after(1.9, of(0.1), of(share * 0.1))
    assert is_of_another_rate(answers, joint) == other
    assert not other or gain(answers, joint) == pytest.approx(share, rel=0.1)
    assert not any(is_of_another_rate(answers, i) for i in range(3) if i != joint)
    assert not is_of_another_rate(after(0.2, of(0.1), of(share * 0.1)), joint)


def test_a_joint_that_stands_is_not_judged_and_one_that_has_proven_right_is_not_asked_again():
    told = (0.1, 0.0, 0.0)
    assert not is_of_another_rate(after(60.0, told, (5e-4, 0.0, 0.0)), 0)  # something holds it
    stopped = after(3.0, told, ZERO, after(0.5, told, told))  # its cable was cut before it had proven right
    assert not is_of_another_rate(stopped, 0)
    right = after(1.5, told, told)
    assert not is_of_another_rate(after(60.0, told, (0.03, 0.0, 0.0), right), 0)
    assert not is_of_another_rate(after(60.0, (1e-3, 0.0, 0.0), (0.05, 0.0, 0.0)), 0)  # it only feeds leakage


@pytest.mark.parametrize("p", [HANGS, FOLDED])
@pytest.mark.parametrize(("share", "light"), [(0.75, True), (0.85, False), (3.0, False)])
def test_a_crane_that_moves_freely_bears_boom_and_stick(p, share, light):
    """The head is left out, whether it hangs or is part of the stick: it may be a light one."""
    c = p.weighing
    reach = P.links.boom * math.cos(Q[1]) + P.links.stick * math.cos(Q[1] + Q[2])
    head = c.gravity * 700.0 * reach
    force = share * (own_weight(Q, c) - head) / lever_arm(Q[1], c.linkage)
    pressures, up = (force / c.areas[0], 0.0), (0.0, 0.1, 0.0)
    for free in (up, (0.1, 0.0, 0.0), (-0.1, 0.0, 0.0)):
        assert is_too_light(after(0.5, free, free, pressures=pressures, p=p)) == light
    assert not is_too_light(after(0.2, up, up, pressures=pressures, p=p))  # it may not have settled
    for leaning in ((0.0, -0.1, 0.0), (0.0, 0.0, 0.1)):
        assert not is_too_light(after(5.0, leaning, leaning, pressures=pressures, p=p))
    assert not is_too_light(after(5.0, (0.1, 0.0, 0.0), (-0.1, 0.0, 0.0), pressures=pressures, p=p))
    assert not is_too_light(after(5.0, ZERO, up, pressures=pressures, p=p))
    assert not is_too_light(after(5.0, up, up, p=p))
    right = after(0.5, up, up, pressures=(3.0 * force / c.areas[0], 0.0), p=p)
    assert not is_too_light(after(5.0, up, up, right, pressures, p))


LAGS = (0.01, 0.03, 0.06)  # [s] of the spools
LAGGING = P._replace(
    speed_limits=P.speed_limits._replace(
        axes=tuple(
            axis._replace(spool=axis.spool._replace(lag=lag))
            for axis, lag in zip(P.speed_limits.axes, LAGS, strict=True)
        )
    )
)
every_joint = pytest.mark.parametrize("joint", [0, 1, 2])


def at(joint, value, others=0.0):
    return tuple(value if i == joint else others for i in range(3))


@every_joint
def test_a_rate_counts_behind_its_low_pass_once_a_joint_was_told_for_half_a_second(joint):
    before = Answers(
        commanded=(0.08, 0.08, 0.08), measured=(0.02, 0.02, 0.02), times=(0.6, 0.6, 0.6), squares=(1e-3,) * 3
    )
    u, v = (0.1, 0.2, 0.3), (0.021, 0.015, 0.01)
    told = 0.08 + (1.0 - math.exp(-PERIOD / (0.2 + LAGS[joint]))) * (u[joint] - 0.08)
    gone = 0.02 + (1.0 - math.exp(-PERIOD / 0.2)) * (v[joint] - 0.02)
    found = answered(before, Q, u, v, UNREAD, LAGGING, PERIOD)
    sums = (found.commanded, found.measured, found.times, found.squares, found.products, found.responses)
    wanted = (told, gone, 0.6 + PERIOD, 1e-3 + told**2 * PERIOD, told * gone * PERIOD, gone**2 * PERIOD)
    assert [of[joint] for of in sums] == pytest.approx(wanted, rel=1e-9)


@every_joint
@pytest.mark.parametrize(
    ("changed", "counts"),
    [
        ({}, True),
        ({"times": 0.499}, False),
        ({"times": 0.501}, True),
        ({"measured": -0.02}, False),  # it goes back
        ({"squares": 8.1e-3}, True),
        ({"squares": 8.1e-3, "responses": 7.9e-3}, True),
        ({"squares": 8.1e-3, "responses": 8.1e-3}, False),  # it has proven right
    ],
)
def test_what_does_not_count_leaves_the_sums_as_they_were(joint, changed, counts):
    told = {"commanded": 0.05, "measured": 0.02, "times": 2.0, **changed}
    before = Answers(**{name: at(joint, value) for name, value in told.items()})
    u, v = at(joint, before.commanded[joint]), at(joint, before.measured[joint])
    found = answered(before, Q, u, v, UNREAD, P, PERIOD)
    assert (found.squares[joint] > before.squares[joint]) == counts


@every_joint
@pytest.mark.parametrize(("now", "counts"), [(1.0, True), (0.81, True), (0.79, False), (-1.0, False)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_while_its_command_falls_a_joint_runs_on_and_is_not_judged(joint, now, counts, side):
    before = Answers(commanded=at(joint, 0.2 * side), measured=at(joint, 0.3 * side), times=(2.0, 2.0, 2.0))
    told = before.commanded[joint] + (1.0 - math.exp(-PERIOD / (0.2 + LAGS[joint]))) * 0.2 * side * (
        now - 1.0
    )
    u = at(joint, now * 0.2 * side)
    found = answered(before, Q, u, before.measured, UNREAD, LAGGING, PERIOD)
    assert found.squares[joint] == pytest.approx(told**2 * PERIOD if counts else 0.0)


@every_joint
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_swing_that_takes_two_seconds_to_its_speed_is_not_called_slow(joint, side):
    answers = NO_ANSWERS
    for step in range(400):
        v = at(joint, side * 0.1 * step * PERIOD)
        answers = answered(answers, Q, at(joint, side * 0.5), v, UNREAD, P, PERIOD)
        assert answers.squares[joint] == 0.0
    late = after(1.0, at(joint, side * 0.5), at(joint, side * 0.19), answers)
    assert is_of_another_rate(late, joint)  # that is its speed


@every_joint
@pytest.mark.parametrize(
    ("told", "wish", "time"),
    [
        (0.36, 0.36, 1.0 + PERIOD),
        (0.34, 0.34, 0.0),
        (-0.36, -0.36, 1.0 + PERIOD),
        (-0.34, -0.34, 0.0),
        (0.4, -60.0, 0.0),
    ],
)
def test_a_joint_is_told_for_as_long_as_it_is_told_one_way(joint, told, wish, time):
    """At rates for which an ideal valve would get 0.35 V or more: below, an overlap that is off decides."""
    told, wish = (commanded_rates(Q, at(joint, volts), P) for volts in (told, wish))
    found = answered(Answers(commanded=told, times=(1.0, 1.0, 1.0)), Q, wish, ZERO, UNREAD, P, PERIOD)
    assert found.times[joint] == pytest.approx(time)


@every_joint
@pytest.mark.parametrize(
    ("squares", "products", "responses", "other"),
    [
        (5.1e-4, 1.03e-3, 2.1e-3, True),  # too fast
        (4.9e-4, 1.03e-3, 2.1e-3, False),
        (5.1e-4, 1.01e-3, 2.1e-3, False),
        (5.1e-4, 1.03e-3, 1.9e-3, False),
        (8.1e-3, 3.2e-3, 1.7e-3, True),  # too slow
        (7.9e-3, 3.1e-3, 1.7e-3, False),
        (8.1e-3, 3.3e-3, 1.7e-3, False),
        (8.1e-3, 1.75e-3, 5.2e-4, True),
        (8.1e-3, 1.75e-3, 4.9e-4, False),
        (8.1e-3, 3.2e-3, 1.85e-3, False),  # it stopped on its way
    ],
)
def test_the_bounds_of_a_joints_rate(joint, squares, products, responses, other):
    answers = Answers(
        squares=at(joint, squares), products=at(joint, products), responses=at(joint, responses)
    )
    assert is_of_another_rate(answers, joint) == other


@pytest.mark.parametrize(
    ("u", "v", "way"),
    [
        ((0.1, 0.1, 0.1), (0.2, 0.3, 0.4), 0.5),
        ((-0.1, -0.1, 0.1), (-0.2, -0.3, 0.4), 0.2),
        ((0.1, 0.1, 0.1), (-0.2, -0.3, 0.4), 0.0),
        ((-0.1, 0.1, 0.1), (0.2, 0.3, 0.4), 0.3),
    ],
)
def test_the_boom_bears_its_weight_over_the_way_that_it_goes_up_or_swings(u, v, way):
    c, pressures = P.weighing, (9e6, 4e6)
    torque = lever_arm(Q[1], c.linkage) * (c.areas[0] * 9e6 - c.areas[1] * 4e6)
    reach = P.links.boom * math.cos(Q[1]) + P.links.stick * math.cos(Q[1] + Q[2])
    weight = own_weight(Q, c) - c.gravity * c.empty_head * reach
    found = answered(NO_ANSWERS, Q, u, v, pressures, P, PERIOD)
    done = way * PERIOD
    assert (found.way, found.borne, found.weight) == pytest.approx((done, torque * done, weight * done))
    blind = answered(NO_ANSWERS, Q, u, v, UNREAD, P, PERIOD)
    assert (blind.way, blind.borne, blind.weight) == (0.0, 0.0, 0.0)
    free = Answers(way=0.031, borne=1.0, weight=2.0)
    assert answered(free, Q, u, v, pressures, P, PERIOD)[-3:] == (0.031, 1.0, 2.0)


def test_the_bounds_of_a_booms_weight():
    assert is_too_light(Answers(way=0.0301, borne=0.79, weight=1.0))
    assert not is_too_light(Answers(way=0.0299, borne=0.79, weight=1.0))
    assert not is_too_light(Answers(way=0.0301, borne=0.81, weight=1.0))
