"""Claims about valves that reach less than their file says, and joints that cannot follow."""

import math

import pytest

from forest_control.capacity import RESERVE, capacity, greatest_rates
from forest_control.valve_adaptation import UNLEARNT, WayEstimate
from forest_control.valve_driver import axis_drivers
from forest_control.valve_reach import (
    FULL,
    LEAST,
    MOST,
    RELAXED,
    Reach,
    bounded,
    ceiling,
    learnt_reach,
    strained,
)
from forest_description.machine import load_machine
from forest_sim import equilibrium, integrator
from forest_sim.sensors import true_joints
from forest_study import mismatch

C180 = load_machine("c180")
AXES = axis_drivers(C180)
CAPACITY = capacity(C180, AXES)
POSE = (0.0, 0.4, -1.4)
DT = 0.005
RATED = (10.0, 10.0, 10.0)
AHEAD, HERE, BEHIND = (0.2, 0.1, 0.1), (0.0, 0.0, 0.0), (0.0, 0.0, 0.02)


def run(strains, seconds, volts=10.0, axes=AXES, a=AHEAD, e=BEHIND, v=(0.2, 0.1, 0.06)):
    for _ in range(round(seconds / DT)):
        strains = strained(strains, (0.0, 0.0, volts), RATED, axes, a, e, v, DT)
    return strains


def slow(bandwidth):
    """What is known of valves whose spools have a bandwidth [Hz]; none: they follow at once."""
    lag = 0.0 if bandwidth is None else 1.0 / (2.0 * math.pi * bandwidth)
    return tuple(axis._replace(spool_lag=lag) for axis in AXES)


def test_a_valve_as_filed_reaches_everything_and_one_that_is_not_known_counts_as_such():
    assert learnt_reach((UNLEARNT,) * 3, AXES) == FULL
    assert bounded(math.nan) == 1.0
    assert (bounded(1e-3), bounded(7.0)) == (LEAST, MOST)


def test_a_weaker_valve_with_a_wider_overlap_reaches_what_is_left():
    weak = UNLEARNT._replace(backward=WayEstimate(deadband=0.15, stretch=1.0 / 0.6 - 1.0))
    reach = learnt_reach((UNLEARNT, UNLEARNT, weak), AXES)
    law = C180.valve_of(2).law.backward
    span = law.rated_voltage - law.deadband_voltage
    assert reach.backward == pytest.approx((1.0, 1.0, 0.6 * (span - 0.15) / span))
    assert reach.forward == (1.0, 1.0, 1.0)


def test_planned_rates_are_those_of_the_weaker_plant():
    """The stick's speed at full voltage, of a plant whose valve gives 0.6 of the flow."""
    weak = mismatch.Mismatch((0.0,) * 6, (1.0, 1.0, 1.0, 1.0, 0.6, 0.6), 1.0, 1.0)
    plant = mismatch.applied(C180, weak)
    simulation = equilibrium.equilibrium(POSE, plant)
    for _ in range(800):
        simulation = integrator.step(simulation, (0.0, 0.0, 9.999), 0.001, plant)
    joints = true_joints(simulation, plant)
    reach = Reach((1.0, 1.0, 0.6), (1.0, 1.0, 0.6))
    planned = greatest_rates(joints.position, joints.speed, CAPACITY, reach)[2] / RESERVE
    assert planned == pytest.approx(abs(joints.speed[2]), rel=0.05)
    assert greatest_rates(joints.position, joints.speed, CAPACITY, FULL)[2] / RESERVE > 1.3 * planned


def test_a_joint_that_falls_behind_with_its_valve_open_wide_is_waited_for():
    for volts in (10.0, -10.0):
        late = run(RELAXED, 0.4, volts).stick
        assert 0.0 < ceiling(late, 0.1) < 0.06  # under what it reaches: it comes back
        assert ceiling(late, -0.1) == math.inf  # the other way nothing is known


@pytest.mark.parametrize("bandwidth", [None, 12.0, 2.0, 0.2])
def test_nobody_waits_for_a_spool_that_is_on_its_way(bandwidth):
    """The voltage is full from the first moment on."""
    axes, there = slow(bandwidth), 0.0 if bandwidth is None else -math.log(0.05) / (2.0 * math.pi * bandwidth)
    if there > 0.0:
        assert run(RELAXED, there - DT, axes=axes).stick.ceiling == math.inf
    assert run(RELAXED, there + 2.0 * DT, axes=axes).stick.ceiling < AHEAD[2]


def test_nobody_waits_for_a_joint_that_keeps_up_or_whose_valve_has_room():
    assert run(RELAXED, 1.0, 9.0).stick.ceiling == math.inf
    assert run(RELAXED, 1.0, e=HERE).stick.ceiling == math.inf
    assert run(RELAXED, 1.0, e=(0.0, 0.0, -0.02)).stick.ceiling == math.inf


def test_waiting_ends_once_the_valve_has_room():
    late = run(RELAXED, 0.5)
    ceilings = [run(late, seconds, 5.0).stick.ceiling for seconds in (0.25, 0.5, 3.0)]
    assert late.stick.ceiling < ceilings[0] < ceilings[1]
    assert ceilings[2] == math.inf
