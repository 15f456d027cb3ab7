"""Claims about what is fed forward to boom and stick: the plant's torques, and the springs of oil."""

import dataclasses
import math

import numpy as np
import pytest

from forest_control.servo.arm_feedforward import (
    Seal,
    arm_model,
    friction_rate,
    stiffness,
    torque_rates,
    yielding_rates,
)
from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import cylinder_length, lever_arm
from forest_description.machine import load_machine
from forest_sim.mechanics.friction import friction, friction_force
from forest_sim.mechanics.manipulator import dynamics, fold_head

C180, REAL = load_machine("c180_hoses"), load_machine("c180")
FIXED = dataclasses.replace(REAL, manipulator=dataclasses.replace(REAL.manipulator, pendulum=None))
ARM, STILL = arm_model(REAL), (0.0, 0.0, 0.0)
RNG = np.random.default_rng(8)
LOW, HIGH = np.array(joint_limits(REAL)).T
POSES = [tuple(q) for q in RNG.uniform(LOW, HIGH, (20, 3)).tolist()]


def torques(q, b):
    """The plant's torques on boom and stick, its head as a point at the tip."""
    plant = dynamics(q, STILL, fold_head(FIXED.manipulator))
    boom = plant.bias[1] + plant.m_22 * b[1] + plant.m_23 * b[2]
    return boom, plant.bias[2] + plant.m_23 * b[1] + plant.m_33 * b[2]


@pytest.mark.parametrize("q", POSES)
def test_the_rates_are_those_of_the_plants_torques_along_the_motion(q):
    a, b, c = (tuple(three) for three in RNG.normal(0.0, (0.2,), (3, 3)).tolist())
    h, ahead, behind = 1e-5, [], []
    for sign, into in ((1.0, ahead), (-1.0, behind)):
        there = tuple(x + sign * h * y + 0.5 * h * h * z for x, y, z in zip(q, a, b, strict=True))
        into += torques(there, tuple(x + sign * h * y for x, y in zip(b, c, strict=True)))
    numbers = [(x - y) / (2.0 * h) for x, y in zip(ahead, behind, strict=True)]
    assert torque_rates(q, a, b, c, ARM) == pytest.approx(numbers, rel=1e-6, abs=1.0)


@pytest.mark.parametrize("axis", [1, 2])
def test_a_cylinder_is_as_stiff_as_the_oil_on_both_sides_of_its_piston(axis):
    """By the volumes that the machine file gives."""
    drive, model = REAL.drives[axis], (ARM.boom, ARM.stick)[axis - 1]
    for angle in (joint_limits(REAL)[axis][0] + 0.2, joint_limits(REAL)[axis][1] - 0.2):
        x, arm = cylinder_length(angle, drive.linkage), lever_arm(angle, drive.linkage)
        out = x - drive.retracted_length
        head = drive.chambers.head_dead_volume + drive.head_area * out
        rod = drive.chambers.rod_dead_volume + drive.rod_area * (drive.stroke - out)
        beta = REAL.oil.bulk_modulus
        one = drive.head_area**2 / (REAL.line(axis, 1).capacitance + head / beta)
        two = drive.rod_area**2 / (REAL.line(axis, 2).capacitance + rod / beta)
        assert stiffness(angle, model, drive.linkage) == pytest.approx((one + two) * arm * arm)


@pytest.mark.parametrize("b", [0.1, -0.3])
def test_the_seals_friction_adds_up_to_the_plants_at_speed(b):
    """From rest on, under constant acceleration, without the Stribeck effect that is left out."""
    drive, dt, angle = REAL.boom, 1e-4, 0.4
    seal, arm = Seal(5000.0, 0.002), lever_arm(angle, drive.linkage)
    total = sum(dt * friction_rate(angle, b * dt * (k + 0.5), b, seal, drive.linkage) for k in range(20000))
    flat = dataclasses.replace(
        drive.friction, coulomb_force=5000.0, breakaway_force=5000.0, pressure_coefficient=None
    )
    speed = arm * b * 2.0
    assert total == pytest.approx(arm * friction_force(speed, friction(flat)), rel=1e-3)
    assert math.copysign(1.0, total) == math.copysign(1.0, b)


def test_nothing_is_added_where_the_machine_file_knows_no_chambers():
    moving = (0.0, 0.1, 0.1)
    assert yielding_rates((0.0, 0.5, -1.5), moving, moving, moving, arm_model(C180)) == (0.0, 0.0)
    assert min(map(abs, yielding_rates((0.0, 0.5, -1.5), moving, moving, moving, ARM))) > 1e-5
