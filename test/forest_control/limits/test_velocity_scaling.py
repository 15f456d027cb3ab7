"""Claims about the velocity scaling: it slows, it never turns, it never traps."""

import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import between, vectors
from scipy.optimize import brentq

from forest_control.limits.velocity_scaling import (
    ENOUGH,
    NO_AXIS,
    NO_STROKE,
    Axis,
    Limit,
    Pumps,
    Stroke,
    VelocityLimits,
    VelocityScaling,
    flow_demand,
    velocity_scaling,
)
from forest_control.operator.joystick_watch import Joystick
from forest_description.derived.actuator_kinematics import displacements, joint_rates_to_actuator_speeds
from forest_description.geometry.kinematics import Links, joint_rates, tip_position, tip_velocity
from forest_description.geometry.linkage import cylinder_length, lever_arm
from forest_description.machine import load_machine

LINKS = Links(0.41, 4.1, 2.9)
CREEP, FAR_OFF, NEGLIGIBLE = 2e-3, 2.5, 1e-6  # [rad/s], times the wish, [rad/s; m/s]
CODES = Path(__file__).resolve().parents[3] / "docs" / "reference" / "codes.md"
P = VelocityLimits(
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
        factors[k] = velocity_scaling(q, wished, P).factor
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
        assert (
            (0.0 if arrived else 0.71 * most) <= velocity_scaling(q, wished, P).factor <= most * (1.0 + 1e-12)
        )
        if min(limits) > FAR_OFF:
            assert velocity_scaling(q, wished, P).factor == pytest.approx(most, rel=1e-12)


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize("beyond", [0.0, 0.3])
def test_moving_away_from_a_limit_is_never_slowed(joint, beyond):
    for limit, outward in ((P.upper[joint] + beyond, 1.0), (P.lower[joint] - beyond, -1.0)):
        q, wished = list(MIDDLE), [0.0, 0.0, 0.0]
        q[joint], wished[joint] = limit, -outward * P.rates[joint]
        assert velocity_scaling(tuple(q), tuple(wished), P) == VelocityScaling(1.0, Limit.NONE)
        wished[joint] = outward * P.rates[joint]
        assert velocity_scaling(tuple(q), tuple(wished), P) == VelocityScaling(0.0, Limit.JOINT)


@given(vectors(-3.0, 3.0), st.floats(0.1, 3.0))
def test_backing_out_is_possible_from_everywhere(q, speed):
    back = tuple(math.copysign(speed, middle - x) for x, middle in zip(q, MIDDLE, strict=True))
    governed = velocity_scaling(q, back, P)
    assert governed.factor == min(1.0, min(P.rates[i] / speed for i in range(3)))
    assert governed.limit is not Limit.JOINT


INSIDE = st.tuples(*(between(low, high) for low, high in zip(P.lower, P.upper, strict=True)))


@given(INSIDE | vectors(-3.0, 3.0), vectors(-2.0, 2.0))
def test_from_everywhere_no_joint_is_faster_than_it_may_be_towards_a_limit_nor_than_its_rate(q, wished):
    factor = velocity_scaling(q, wished, P).factor
    assert 0.0 <= factor <= 1.0
    for i in range(3):
        room = P.upper[i] - q[i] if wished[i] > 0.0 else q[i] - P.lower[i]
        allowed = max(NEGLIGIBLE, min(P.rates[i], P.approach[i] * room))
        assert factor * abs(wished[i]) <= (1.0 + 1e-12) * allowed


def test_rounding_towards_a_limit_does_not_stop_the_others():
    q = (0.0, P.upper[1], -1.5)
    assert velocity_scaling(q, (0.5, NEGLIGIBLE, 0.1), P) == VelocityScaling(1.0, Limit.NONE)
    assert velocity_scaling(q, (0.5, 1.1 * NEGLIGIBLE, 0.1), P) == VelocityScaling(0.0, Limit.JOINT)


def test_the_limit_that_holds_back_is_named():
    assert velocity_scaling(MIDDLE, (0.4, 0.1, 0.1), P) == VelocityScaling(1.0, Limit.NONE)
    assert velocity_scaling(MIDDLE, (1.6, 0.1, 0.1), P) == VelocityScaling(0.5, Limit.RATE)
    near = (0.0, P.upper[1] - 0.05, -1.5)
    assert velocity_scaling(near, (1.6, 0.1, 0.1), P) == VelocityScaling(0.5, Limit.RATE)
    assert velocity_scaling(near, (0.8, 0.2, 0.1), P).limit is Limit.JOINT


def test_a_joint_comes_to_rest_before_its_limit():
    angle, period = 0.9, 0.005
    for _ in range(4000):
        factor = velocity_scaling((0.0, angle, -1.5), (0.0, 0.25, 0.0), P).factor
        angle += period * factor * 0.25
    assert P.upper[1] - 1.1 * CREEP / P.approach[1] < angle < P.upper[1]
    assert velocity_scaling((0.0, angle, -1.5), (0.0, 0.25, 0.0), P).factor * 0.25 < 1e-6  # it arrives
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
        governed = velocity_scaling(q, wished, p)
        speeds = joint_rates_to_actuator_speeds(q, wished, machine.linkages)
        taken = sum(abs(v) * area[0 if v > 0.0 else 1] for v, area in zip(speeds, areas, strict=True))
        assert flow_demand(q, wished, pumps) == pytest.approx(taken, rel=1e-12)
        assert governed.factor * taken <= pumps.limit * (1.0 + 1e-12)
        held += governed.limit == Limit.FLOW
    assert 200 < held < 2000


@pytest.mark.parametrize("sign", [-1.0, 1.0], ids=["retracts", "extends"])
def test_a_cylinder_is_allowed_its_approach_rate_times_the_stroke_that_is_left(sign):
    linkage = load_machine("c180_hoses").linkages[0]
    ends = cylinder_length(P.lower[1], linkage), cylinder_length(P.upper[1], linkage)
    p = P._replace(rates=(math.inf,) * 3, strokes=(NO_STROKE, Stroke(linkage, *ends), NO_STROKE))
    fast = 1000.0  # [rad/s] far over what is allowed, where no corner is rounded
    for angle in np.linspace(P.lower[1] + 0.01, P.upper[1] - 0.01, 30).tolist():
        factor = velocity_scaling((0.0, angle, -1.5), (0.0, sign * fast, 0.0), p).factor
        left = abs(ends[1 if sign > 0.0 else 0] - cylinder_length(angle, linkage))
        speed = lever_arm(angle, linkage) * factor * fast
        assert speed == pytest.approx(P.approach[1] * left, rel=0.01)


def test_outside_its_stroke_a_cylinder_may_only_come_back():
    linkage = load_machine("c180_hoses").linkages[0]
    stroke = Stroke(linkage, cylinder_length(P.lower[1], linkage), cylinder_length(P.upper[1], linkage))
    p = P._replace(strokes=(NO_STROKE, stroke, NO_STROKE))
    beyond = (0.0, P.upper[1] + 0.02, -1.5)
    assert velocity_scaling(beyond, (0.0, 0.1, 0.0), p).factor == 0.0
    assert velocity_scaling(beyond, (0.0, -0.1, 0.0), p).factor == 1.0


@pytest.mark.parametrize("sign", [-1.0, 1.0], ids=["down", "up"])
@pytest.mark.parametrize("joint", range(3))
def test_a_limit_begins_to_be_felt_without_a_corner(joint, sign):
    """The factor by what the limit allows of the wish: a cubic, even at both ends."""
    p = P._replace(rates=(math.inf,) * 3, approach=(1.0, 2.0, 2.0))
    wish = 0.1

    def factor(share):
        q, rates = list(MIDDLE), [0.0, 0.0, 0.0]
        room = share * wish / p.approach[joint]
        q[joint] = p.upper[joint] - room if sign > 0.0 else p.lower[joint] + room
        rates[joint] = sign * wish
        return velocity_scaling(tuple(q), tuple(rates), p).factor

    shares = np.linspace(0.1, FAR_OFF, 241)
    cubic = np.polynomial.Polynomial.fit(shares, [factor(share) for share in shares], 3)
    assert cubic(shares) == pytest.approx([factor(share) for share in shares], abs=1e-9)
    assert (cubic(0.0), cubic.deriv()(0.0)) == pytest.approx((0.0, 1.0), abs=1e-6)
    assert (cubic(FAR_OFF), cubic.deriv()(FAR_OFF)) == pytest.approx((1.0, 0.0), abs=1e-6)
    assert factor(1.01 * FAR_OFF) == factor(9.0) == 1.0


@pytest.mark.parametrize("joint", range(3))
def test_slower_than_a_creep_nothing_goes_towards_a_limit(joint):
    rates = [0.0, 0.0, 0.0]
    rates[joint] = 0.5
    for allowed, moves in ((1.01 * CREEP, True), (0.99 * CREEP, False)):
        q = list(MIDDLE)
        q[joint] = P.upper[joint] - allowed / P.approach[joint]
        assert (velocity_scaling(tuple(q), tuple(rates), P).factor > 0.0) == moves


def test_near_its_dead_point_a_cylinder_counts_by_its_angle():
    """There little stroke turns the joint far, and beyond it the other way."""
    linkage = load_machine("c180_hoses").linkages[0]
    p = P._replace(rates=(math.inf,) * 3, upper=(2.0, 9.0, -0.8), approach=(1.0, 1.0, 1.0))
    p = p._replace(strokes=(NO_STROKE, Stroke(linkage, 0.1, 9.0), NO_STROKE))
    dead = math.pi - linkage.angle_offset
    for arm, by_angle in ((1.1e-3, False), (0.9e-3, True), (-0.2, True)):
        q = brentq(lambda angle, arm=arm: lever_arm(angle, linkage) - arm, dead - 1.0, dead + 0.9)
        allowed = 1e6 * velocity_scaling((0.0, q, -1.5), (0.0, 1e6, 0.0), p).factor
        assert (allowed == pytest.approx(9.0 - q, rel=1e-3)) == by_angle


def test_towards_the_swing_axis_the_tip_is_as_fast_as_twice_what_is_left_and_elsewhere_free():
    rng, seen = np.random.default_rng(8), {"in front": 0, "behind": 0, "within": 0, "outward": 0}
    p = P._replace(lower=(-9.0,) * 3, upper=(9.0,) * 3, rates=(99.0,) * 3, approach=(99.0,) * 3)
    p = p._replace(axis=Axis(LINKS, 1.5))

    def reach(q):
        return math.hypot(*tip_position(q, LINKS)[:2])

    for _ in range(3000):
        q, rates = tuple(rng.uniform(-3.0, 3.0, 3).tolist()), tuple(rng.normal(0.0, 1.0, 3).tolist())
        before, after = (
            reach(tuple(x + dt * u for x, u in zip(q, rates, strict=True))) for dt in (-1e-6, 1e-6)
        )
        inward, distance = (before - after) / 2e-6, reach(q) - 1.5
        if abs(reach(q)) < 0.01 or abs(inward) < 0.01:
            continue
        governed = velocity_scaling(q, rates, p)
        most = max(0.0, 2.0 * distance) / inward if inward > 0.0 else 1.0
        assert governed.factor == pytest.approx(min(1.0, most), rel=1e-4, abs=1e-9)
        assert governed.factor >= 0.0
        front = math.cos(q[0]) * tip_position(q, LINKS)[0] + math.sin(q[0]) * tip_position(q, LINKS)[1] > 0.0
        if governed.limit == Limit.SINGULARITY:
            seen["within" if distance < 0.0 else "in front" if front else "behind"] += 1
        seen["outward"] += inward < 0.0
    assert min(seen.values()) > 50, seen


def test_at_the_swing_axis_rounding_stops_nobody_and_neither_does_the_swing():
    p = P._replace(lower=(-9.0,) * 3, upper=(9.0,) * 3, axis=Axis(LINKS, 9.0))
    q = (0.3, 0.1, -1.0)
    arm = -tip_velocity((0.0, *q[1:]), (0.0, 0.0, -1.0), LINKS)[0]  # inward speed of a stick that folds
    assert velocity_scaling(q, (0.5, 0.0, -0.9 * NEGLIGIBLE / arm), p) == VelocityScaling(1.0, Limit.NONE)
    assert velocity_scaling(q, (0.5, 0.0, -1.1 * NEGLIGIBLE / arm), p) == VelocityScaling(
        0.0, Limit.SINGULARITY
    )
    assert velocity_scaling(q, (0.5, 0.0, 0.0), p) == VelocityScaling(1.0, Limit.NONE)


def test_a_tip_that_may_go_as_near_the_swing_axis_as_it_likes_is_not_held():
    p = P._replace(lower=(-9.0,) * 3, upper=(9.0,) * 3, axis=Axis(LINKS, 0.0))
    boom = math.acos((0.05 - LINKS.base_offset - LINKS.stick) / LINKS.boom)
    q = (0.0, boom, -boom)
    assert tip_position(q, LINKS)[0] == pytest.approx(0.05)
    assert velocity_scaling(q, (0.0, 0.25, 0.0), p) == VelocityScaling(1.0, Limit.NONE)


@pytest.mark.parametrize(("joint", "sign"), list(itertools.product(range(3), (-1.0, 1.0))))
def test_each_actuator_takes_the_oil_of_its_own_inlet(joint, sign):
    machine = load_machine("c180_hoses")
    areas = [displacements(machine, axis) for axis in range(3)]
    areas[0] = areas[0][0], 3.0 * areas[0][1]  # no motor is so, and nobody shall mind
    pumps = Pumps(1.0, *zip(*areas, strict=True), machine.linkages)
    rates = [0.0, 0.0, 0.0]
    rates[joint] = sign * 0.1
    speed = abs(joint_rates_to_actuator_speeds(MIDDLE, tuple(rates), machine.linkages)[joint])
    taken = flow_demand(MIDDLE, tuple(rates), pumps)
    assert taken == pytest.approx(speed * areas[joint][0 if sign > 0.0 else 1])


def test_limits_and_joystick_are_numbered_as_the_docs_tell_who_reads_the_topic():
    text = CODES.read_text("utf-8")
    for heading, states in (("Limits", Limit), ("Joystick", Joystick)):
        section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
        told = re.findall(r"^\| (\d+) \| ([a-z]+) \|", section, re.MULTILINE)
        assert told == [(str(state.value), state.name.lower()) for state in states]
