"""Claims about singular poses: there is always a way out, and none in."""

import math

import numpy as np
import pytest

from forest_control.limits.singularity import rates_near_singularity
from forest_control.limits.velocity_scaling import (
    ENOUGH,
    NO_AXIS,
    Axis,
    Limit,
    VelocityLimits,
    velocity_scaling,
)
from forest_description.geometry.kinematics import Links, is_singular, joint_rates, tip_position, tip_velocity

LINKS = Links(0.15, 4.1, 4.3)
WIDE = VelocityLimits(
    (-3.0, -3.0, -3.1), (3.0, 3.0, -0.05), (0.8, 0.25, 0.25), (1.0, 2.0, 2.0), ENOUGH, NO_AXIS
)


def on_axis():
    """Return a pose whose tip is on the swing axis."""
    boom = 1.0
    fold = math.acos(-(LINKS.base_offset + LINKS.boom * math.cos(boom)) / LINKS.stick)
    return (0.3, boom, -fold - boom)


@pytest.mark.parametrize("pose", [(0.2, 0.3, 0.0), (0.2, 0.3, -math.pi), (0.2, 0.0, 0.0), on_axis()])
def test_from_a_singular_pose_some_joint_moves_and_the_tip_leaves(pose):
    assert is_singular(pose, LINKS)
    centre = (2.0, 0.6, 0.1)
    tip = tip_position(pose, LINKS)
    wish = tuple(0.3 * (c - x) for c, x in zip(centre, tip, strict=True))
    q, begun = pose, math.dist(centre, tip)
    for _ in range(4000):
        tip = tip_position(q, LINKS)
        rates = rates_near_singularity(
            q, tuple(0.3 * (c - x) for c, x in zip(centre, tip, strict=True)), LINKS
        )
        factor = min(1.0, *(limit / max(1e-9, abs(r)) for limit, r in zip(WIDE.rates, rates, strict=True)))
        q = tuple(x + 0.005 * factor * r for x, r in zip(q, rates, strict=True))
    assert wish != (0.0, 0.0, 0.0)
    assert math.dist(centre, tip_position(q, LINKS)) < 0.1 * begun


def test_at_regular_poses_it_is_the_inverse_jacobian():
    rng = np.random.default_rng(3)
    for _ in range(500):
        q, v = (tuple(x) for x in rng.uniform(-1.5, 1.5, (2, 3)).tolist())
        if not is_singular(q, LINKS):
            assert rates_near_singularity(q, v, LINKS) == joint_rates(q, v, LINKS)


STRAIGHT_OR_FLAT = [
    *((0.0, -0.05), (4e-7, 0.05), (-4e-7, -0.05), (2.0 * math.pi, 2.0 * math.pi - 0.05)),
    *((-math.pi, 0.05 - math.pi), (4e-7 - math.pi, 0.05 - math.pi), (-4e-7 - math.pi, -0.05 - math.pi)),
    *((math.pi, math.pi + 0.05), (3.0 * math.pi, 3.0 * math.pi + 0.05)),
]


@pytest.mark.parametrize("boom", [0.3, 2.6], ids=["in front", "behind the axis"])
@pytest.mark.parametrize(("stick", "bent"), STRAIGHT_OR_FLAT)
def test_a_stick_that_is_straight_or_flat_moves_as_if_bent_by_a_little_to_its_own_side(stick, bent, boom):
    """One that is neither is bent as strokes allow, between flat and straight."""
    v, links = (0.1, -0.2, 0.3), Links(0.41, 4.1, 2.9)
    assert is_singular((0.2, boom, stick), links)
    as_if = joint_rates((0.2, boom, bent), v, links)
    assert rates_near_singularity((0.2, boom, stick), v, links) == pytest.approx(as_if, rel=1e-6)


@pytest.mark.parametrize("side", [-1.0, 1.0], ids=["behind", "in front"])
@pytest.mark.parametrize("stick", [-1.2, 1.2, -0.051, 0.049, -0.03, 0.051 - math.pi, 0.049 - math.pi])
def test_on_the_swing_axis_the_joints_move_as_if_a_little_beside_it(side, stick):
    """Beside it by a fiftieth of the arm, on the tip's own side; a stick that is almost straight is bent."""
    v = (0.1, -0.2, 0.3)
    across, along = LINKS.stick * math.sin(stick), LINKS.boom + LINKS.stick * math.cos(stick)
    boom = math.acos((side * 1e-7 - LINKS.base_offset) / math.hypot(across, along)) - math.atan2(
        across, along
    )
    q = (0.3, boom, stick)
    assert is_singular(q, LINKS)
    straight = min((0.0, -math.pi), key=lambda angle: abs(stick - angle))
    bent = math.copysign(max(0.05, abs(stick - straight)), stick - straight) + straight
    reach = LINKS.boom * math.cos(boom) + LINKS.stick * math.cos(boom + bent)
    off, least = LINKS.base_offset + reach, 0.02 * (LINKS.boom + LINKS.stick)
    if abs(off) < least:
        off = math.copysign(least, off)
    beside = Links(off - reach, LINKS.boom, LINKS.stick)
    rates = rates_near_singularity(q, v, LINKS)
    assert tip_velocity((0.3, boom, bent), rates, beside) == pytest.approx(v, rel=1e-6)
    if abs(stick - bent) < 1e-9:
        assert off == pytest.approx(side * least)


def test_the_way_out_of_a_singular_pose_is_the_same_behind_the_axis():
    """What mirrors the crane through its axis turns the swing's sense and keeps the other joints'."""
    q, v = on_axis(), (0.1, -0.2, 0.3)
    rates = rates_near_singularity(q, v, LINKS)
    assert max(map(abs, rates)) < 10.0
    turned = rates_near_singularity((q[0] + math.pi, *q[1:]), (-v[0], -v[1], v[2]), LINKS)
    assert turned == pytest.approx(rates, rel=1e-6)


def test_the_tip_slows_down_towards_the_swing_axis_stops_before_it_and_may_leave():
    p = WIDE._replace(axis=Axis(LINKS, 0.25))
    q = (0.0, 0.5, -2.2)
    for _ in range(6000):
        rates = joint_rates(q, (-0.5, 0.0, 0.0), LINKS)
        governed = velocity_scaling(q, rates, p)
        q = tuple(x + 0.005 * governed.factor * r for x, r in zip(q, rates, strict=True))
    assert governed.limit == Limit.SINGULARITY
    assert 0.25 <= tip_position(q, LINKS)[0] < 0.26
    back = velocity_scaling(q, joint_rates(q, (0.5, 0.0, 0.0), LINKS), p)
    assert back.limit != Limit.SINGULARITY
    assert back.factor > 0.0
