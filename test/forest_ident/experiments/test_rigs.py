"""A rig holds the valve or the hose of a crane, and nothing of its swing."""

import dataclasses

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_ident.driving.simulated_experiment import run
from forest_ident.experiments import experiment_plan
from forest_ident.experiments import rigs as rig
from forest_sim.sensors.sensor_suite import sensor_suite

ON_THE_CRANE = ("chambers", "friction", "backlash", "holding_1", "holding_2", "elasticity")


@pytest.mark.parametrize("name", ["c180", "c180_hoses", "loader", "forwarder"])
def test_what_only_the_crane_s_actuators_have_stays_on_the_crane(name):
    machine = load_machine(name)
    for bench in (rig.valve_bench(machine), rig.hose_bench(machine)):
        for axis in AXES:
            left = [part for part in ON_THE_CRANE if getattr(getattr(bench, axis), part, None) is not None]
            assert not left, axis


def test_nothing_of_an_idle_cylinder_is_read_on_a_rig():
    machine = load_machine("c180")
    bare = experiment_plan.plan("valve", machine, longest=4.0)
    idle = {axis: getattr(machine, axis) for axis in ("boom", "stick")}
    whole = bare._replace(machine=dataclasses.replace(bare.machine, **idle))
    suite = sensor_suite(bare.machine, noise=False)
    told, kept = run(bare, suite), run(whole, suite)
    for channel in ("swing_pressure_1_valve", "swing_pressure_2_valve", "supply_pressure", "swing_flow"):
        np.testing.assert_allclose(told.column(channel), kept.column(channel), rtol=1e-6, atol=1e-9)
