"""Claims about singular poses: there is always a way out, and none in."""

import math

import numpy as np
import pytest

from forest_control.governor import ENOUGH, NO_AXIS, Axis, GovernorParameters, Limit, govern
from forest_control.singularity import rates_anywhere
from forest_description.kinematics import Links, is_singular, joint_rates, tip_position

LINKS = Links(0.15, 4.1, 4.3)
WIDE = GovernorParameters(
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
        rates = rates_anywhere(q, tuple(0.3 * (c - x) for c, x in zip(centre, tip, strict=True)), LINKS)
        factor = min(1.0, *(limit / max(1e-9, abs(r)) for limit, r in zip(WIDE.rates, rates, strict=True)))
        q = tuple(x + 0.005 * factor * r for x, r in zip(q, rates, strict=True))
    assert wish != (0.0, 0.0, 0.0)
    assert math.dist(centre, tip_position(q, LINKS)) < 0.1 * begun


def test_at_regular_poses_it_is_the_inverse_jacobian():
    rng = np.random.default_rng(3)
    for _ in range(500):
        q, v = (tuple(x) for x in rng.uniform(-1.5, 1.5, (2, 3)).tolist())
        if not is_singular(q, LINKS):
            assert rates_anywhere(q, v, LINKS) == joint_rates(q, v, LINKS)


def test_the_tip_slows_down_towards_the_swing_axis_stops_before_it_and_may_leave():
    p = WIDE._replace(axis=Axis(LINKS, 0.25))
    q = (0.0, 0.5, -2.2)
    for _ in range(6000):
        rates = joint_rates(q, (-0.5, 0.0, 0.0), LINKS)
        governed = govern(q, rates, p)
        q = tuple(x + 0.005 * governed.factor * r for x, r in zip(q, rates, strict=True))
    assert governed.limit == Limit.SINGULARITY
    assert 0.25 <= tip_position(q, LINKS)[0] < 0.26
    back = govern(q, joint_rates(q, (0.5, 0.0, 0.0), LINKS), p)
    assert back.limit != Limit.SINGULARITY
    assert back.factor > 0.0
