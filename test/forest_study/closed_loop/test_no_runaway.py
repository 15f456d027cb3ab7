"""Cranes that are only off their file, thrown about and let go, are not said to go by themselves."""

import numpy as np
import pytest
from compiled_rows import states_of

from forest_control.config import controller_settings
from forest_control.safety import runaway
from forest_control.safety.runaway import Runaway
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.model_mismatch import Ranges, applied, draw

WATCH = [f"control.permission.checks.runaway.{name}[{i}]" for name in Runaway._fields for i in range(3)]


@pytest.mark.parametrize("seed", range(4))
def test_a_crane_that_is_thrown_about_and_let_go_is_no_runaway(seed):
    """Plants off their file in everything that is drawn, on a tilted platform."""
    machine = load_machine(("c180_hoses", "c180")[seed % 2])
    plant = applied(machine, draw(seed, Ranges(tilt=10.0, stiffness=0.2)))
    settings = controller_settings.Settings(tip_speed=1.0), valve_driver_parameters.Settings()
    suite = sensor_suite(machine, noise=True, seed=seed)
    rng, levers = np.random.default_rng(seed), np.zeros((1600, 4))
    for k in range(60, 1600, 160):
        levers[k : k + 80, :3] = rng.uniform(-1.0, 1.0, 3)
    levers[:, 3] = np.arange(1600) % 160 < 130
    given = machine, levers, pose_at((5.5, 0.0, 1.0), machine), *settings
    session = compiled_loop.prepared(*given, suite=suite, plant=plant)
    for row, found in enumerate(states_of(session, *WATCH)):
        watch = Runaway(tuple(found[:3]), tuple(found[3:6]), tuple(found[6:]))
        assert runaway.objection(watch) == "", row
