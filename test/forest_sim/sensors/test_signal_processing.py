"""Claims about what is derived from readings, and what becomes of it when a reading is wrong or missing."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import EXACT_SUITE, draw, noise_generator, sensor_suite
from forest_sim.solver.equilibrium import equilibrium

MACHINE = load_machine("c180_hoses")
P = plant_parameters(MACHINE)
Q = (0.3, 0.5, -1.5)
REST = equilibrium(Q, P)
DT = 0.005
LABELS = topics.PRESSURES.labels


def watch(simulation, suite, count, dt=DT):
    """What a suite says of a machine that stands still, `count` times."""
    state, generator, said = sensor_readings.at_rest(simulation, P, suite), noise_generator(suite), []
    for _ in range(count):
        state, seen = sensor_readings.measure(simulation, state, P, dt, suite, draw(generator))
        said.append(seen)
    return said


def faulty(text):
    return sensor_suite(MACHINE, faults=parse_faults(text))


def turned(simulation, by):
    """The same state with the swing turned [rad]."""
    swing = simulation.plant.swing
    return simulation._replace(plant=simulation.plant._replace(swing=swing._replace(angle=swing.angle + by)))


def test_forces_and_torques_follow_the_pressures_that_are_read():
    biased = watch(REST, faulty("boom_pressure_1_actuator: bias 1 MPa"), 1)[0]
    exact = watch(REST, EXACT_SUITE, 1)[0]
    more = 1e6 * MACHINE.boom.head_area
    assert biased.actuators.effort[1] - exact.actuators.effort[1] == pytest.approx(more)
    arm = lever_arm(Q[1], P.boom_linkage)
    assert biased.joints.effort[1] - exact.joints.effort[1] == pytest.approx(more * arm)
    assert biased.joints.effort[2] == exact.joints.effort[2]


def test_what_is_absent_has_no_reading_and_nothing_derived_from_it():
    seen = watch(REST, faulty("boom_resolver: absent; stick_pressure_2_actuator: absent"), 2)[-1]
    assert np.isnan(seen.joints.position).tolist() == [False, True, False]
    assert np.isnan(seen.joints.speed).tolist() == [False, True, False]
    assert np.isnan(seen.joints.effort).tolist() == [False, True, True]
    assert np.isnan(seen.actuators.position).tolist() == [False, False, False]
    assert np.isnan(seen.actuators.effort).tolist() == [False, False, True]
    assert np.flatnonzero(np.isnan(seen.pressures)).tolist() == [LABELS.index("stick_2_actuator")]


def test_the_swings_resolver_serves_joint_and_motor():
    seen = watch(REST, faulty("swing_resolver: absent"), 1)[0]
    assert math.isnan(seen.joints.position[0])
    assert math.isnan(seen.actuators.position[0])


def turning(suite, count):
    """Rates of a swing that turns at 0.4 rad/s, as a suite's speed estimate has them."""
    state, simulation, rates = sensor_readings.at_rest(REST, P, suite), REST, []
    for _ in range(count):
        simulation = turned(simulation, 0.4 * DT)
        state, seen = sensor_readings.measure(simulation, state, P, DT, suite, draw(DICE))
        rates.append(seen.joints.speed[0])
    return np.array(rates)


DICE = np.random.default_rng(7)


def test_a_frozen_angle_stands_still_and_its_speed_dies_away():
    rates = turning(faulty("swing_resolver: frozen from 0.2 s"), 80)
    assert rates[38] == pytest.approx(0.4, rel=1e-2)
    assert abs(rates[-1]) < 1e-6


def test_lost_samples_do_not_look_like_jumps():
    rates = turning(faulty("swing_resolver: drop 30 %"), 200)
    there = rates[~np.isnan(rates)]
    assert 100 < len(there) < 180
    assert there[50:] == pytest.approx(0.4, rel=1e-3)


def test_angles_by_the_cylinders_are_those_at_which_the_linkage_has_the_lengths_read():
    sensors = dataclasses.replace(MACHINE.sensors, joint_angles="linear_transducer")
    crane = dataclasses.replace(MACHINE, sensors=sensors)
    seen = watch(REST, sensor_suite(crane), 2)[-1]
    assert seen.joints.position == pytest.approx(Q, abs=1e-14)
    longer = watch(REST, sensor_suite(crane, faults=parse_faults("boom_transducer: bias 1 mm")), 1)[0]
    by_arm = 1e-3 / lever_arm(Q[1], P.boom_linkage)
    assert longer.joints.position[1] - Q[1] == pytest.approx(by_arm, rel=0.01)
    assert longer.joints.position[2] == seen.joints.position[2]
    none = watch(REST, sensor_suite(crane, faults=parse_faults("stick_transducer: bias 9 m")), 1)[0]
    assert np.isnan(none.joints.position).tolist() == [False, False, True]  # no triangle has that side
