"""The load is weighed by the boom's pressures: over poses, in slow motion, with sensors as they are."""

import dataclasses

import numpy as np
import pytest
from compiled_rows import states_of

from forest_control.config import controller_settings
from forest_control.limits.load_weighing import (
    UNKNOWN,
    weighed,
    weighing_parameters,
)
from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
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
