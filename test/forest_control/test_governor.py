"""Claims about the governor: it slows, it never turns, it never traps."""

import math

import numpy as np
import pytest

from forest_control.governor import (
    CREEP,
    ENOUGH,
    FAR_OFF,
    NEGLIGIBLE_RATE,
    NO_AXIS,
    NO_STROKE,
    Governed,
    GovernorParameters,
    Limit,
    Pumps,
    Stroke,
    flow_demand,
    govern,
)
from forest_description.actuation import displacements, joint_rates_to_actuator_speeds
from forest_description.kinematics import Links, joint_rates, tip_velocity
from forest_description.linkage import cylinder_length, lever_arm
from forest_description.machine import load_machine

LINKS = Links(0.41, 4.1, 2.9)
P = GovernorParameters(
    lower=(-2.0, -0.6, -2.1),
    upper=(2.0, 1.2, -0.8),
    rates=(0.8, 0.25, 0.3),
    approach=(1.0, 2.0, 3.0),
    pumps=ENOUGH,
    axis=NO_AXIS,
)
MIDDLE = (0.0, 0.3, -1.5)


def random_angles(rng, beyond=0.0):
    return tuple(rng.uniform(np.subtract(P.lower, beyond), np.add(P.upper, beyond)).tolist())


def test_tip_keeps_its_direction_and_no_joint_exceeds_what_is_allowed():
    rng, count = np.random.default_rng(2), 20000
    angles, wishes = rng.uniform(P.lower, P.upper, (count, 3)), rng.normal(0.0, 0.6, (count, 3))
    factors, rates, moved = np.empty(count), np.empty((count, 3)), np.empty((count, 3))
    for k, (q, wish) in enumerate(zip(map(tuple, angles.tolist()), map(tuple, wishes.tolist()), strict=True)):
        wished = joint_rates(q, wish, LINKS)
        factors[k] = govern(q, wished, P).factor
        rates[k] = np.multiply(factors[k], wished)
        moved[k] = tip_velocity(q, tuple(rates[k].tolist()), LINKS)
    square = np.sum(wishes**2, axis=1)
    assert all(np.linalg.norm(np.cross(moved, wishes), axis=1) <= 1e-9 * square)
    assert np.sum(moved * wishes, axis=1) == pytest.approx(factors * square, rel=1e-9)
    room = np.where(rates > 0.0, P.upper - angles, angles - P.lower)
    assert np.all(np.abs(rates) <= (1.0 + 1e-12) * np.minimum(P.rates, np.maximum(0.0, P.approach * room)))
    assert min(factors) >= 0.0
    assert max(factors) == 1.0
    assert 2000 < np.count_nonzero(factors < 1.0) < 20000


def test_factor_is_the_largest_that_is_allowed_but_for_the_rounded_corner_near_a_limit():
    rng = np.random.default_rng(3)
    for _ in range(1000):
        q, wished = random_angles(rng), tuple(rng.normal(0.0, 0.4, 3).tolist())
        rooms = [P.upper[i] - q[i] if wished[i] > 0.0 else q[i] - P.lower[i] for i in range(3)]
        limits = [max(0.0, P.approach[i] * rooms[i]) / abs(wished[i]) for i in range(3)]
        rates = [P.rates[i] / abs(wished[i]) for i in range(3)]
        most = min(1.0, *rates, *limits)
        arrived = any(P.approach[i] * rooms[i] < CREEP for i in range(3))
        assert (0.0 if arrived else 0.71 * most) <= govern(q, wished, P).factor <= most * (1.0 + 1e-12)
        if min(limits) > FAR_OFF:
            assert govern(q, wished, P).factor == pytest.approx(most, rel=1e-12)


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize("beyond", [0.0, 0.3])
def test_moving_away_from_a_limit_is_never_slowed(joint, beyond):
    for limit, outward in ((P.upper[joint] + beyond, 1.0), (P.lower[joint] - beyond, -1.0)):
        q, wished = list(MIDDLE), [0.0, 0.0, 0.0]
        q[joint], wished[joint] = limit, -outward * P.rates[joint]
        assert govern(tuple(q), tuple(wished), P) == Governed(1.0, Limit.NONE)
        wished[joint] = outward * P.rates[joint]
        assert govern(tuple(q), tuple(wished), P) == Governed(0.0, Limit.JOINT)


def test_backing_out_is_possible_from_everywhere():
    rng = np.random.default_rng(4)
    for _ in range(2000):
        q = random_angles(rng, beyond=0.5)
        back = tuple(float(rate) for rate in rng.uniform(0.1, 3.0) * np.sign(np.subtract(MIDDLE, q)))
        governed = govern(q, back, P)
        assert governed.factor == min(1.0, min(P.rates[i] / abs(back[i]) for i in range(3)))
        assert governed.limit is not Limit.JOINT


def test_rounding_towards_a_limit_does_not_stop_the_others():
    q = (0.0, P.upper[1], -1.5)
    assert govern(q, (0.5, NEGLIGIBLE_RATE, 0.1), P) == Governed(1.0, Limit.NONE)
    assert govern(q, (0.5, 2.0 * NEGLIGIBLE_RATE, 0.1), P) == Governed(0.0, Limit.JOINT)


def test_the_limit_that_holds_back_is_named():
    assert govern(MIDDLE, (0.4, 0.1, 0.1), P) == Governed(1.0, Limit.NONE)
    assert govern(MIDDLE, (1.6, 0.1, 0.1), P) == Governed(0.5, Limit.RATE)
    near = (0.0, P.upper[1] - 0.05, -1.5)
    assert govern(near, (1.6, 0.1, 0.1), P) == Governed(0.5, Limit.RATE)
    assert govern(near, (0.8, 0.2, 0.1), P).limit is Limit.JOINT


def test_a_joint_comes_to_rest_before_its_limit():
    angle, period = 0.9, 0.005
    for _ in range(4000):
        factor = govern((0.0, angle, -1.5), (0.0, 0.25, 0.0), P).factor
        angle += period * factor * 0.25
    assert P.upper[1] - 1.1 * CREEP / P.approach[1] < angle < P.upper[1]
    assert govern((0.0, angle, -1.5), (0.0, 0.25, 0.0), P).factor * 0.25 < 1e-6  # it arrives
    assert not math.isclose(angle, 0.9)


def test_the_pumps_flow_is_shared_without_turning():
    machine = load_machine("loader")
    areas = [displacements(machine, axis) for axis in range(3)]
    extending, retracting = zip(*areas, strict=True)
    pumps = Pumps(machine.pump.flow_limit, extending, retracting, machine.linkages)
    p = P._replace(pumps=pumps, rates=(9.0, 9.0, 9.0), approach=(99.0, 99.0, 99.0))
    rng, held = np.random.default_rng(7), 0
    for _ in range(2000):
        q, wished = random_angles(rng), tuple(rng.normal(0.0, 0.5, 3).tolist())
        governed = govern(q, wished, p)
        speeds = joint_rates_to_actuator_speeds(q, wished, machine.linkages)
        taken = sum(abs(v) * area[0 if v > 0.0 else 1] for v, area in zip(speeds, areas, strict=True))
        assert flow_demand(q, wished, pumps) == pytest.approx(taken, rel=1e-12)
        assert governed.factor * taken <= pumps.limit * (1.0 + 1e-12)
        held += governed.limit == Limit.FLOW
    assert 200 < held < 2000


@pytest.mark.parametrize("sign", [-1.0, 1.0], ids=["retracts", "extends"])
def test_a_cylinder_is_allowed_its_approach_rate_times_the_stroke_that_is_left(sign):
    linkage = load_machine("c180").linkages[0]
    ends = cylinder_length(P.lower[1], linkage), cylinder_length(P.upper[1], linkage)
    p = P._replace(rates=(math.inf,) * 3, strokes=(NO_STROKE, Stroke(linkage, *ends), NO_STROKE))
    fast = 1000.0  # [rad/s] far over what is allowed, where no corner is rounded
    for angle in np.linspace(P.lower[1] + 0.01, P.upper[1] - 0.01, 30).tolist():
        factor = govern((0.0, angle, -1.5), (0.0, sign * fast, 0.0), p).factor
        left = abs(ends[1 if sign > 0.0 else 0] - cylinder_length(angle, linkage))
        speed = lever_arm(angle, linkage) * factor * fast
        assert speed == pytest.approx(P.approach[1] * left, rel=0.01)


def test_outside_its_stroke_a_cylinder_may_only_come_back():
    linkage = load_machine("c180").linkages[0]
    stroke = Stroke(linkage, cylinder_length(P.lower[1], linkage), cylinder_length(P.upper[1], linkage))
    p = P._replace(strokes=(NO_STROKE, stroke, NO_STROKE))
    beyond = (0.0, P.upper[1] + 0.02, -1.5)
    assert govern(beyond, (0.0, 0.1, 0.0), p).factor == 0.0
    assert govern(beyond, (0.0, -0.1, 0.0), p).factor == 1.0
