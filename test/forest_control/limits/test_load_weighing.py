"""The load is weighed by the boom's pressures: over poses, in slow motion, with sensors as they are."""

import dataclasses
import math

import numpy as np
import pytest
from compiled_rows import states_of

from forest_control.config import controller_settings
from forest_control.limits.load_weighing import (
    LOST,
    SETTLED,
    UNKNOWN,
    UNREAD,
    Weighing,
    weighed,
    weighing_parameters,
)
from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.pipeline.control_state import REST, State, stopped
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_readings import at_rest, measure
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.load_schedule import Load, loaded
from forest_sim.solver.equilibrium import equilibrium
from forest_study.closed_loop import compiled_loop

REAL = load_machine("c180")
STROKES = ((0.0, 0.0, 0.2), (0.0, 0.0, -0.2), (0.2, 0.0, 0.0), (-0.2, 0.2, 0.0))  # [m/s] of the tip


def slow_motion(name, mass, tip, seed, rate=200.0):
    """The masses that are told while the tip goes to and fro, from 1 s after its first motion on.

    Its sensors are sampled at a rate [Hz].
    """
    machine, levers = load_machine(name), []
    plant = loaded(plant_parameters(machine), machine.manipulator, Load(mass))
    settings = controller_settings.Settings(), valve_driver_parameters.Settings()
    sampled = dataclasses.replace(machine, sensors=dataclasses.replace(machine.sensors, sample_rate=rate))
    suite = sensor_suite(sampled, noise=True, seed=seed)
    for k in range(1200):
        part, phase = divmod(k - 100, 275)
        velocity = STROKES[part % 4] if k >= 100 and phase < 225 else ZERO
        levers.append((*levers_for_tip_velocity(velocity, 0.5), 1.0))
    given = machine, np.array(levers), pose_at(tip, machine), *settings
    session = compiled_loop.prepared(*given, suite=suite, plant=plant)
    return np.array(list(states_of(session, "control.state.weighing.mass")))[300:, 0]


@pytest.mark.parametrize("tip", [(5.0, 0.0, 0.0), (6.0, 1.0, 1.5), (7.0, 0.0, -1.0)])
@pytest.mark.parametrize(
    ("name", "mass", "within"),
    # Of the log; of a light one, of all that is at the tip: the head is weighed along with it.
    [("c180_hoses", 500.0, 0.05 * 500.0), ("c180", 1000.0, 0.05 * 1000.0), ("c180", 0.0, 0.05 * 700.0)],
)
def test_in_slow_motion_the_load_is_weighed_within_five_per_cent(name, mass, within, tip):
    told = slow_motion(name, mass, tip, seed=int(10.0 * tip[0]))
    assert abs(told - mass).max() < within


@pytest.mark.parametrize(("name", "mass"), [("c180_hoses", 500.0), ("c180", 1000.0)])
def test_with_sensors_at_50_hz_the_load_is_weighed_as_well(name, mass):
    assert abs(slow_motion(name, mass, (6.0, 1.0, 1.5), 60, rate=50.0) - mass).max() < 0.05 * mass


@pytest.mark.parametrize("name", ["c180_hoses", "c180", "forwarder", "loader"])
def test_a_machine_that_stands_is_weighed_exactly_by_exact_sensors(name):
    machine, rng = load_machine(name), np.random.default_rng(3)
    far = machine.manipulator.links.boom + machine.manipulator.links.stick
    for mass in (0.0, 150.0, 400.0):
        plant = loaded(plant_parameters(machine), machine.manipulator, Load(mass))
        q = pose_at((0.75 * far, 0.5, float(rng.uniform(-1.0, 1.0))), machine)
        rest, suite = equilibrium(q, plant), sensor_suite(machine)
        _, seen = measure(rest, at_rest(rest, plant, suite), plant, PERIOD, suite)
        q, pressures = seen.joints.position, (seen.pressures[5], seen.pressures[7])
        weighing = weighed(UNKNOWN, q, ZERO, pressures, weighing_parameters(machine), PERIOD)
        assert weighing.mass == pytest.approx(mass, abs=1.0)  # links that bend stand 3 mrad lower


def settled(before, q, force, c, rates=ZERO):
    """The weighing after two seconds under a force of the boom's cylinder [N]."""
    for _ in range(round(4.0 * SETTLED / PERIOD)):
        before = weighed(before, q, rates, (force / c.areas[0], 0.0), c, PERIOD)
    return before


def test_what_friction_may_hold_changes_no_mass_at_rest_and_what_is_more_does():
    c, q = weighing_parameters(REAL)._replace(pressure_share=0.0), pose_at((6.0, 0.0, 1.0), REAL)
    per_newton = lever_arm(q[1], c.linkage) / (c.gravity * (6.0 - c.links.base_offset))
    rest = settled(UNKNOWN, q, 2e5, c)
    for side in (-1.0, 1.0):
        assert settled(rest, q, 2e5 + 0.99 * side * c.breakaway, c).mass == pytest.approx(rest.mass, abs=0.1)
        more = settled(rest, q, 2e5 + 3.0 * side * c.breakaway, c)
        expected = 2.0 * side * c.breakaway * per_newton
        assert more.mass - rest.mass == pytest.approx(expected, rel=0.05)


def test_a_cylinder_that_slides_has_its_friction_against_the_motion():
    c, q = weighing_parameters(REAL)._replace(pressure_share=0.0, damping=0.0), pose_at((6.0, 0.0, 1.0), REAL)
    arm = lever_arm(q[1], c.linkage)
    rest = settled(UNKNOWN, q, 2e5, c)
    for side in (-1.0, 1.0):
        moving = settled(rest, q, 2e5 + side * c.friction, c, (0.0, side * 0.02 / arm, 0.0))
        assert moving.mass == pytest.approx(rest.mass, abs=3.0)  # of 21 kg that the friction is


def test_without_pressures_the_mass_is_kept_for_a_while_and_is_not_known_then():
    c, q = weighing_parameters(REAL), pose_at((6.0, 0.0, 1.0), REAL)
    weighing, known = settled(UNKNOWN, q, 3e5, c), 0
    mass = weighing.mass
    for _ in range(round(2.0 * LOST / PERIOD)):
        weighing = weighed(weighing, q, ZERO, UNREAD, c, PERIOD)
        assert weighing.mass == mass or math.isnan(weighing.mass)
        known += not math.isnan(weighing.mass)
    assert known * PERIOD == pytest.approx(LOST, abs=2.0 * PERIOD)


def test_the_mass_that_limits_rises_at_once_falls_slowly_and_goes_soon_with_a_load_that_is_dropped():
    c, q = weighing_parameters(REAL), pose_at((6.0, 0.0, 1.0), REAL)
    weighing, counted = settled(UNKNOWN, q, 3e5, c), []
    for k in range(round(4.0 / PERIOD)):
        force = 3e5 + 3e4 * math.sin(2.0 * math.pi * k * PERIOD)
        weighing = weighed(weighing, q, ZERO, (force / c.areas[0], 0.0), c, PERIOD)
        counted.append(weighing.counted - weighing.mass)
    assert min(counted) == 0.0
    assert max(counted) > 15.0
    heavy = weighing.counted
    for k in range(round(2.5 / PERIOD)):
        weighing = weighed(weighing, q, ZERO, (5e4 / c.areas[0], 0.0), c, PERIOD)
        assert weighing.counted >= weighing.mass
        if k == 20:
            assert weighing.counted > 0.97 * heavy
    assert weighing.counted < 0.9 * heavy


def test_near_the_pivot_nothing_is_weighed_and_what_was_known_stays():
    c = weighing_parameters(REAL)
    weighing = settled(UNKNOWN, pose_at((6.0, 0.0, 1.0), REAL), 3e5, c)
    upright = 0.0, 1.2, -3.0
    assert settled(weighing, upright, 0.0, c).mass == weighing.mass


def test_a_stop_forgets_all_motion_and_no_load():
    known = Weighing(mass=430.0, torque=1e4, age=0.0)
    assert stopped(State((0.1, 0.2, 0.3), True, weighing=known)) == REST._replace(weighing=known)
