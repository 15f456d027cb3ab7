"""Cranes that are only off their file, thrown about and let go, are not said to go by themselves."""

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.operator.levers import Levers
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_study.closed_loop.closed_loop import ClosedLoop, Operator
from forest_study.closed_loop.model_mismatch import Ranges, applied, draw


@pytest.mark.parametrize("seed", range(4))
def test_a_crane_that_is_thrown_about_and_let_go_is_no_runaway(seed):
    """Plants off their file in everything that is drawn, on a tilted platform."""
    machine = load_machine(("c180_hoses", "c180")[seed % 2])
    plant = applied(machine, draw(seed, Ranges(tilt=10.0, stiffness=0.2)))
    control = controller_settings.parameters(machine, controller_settings.Settings(tip_speed=1.0))
    drive = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
    suite = sensor_suite(machine, noise=True, seed=seed)
    loop = ClosedLoop(plant, control, drive, pose_at((5.5, 0.0, 1.0), machine), suite, fast=True)
    rng, levers = np.random.default_rng(seed), Levers(0.0, 0.0, 0.0)
    for k in range(1600):
        if k % 80 == 60:
            levers = Levers(*rng.uniform(-1.0, 1.0, 3).tolist()) if k % 160 == 60 else Levers(0.0, 0.0, 0.0)
        loop.period(Operator(levers, k % 160 < 130))
        assert "goes by itself" not in loop.controller.guard.causes["machine"], k
