"""Claims about links that bend: where they are by their joints' angles, and that the tip keeps its path."""

import dataclasses
import math

import numpy as np
import pytest

from forest_control.limits.actuator_speed_limits import speed_limit_parameters
from forest_control.servo.arm_feedforward import arm_model, yielding_rates
from forest_control.servo.link_bending import link_angles, pushed
from forest_control.servo.schemes import Scheme
from forest_control.servo.swing_feedforward import inertia, swing_model
from forest_control.valve.valve_driver_parameters import axis_drivers
from forest_description.derived.limits import joint_limits
from forest_description.machine import load_machine
from forest_description.mechanics.elasticity_parameters import Elasticity
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.mechanics.manipulator import dynamics, fold_head
from forest_sim.simulation.load_schedule import Load, loaded
from forest_sim.solver.equilibrium import equilibrium
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import noisy, track


def linked(machine, swing, boom, stick):
    """A machine with the stiffness of the column, the boom and the stick."""
    return dataclasses.replace(
        machine,
        swing=dataclasses.replace(machine.swing, elasticity=swing),
        boom=dataclasses.replace(machine.boom, elasticity=boom),
        stick=dataclasses.replace(machine.stick, elasticity=stick),
    )


RIGID = linked(load_machine("c180"), None, None, None)
BENT = linked(
    RIGID,
    Elasticity(stiffness=1.0e7, damping=1.3e4, root_inertia=30.0),
    Elasticity(stiffness=5.5e7, damping=2.6e4, root_inertia=100.0),
    Elasticity(stiffness=1.4e7, damping=9400.0, root_inertia=80.0),
)
ARM, SWING = arm_model(BENT), swing_model(BENT)
LOW, HIGH = np.array(joint_limits(BENT)).T


def links(joints, mass, machine=BENT):
    crane = speed_limit_parameters(machine, axis_drivers(machine))
    return link_angles(joints, mass, crane, arm_model(machine))


POSES = [tuple(q) for q in np.random.default_rng(4).uniform(LOW, HIGH, (8, 3)).tolist()]


@pytest.mark.parametrize("mass", [0.0, 900.0])
@pytest.mark.parametrize("pose", POSES)
def test_the_links_at_rest_are_where_the_plants_are_by_its_joints_and_load(pose, mass):
    at = equilibrium(pose, loaded(plant_parameters(BENT), BENT.manipulator, Load(mass))).plant
    joints = at.swing.angle, at.roots.boom.angle, at.roots.stick.angle
    assert max(joints[1] - at.boom.angle, joints[2] - at.stick.angle) > 3e-4
    found = links(joints, mass)
    assert found == pytest.approx((at.swing.angle, at.boom.angle, at.stick.angle), abs=4e-5)


def test_a_load_that_nobody_weighs_counts_as_none_and_rigid_links_are_where_their_joints_are():
    assert links(POSES[0], math.nan) == links(POSES[0], 0.0)
    assert links(POSES[0], 900.0, RIGID) == POSES[0]


@pytest.mark.parametrize("pose", POSES)
def test_links_that_are_speeded_up_stay_behind_by_the_plants_inertia(pose):
    crane = dataclasses.replace(BENT.manipulator, pendulum=None)
    b, plant = (0.7, -0.4, 0.9), dynamics(pose, (0.0, 0.0, 0.0), fold_head(crane))
    behind = pushed(pose, b, inertia(pose, SWING), SWING.compliance, ARM)
    assert behind[0] == pytest.approx(inertia(pose, SWING) * b[0] / 1.0e7)
    assert behind[1] == pytest.approx((plant.m_22 * b[1] + plant.m_23 * b[2]) / 5.5e7, rel=1e-6)
    assert behind[2] == pytest.approx((plant.m_23 * b[1] + plant.m_33 * b[2]) / 1.4e7, rel=1e-6)


def test_what_bends_further_as_the_load_grows_is_fed_forward_beside_the_oil():
    a, b, c = (0.0, 0.1, 0.1), (0.0, 0.2, -0.2), (0.0, 1.0, 0.5)
    bent, rigid = yielding_rates(POSES[0], a, b, c, ARM), yielding_rates(POSES[0], a, b, c, arm_model(RIGID))
    h, ends = 1e-5, []
    for sign in (1.0, -1.0):
        there = tuple(x + sign * h * y + 0.5 * h * h * z for x, y, z in zip(POSES[0], a, b, strict=True))
        speeding = tuple(x + sign * h * y for x, y in zip(b, c, strict=True))
        behind, at = pushed(there, speeding, 0.0, 0.0, ARM), links(there, 0.0)
        ends.append([behind[i] + there[i] - at[i] for i in (1, 2)])
    grows = [(x - y) / (2.0 * h) for x, y in zip(*ends, strict=True)]
    assert [x - y for x, y in zip(bent, rigid, strict=True)] == pytest.approx(grows, rel=1e-4)


def test_the_tip_keeps_its_path_on_links_that_bend():
    """Radial at 0.5 m/s: against a controller that believes them rigid."""
    known, unknown = (
        track(path_named("radial"), 0.5, Scheme.COORDINATED, BENT, model, noisy(BENT, 3)).total
        for model in (BENT, RIGID)
    )
    assert known.governed_rms_mm < 2.2
    assert unknown.governed_rms_mm > 5.0
