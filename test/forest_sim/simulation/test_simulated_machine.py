"""The sway of a hanging head, as the simulator tells it."""

import math

import pytest

from forest_description.machine import load_machine
from forest_sim.sensors.sensor_suite import EXACT_SUITE
from forest_sim.simulation.simulated_machine import SimulatedMachine

START, PERIOD = (0.1, 0.6, -1.3), 0.005


def test_a_head_hangs_plumb_at_rest_and_its_joints_move_at_the_rates_that_are_told():
    machine = SimulatedMachine(load_machine("loader"), START, EXACT_SUITE, PERIOD, warms=False)
    in_plane, out_of_plane, *rates, _, _ = machine.head_joints
    assert (in_plane, out_of_plane) == pytest.approx((-START[1] - START[2], 0.0), abs=1e-3)
    assert rates == pytest.approx([0.0, 0.0], abs=1e-6)
    told = []
    for _ in range(120):
        machine.step((3.0, 3.0, 0.0))
        told.append(machine.head_joints)
    assert max(abs(joints[1]) for joints in told) > 0.01
    for before, now, after in zip(told, told[1:], told[2:], strict=False):
        for joint in range(2):
            slope = (after[joint] - before[joint]) / (2.0 * PERIOD)
            assert now[2 + joint] == pytest.approx(slope, abs=0.02)
        assert all(map(math.isnan, now[4:]))
