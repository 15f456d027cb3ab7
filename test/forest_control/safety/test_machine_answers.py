"""How a machine answers its first commands: what is far from its file, and what is not asked again."""

import math

import pytest

from forest_control.config import controller_settings
from forest_control.limits.load_weighing import UNREAD, own_weight
from forest_control.safety.machine_answers import (
    NO_ANSWERS,
    answered,
    gain,
    is_of_another_rate,
    is_too_light,
)
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
