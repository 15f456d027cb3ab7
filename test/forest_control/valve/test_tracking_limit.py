"""Claims about valves that open less than their file says, and joints that cannot follow."""

import math

import pytest

from forest_control.limits.actuator_speed_limits import RESERVE, joint_rate_limits, speed_limit_parameters
from forest_control.valve.spool_model import SpoolLaw
from forest_control.valve.tracking_limit import (
    FULL,
    NO_TRACKING_LIMIT,
    OpeningRatio,
    bounded,
    ceiling,
    learnt_opening_ratio,
    open_wide,
    updated_limits,
)
from forest_control.valve.valve_adaptation import NO_ESTIMATE, DirectionEstimate
from forest_control.valve.valve_driver_parameters import axis_drivers
from forest_description.machine import load_machine
from forest_sim.sensors.sensor_readings import true_joints
from forest_sim.solver import equilibrium, integrator
from forest_study.closed_loop import model_mismatch

C180 = load_machine("c180_hoses")
AXES = axis_drivers(C180)
CAPACITY = speed_limit_parameters(C180, AXES)
POSE = (0.0, 0.4, -1.4)
DT = 0.005
RATED = (10.0, 10.0, 10.0)
AHEAD, HERE, BEHIND = (0.2, 0.1, 0.1), (0.0, 0.0, 0.0), (0.0, 0.0, 0.02)


def run(tracking_limits, seconds, volts=10.0, axes=AXES, a=AHEAD, e=BEHIND, v=(0.2, 0.1, 0.06)):
    for _ in range(round(seconds / DT)):
        tracking_limits = updated_limits(tracking_limits, (0.0, 0.0, volts), RATED, axes, a, e, v, DT)
    return tracking_limits


def slow(bandwidth):
    """What is known of valves whose spools have a bandwidth [Hz]; none: they follow at once."""
    lag = 0.0 if bandwidth is None else 1.0 / (2.0 * math.pi * bandwidth)
    return tuple(axis._replace(spool=SpoolLaw(lag)) for axis in AXES)


def test_a_valve_as_filed_opens_wholly_and_one_that_is_not_known_counts_as_such():
    assert (
        learnt_opening_ratio((NO_ESTIMATE,) * 3, AXES)
        == FULL
        == OpeningRatio((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    )
    assert [bounded(ratio) for ratio in (math.nan, math.inf, -math.inf)] == [1.0, 1.0, 1.0]
    assert (bounded(1e-3), bounded(0.7), bounded(7.0)) == (0.2, 0.7, 1.0)


def test_a_weaker_valve_with_a_wider_overlap_opens_as_far_as_is_left():
    weak = NO_ESTIMATE._replace(backward=DirectionEstimate(deadband=0.15, stretch=1.0 / 0.6 - 1.0))
    ratio = learnt_opening_ratio((NO_ESTIMATE, NO_ESTIMATE, weak), AXES)
    law = C180.valve_of(2).law.backward
    span = law.rated_voltage - law.deadband_voltage
    assert ratio.backward == pytest.approx((1.0, 1.0, 0.6 * (span - 0.15) / span))
    assert ratio.forward == (1.0, 1.0, 1.0)


def test_planned_rates_are_those_of_the_weaker_plant():
    """The stick's speed at full voltage, of a plant whose valve gives 0.6 of the flow."""
    weak = model_mismatch.draw(0, model_mismatch.Ranges(0.0, 0.0, 1.0, 1.0))._replace(
        gains=(1.0, 1.0, 1.0, 1.0, 0.6, 0.6)
    )
    plant = model_mismatch.applied(C180, weak)
    simulation = equilibrium.equilibrium(POSE, plant)
    for _ in range(800):
        simulation = integrator.step(simulation, (0.0, 0.0, 9.999), 0.001, plant)
    joints = true_joints(simulation, plant)
    ratio = OpeningRatio((1.0, 1.0, 0.6), (1.0, 1.0, 0.6))
    planned = joint_rate_limits(joints.position, joints.speed, CAPACITY, ratio)[2] / RESERVE
    assert planned == pytest.approx(abs(joints.speed[2]), rel=0.05)
    assert joint_rate_limits(joints.position, joints.speed, CAPACITY, FULL)[2] / RESERVE > 1.3 * planned


def test_a_joint_that_falls_behind_with_its_valve_open_wide_is_waited_for():
    for volts in (10.0, -10.0):
        late = run(NO_TRACKING_LIMIT, 0.4, volts).stick
        assert 0.0 < ceiling(late, 0.1) < 0.06  # under what it reaches: it comes back
        assert ceiling(late, -0.1) == math.inf  # the other way nothing is known


@pytest.mark.parametrize("bandwidth", [None, 12.0, 2.0, 0.2])
def test_nobody_waits_for_a_spool_that_is_on_its_way(bandwidth):
    """The voltage is full from the first moment on."""
    axes, there = slow(bandwidth), 0.0 if bandwidth is None else -math.log(0.05) / (2.0 * math.pi * bandwidth)
    if there > 0.0:
        assert run(NO_TRACKING_LIMIT, there - DT, axes=axes).stick.ceiling == math.inf
    assert run(NO_TRACKING_LIMIT, there + 2.0 * DT, axes=axes).stick.ceiling < AHEAD[2]


def test_nobody_waits_for_a_joint_that_keeps_up_or_whose_valve_has_room():
    assert run(NO_TRACKING_LIMIT, 1.0, 9.0).stick.ceiling == math.inf
    assert run(NO_TRACKING_LIMIT, 1.0, e=HERE).stick.ceiling == math.inf
    assert run(NO_TRACKING_LIMIT, 1.0, e=(0.0, 0.0, -0.02)).stick.ceiling == math.inf


def test_waiting_ends_once_the_valve_has_room():
    late = run(NO_TRACKING_LIMIT, 0.5)
    ceilings = [run(late, seconds, 5.0).stick.ceiling for seconds in (0.25, 0.5, 3.0)]
    assert late.stick.ceiling < ceilings[0] < ceilings[1]
    assert ceilings[2] > 2.0  # faster than any joint


@pytest.mark.parametrize("way", ["forward", "backward"])
@pytest.mark.parametrize("joint", range(3))
def test_what_is_learnt_of_one_way_of_one_valve_is_no_other_s(joint, way):
    """No two edges are alike."""
    axes = []
    for i, axis in enumerate(axis_drivers(load_machine("loader"))):
        ahead = axis.valve.forward._replace(deadband_voltage=0.5 + 0.1 * i)
        back = axis.valve.backward._replace(deadband_voltage=1.5 + 0.1 * i)
        axes.append(axis._replace(valve=axis.valve._replace(forward=ahead, backward=back)))
    estimates = [NO_ESTIMATE] * 3
    estimates[joint] = NO_ESTIMATE._replace(**{way: DirectionEstimate(deadband=0.5)})
    ratio = learnt_opening_ratio(tuple(estimates), tuple(axes))
    edge = getattr(axes[joint].valve, way)
    left = 1.0 - 0.5 / (edge.rated_voltage - edge.deadband_voltage)
    expected = {"forward": [1.0] * 3, "backward": [1.0] * 3}
    expected[way][joint] = left
    assert ratio.forward == pytest.approx(tuple(expected["forward"]))
    assert ratio.backward == pytest.approx(tuple(expected["backward"]))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("joint", range(3))
def test_a_valve_is_open_wide_from_95_percent_of_its_own_rating_on(joint, sign):
    rated = 10.0, 8.0, 6.0
    for share, wide in ((0.94, False), (0.95, True), (1.0, True)):
        spools = tuple(sign * share * rated[i] if i == joint else 0.0 for i in range(3))
        assert open_wide(spools, rated) == tuple(wide and i == joint for i in range(3))


def behind(joint, sign=1.0, error=0.02, rate=0.15, wish=0.2):
    """A joint that falls behind with its valve open wide, the others keep up: what `strained` is told."""

    def at(value, others):
        return tuple(sign * value if i == joint else others for i in range(3))

    return {"voltages": at(10.0, 1.0), "a": at(wish, 0.05), "e": at(error, 0.0), "v": at(rate, 0.05)}


def joints_of(tracking_limits):
    return tracking_limits.swing, tracking_limits.boom, tracking_limits.stick


def told(tracking_limits, seconds, **what):
    for _ in range(round(seconds / DT)):
        tracking_limits = updated_limits(tracking_limits, rated=RATED, axes=slow(None), dt=DT, **what)
    return tracking_limits


every_joint_both_ways = pytest.mark.parametrize(
    ("joint", "sign"), [(joint, sign) for joint in range(3) for sign in (-1.0, 1.0)]
)


@every_joint_both_ways
def test_the_wait_is_for_the_joint_that_falls_behind_alone_and_lets_it_come_back(joint, sign):
    """Its reference goes slower than it moves by 4 /s of what it is behind."""
    tracking_limits = joints_of(told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign)))
    assert ceiling(tracking_limits[joint], sign) == pytest.approx(0.15 - 4.0 * 0.02, rel=1e-4)
    assert ceiling(tracking_limits[joint], -sign) == ceiling(tracking_limits[joint], 0.0) == math.inf
    for other in (strain for i, strain in enumerate(tracking_limits) if i != joint):
        assert ceiling(other, 9.0) == ceiling(other, -9.0) == ceiling(other, 0.0) == math.inf


@every_joint_both_ways
def test_the_wait_begins_within_three_hundredths_of_a_second_and_never_jumps(joint, sign):
    first = joints_of(told(NO_TRACKING_LIMIT, DT, **behind(joint, sign)))[joint].ceiling
    assert first == pytest.approx(0.07 + 0.13 * math.exp(-DT / 0.03))
    after = joints_of(told(NO_TRACKING_LIMIT, 0.03, **behind(joint, sign)))[joint].ceiling
    assert after == pytest.approx(0.07 + 0.13 * math.exp(-1.0))


@every_joint_both_ways
def test_a_joint_that_is_stuck_is_still_asked_to_move(joint, sign):
    stuck = joints_of(told(NO_TRACKING_LIMIT, 1.0, **behind(joint, sign, error=0.05, rate=0.0)))[joint]
    assert ceiling(stuck, sign) == pytest.approx(0.01, rel=1e-4)


@every_joint_both_ways
def test_up_to_a_milliradian_behind_nothing_is_wrong(joint, sign):
    assert (
        joints_of(told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign, error=1e-3)))[joint].ceiling == math.inf
    )
    assert (
        joints_of(told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign, error=1.01e-3)))[joint].ceiling
        < math.inf
    )


@every_joint_both_ways
def test_a_joint_that_nobody_wishes_to_move_is_not_waited_for(joint, sign):
    assert joints_of(told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign, wish=0.0)))[joint].ceiling == math.inf
    assert (
        joints_of(told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign, wish=-0.1)))[joint].ceiling == math.inf
    )


@every_joint_both_ways
def test_a_wait_grows_by_e_in_half_a_second_and_never_ends_its_growth(joint, sign):
    late = told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign))
    room = {**behind(joint, sign), "voltages": (0.0, 0.0, 0.0)}
    before, after = joints_of(late)[joint], joints_of(told(late, 0.5, **room))[joint]
    assert after.ceiling == pytest.approx(math.e * before.ceiling)
    assert after.side == sign
    long = joints_of(told(late, 3.0, **room))[joint]
    assert long.ceiling == pytest.approx(math.exp(6.0) * before.ceiling)


@every_joint_both_ways
def test_a_wait_never_rises_while_the_joint_still_falls_behind_and_one_way_s_is_not_the_other_s(joint, sign):
    late = told(NO_TRACKING_LIMIT, 0.5, **behind(joint, sign))
    faster = joints_of(told(late, DT, **behind(joint, sign, rate=0.9, wish=0.9)))[joint]
    assert faster.ceiling == joints_of(late)[joint].ceiling
    turned = joints_of(told(late, DT, **behind(joint, -sign)))[joint]
    assert turned.side == -sign
    assert turned.ceiling == joints_of(told(NO_TRACKING_LIMIT, DT, **behind(joint, sign)))[joint].ceiling


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("joint", range(3))
def test_before_any_voltage_the_spools_are_centred(joint, sign):
    volts = tuple(10.0 * sign if i == joint else 0.0 for i in range(3))
    tracking_limits = updated_limits(
        NO_TRACKING_LIMIT, volts, RATED, slow(2.0), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, 0.05
    )
    there = sign * 10.0 * (1.0 - math.exp(-2.0 * math.pi * 2.0 * 0.05))
    assert tracking_limits.spools == pytest.approx(tuple(there if i == joint else 0.0 for i in range(3)))
