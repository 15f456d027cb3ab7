"""Claims about actuator speeds."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.derived.actuator_kinematics import (
    actuator_speeds_to_joint_rates,
    joint_rates_to_actuator_speeds,
    rated_speeds,
)
from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import cylinder_length, linkage_of
from forest_description.machine import load_machine

MACHINE, LOADER = load_machine("c180_hoses"), load_machine("loader")


def random_poses(count=100):
    lower, upper = np.array(joint_limits(MACHINE)).T
    return [tuple(q) for q in np.random.default_rng(5).uniform(lower, upper, (count, 3)).tolist()]


def test_swing_orifices_share_the_pump_pressure_at_rated_speed():
    flow = rated_speeds(MACHINE)[0] * 35.16 * 82 / 13 * 4.5064e-5 / (2.0 * math.pi)
    assert 2.0 * 1.04e12 * flow**2 == pytest.approx(3000 * 6894.7, rel=1e-12)


@pytest.mark.parametrize("axis", [1, 2])
def test_unloaded_cylinder_is_in_balance_at_rated_speed(axis):
    speed, head, rod = rated_speeds(MACHINE)[axis], 1.824e-2, 1.368e-2
    head_pressure = 3000 * 6894.7 - 1.04e12 * (head * speed) ** 2
    rod_pressure = 1.04e12 * (rod * speed) ** 2
    assert head * head_pressure == pytest.approx(rod * rod_pressure, rel=1e-12)


def test_rated_speeds_of_the_c180():
    assert rated_speeds(MACHINE) == pytest.approx((1.98252, 0.205044, 0.205044), rel=1e-5)


def test_actuator_speed_is_the_time_derivative_of_the_cylinder_length():
    rates, step = (0.2, -0.3, 0.4), 1e-6
    for q in random_poses():
        speeds = joint_rates_to_actuator_speeds(q, rates, MACHINE.linkages)
        assert speeds[0] == rates[0]
        for axis, linkage in zip((1, 2), MACHINE.linkages, strict=True):
            ahead, behind = (cylinder_length(q[axis] + s * step * rates[axis], linkage) for s in (1, -1))
            assert speeds[axis] == pytest.approx((ahead - behind) / (2.0 * step), abs=1e-9)


def test_joint_rates_come_back_from_actuator_speeds():
    rates = (0.2, -0.3, 0.4)
    for q in random_poses():
        speeds = joint_rates_to_actuator_speeds(q, rates, MACHINE.linkages)
        assert actuator_speeds_to_joint_rates(q, speeds, MACHINE.linkages) == pytest.approx(rates, abs=1e-14)


def test_dead_point_of_a_linkage_gives_no_rate_instead_of_an_error():
    dead = linkage_of(*MACHINE.boom.linkage[:2], 0.0)
    assert actuator_speeds_to_joint_rates((0.0, 0.0, -1.5), (0.0, 0.1, 0.0), (dead, dead))[1] == 0.0


def test_with_a_load_sensing_pump_the_inlet_s_orifice_takes_the_margin_at_rated_speed():
    flow = rated_speeds(LOADER)[0] * 21 * 80e-6 / (2.0 * math.pi)
    assert 2.6e13 * flow**2 == pytest.approx(22e5, rel=1e-12)


def test_no_rated_speed_asks_for_more_than_the_pump_s_full_flow():
    full = pytest.approx(28e-6 * 1450.0 / 60.0, rel=1e-12)
    _, boom, stick = rated_speeds(LOADER)
    assert (boom * 50.265e-4, stick * 38.485e-4) == (full, full)
    small = dataclasses.replace(MACHINE, pump=dataclasses.replace(MACHINE.pump, count=1.0, shaft_speed=20.0))
    swing, boom, stick = rated_speeds(small)
    flow = small.pump.flow_limit
    assert (boom * 1.824e-2, stick * 1.824e-2) == pytest.approx((flow, flow))
    assert swing < rated_speeds(MACHINE)[0]
