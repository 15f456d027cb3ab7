"""A lever that is thrown from rest: the tip keeps an operator's bound on its speed."""

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_study.closed_loop import compiled_loop

SPEED = 0.5  # [m/s] of the wish
BEGUN, PERIODS = 20, 260


def fastest(name: str, seed: int) -> float:
    """Return the greatest speed of the tip [m/s]."""
    machine, rng = load_machine(name), np.random.default_rng(seed)
    low, high = np.array(joint_limits(machine)).T
    levers, margin = np.zeros((PERIODS, 4)), 0.1 * (high - low)
    levers[:, 3] = 1.0
    wish = rng.normal(size=3)
    wish *= SPEED / np.linalg.norm(wish)
    levers[BEGUN:, :3] = levers_for_tip_velocity(tuple(wish.tolist()), SPEED)
    start = tuple(rng.uniform(low + margin, high - margin).tolist())
    settings = controller_settings.Settings(tip_speed=SPEED), valve_driver_parameters.Settings()
    suite = sensor_suite(machine, noise=True, seed=seed)
    moved = compiled_loop.run(machine, levers, start, *settings, suite=suite)
    return float(np.linalg.norm(np.gradient(moved.tip, PERIOD, axis=0), axis=1).max())


# The forwarder's ports are empty and its counterbalance valves shut: it starts late, and catches up.
@pytest.mark.parametrize(
    ("name", "most"), [("c180", 1.2 * SPEED + 0.1), ("loader", 1.2 * SPEED + 0.1), ("forwarder", 1.0)]
)
def test_a_lever_that_is_thrown_throws_no_tip(name: str, most: float):
    assert max(fastest(name, seed) for seed in range(40)) < most
