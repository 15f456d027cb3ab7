"""The controller's idea of the crane as a load agrees with the plant's dynamics."""

import dataclasses

import numpy as np
import pytest

from forest_control.limits.actuator_speed_limits import (
    gravity_torques,
    joint_rate_limits,
    speed_limit_parameters,
)
from forest_control.servo.swing_feedforward import inertia, swing_model
from forest_control.valve.tracking_limit import FULL
from forest_control.valve.valve_driver_parameters import axis_drivers
from forest_description.derived.actuator_kinematics import displacements
from forest_description.derived.limits import joint_limits
from forest_description.machine import load_machine
from forest_sim.mechanics.manipulator import dynamics, fold_head

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")
BODY = fold_head(C180.manipulator)
CAPACITY = speed_limit_parameters(C180, axis_drivers(C180))


def poses(count=20):
    low, high = np.array(joint_limits(C180)).T
    return [tuple(q) for q in np.random.default_rng(5).uniform(low, high, (count, 3)).tolist()]


def test_inertia_about_the_swing_axis_is_the_plants():
    load = swing_model(C180)
    for q in poses():
        assert inertia(q, load) == pytest.approx(dynamics(q, (0.0, 0.0, 0.0), BODY).m_11, rel=1e-12)


def test_a_head_that_hangs_weighs_on_its_joint_as_one_that_is_fixed_there():
    real = load_machine("c180")
    hanging = real.manipulator
    fixed = dataclasses.replace(real, manipulator=dataclasses.replace(hanging, pendulum=None))
    capacities = [speed_limit_parameters(one, axis_drivers(one)) for one in (real, fixed)]
    for q in poses():
        assert gravity_torques(q, capacities[0]) == pytest.approx(
            gravity_torques(q, capacities[1]), rel=1e-12
        )
        # Sideways it is left behind: it sways.
        assert inertia(q, swing_model(real)) < inertia(q, swing_model(fixed))


def test_a_load_sensing_pump_leaves_its_margin_for_either_edge_of_the_swings_valve():
    """A pump of constant pressure leaves all of it."""
    for machine, pressure in ((C180, C180.pump.supply_pressure), (LOADER, 2.0 * LOADER.pump.margin)):
        assert swing_model(machine).valve_drop == pytest.approx(displacements(machine, 0)[0] * pressure)


def test_hose_and_chamber_on_either_side_are_springs_of_the_swing():
    """The forwarder's racks hold five times as much oil as their hoses."""
    for machine, softer in ((load_machine("forwarder"), 5.0), (C180, 1.0)):
        oil, chambers = displacements(machine, 0)[0], machine.swing.chambers
        held = chambers.port_volume / machine.oil.bulk_modulus if chambers else 0.0
        hoses = [machine.line(0, port).capacitance for port in (1, 2)]
        springs = sum(oil**2 / (hose + held) for hose in hoses)
        assert swing_model(machine).stiffness == pytest.approx(springs, rel=1e-12)
        assert sum(oil**2 / hose for hose in hoses) >= softer * springs


def test_gravity_torques_are_the_plants():
    for q in poses():
        bias = dynamics(q, (0.0, 0.0, 0.0), BODY).bias
        assert gravity_torques(q, CAPACITY) == pytest.approx(bias[1:], rel=1e-9, abs=1e-6)


def test_a_boom_falls_faster_than_it_rises():
    q = (0.0, 0.3, -1.5)
    up = joint_rate_limits(q, (0.1, 0.1, 0.1), CAPACITY, FULL)
    down = joint_rate_limits(q, (-0.1, -0.1, -0.1), CAPACITY, FULL)
    assert 0.0 < up[1] < down[1]
    assert up[0] == pytest.approx(down[0])
