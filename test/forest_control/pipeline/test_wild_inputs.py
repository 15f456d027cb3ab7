"""Claims about the cores under any finite input: what leaves them is finite and within the rating."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import ANY, near

from forest_control.config import controller_settings
from forest_control.config.controller_settings import Settings
from forest_control.operator.levers import Levers
from forest_control.pipeline import control_state, controller
from forest_control.pipeline.control_state import Inputs
from forest_control.safety.state_checks import implausible
from forest_control.servo.schemes import Scheme
from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_control.valve.load_estimate import Pressures
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
RATED = 10.0  # [V]


@pytest.mark.parametrize("scheme", list(Scheme))
def test_the_controller_commands_finite_voltages_within_the_rating(scheme):
    p = controller_settings.parameters(MACHINE, Settings(scheme=scheme))
    rng, state = np.random.default_rng(int(scheme)), control_state.REST
    low, high = np.array(p.velocity_limits.lower) - 0.1, np.array(p.velocity_limits.upper) + 0.1
    for _ in range(1500):
        angles, rates = tuple(rng.uniform(low, high).tolist()), tuple(rng.uniform(-5.0, 5.0, 3).tolist())
        assert implausible(angles, rates, p) == ""
        levers = Levers(*rng.choice([-1.0, 0.0, 1.0, 0.3], 3).tolist())
        inputs = Inputs(angles, rates, levers, bool(rng.random() < 0.9))
        state, output = controller.step(state, inputs, p, float(rng.uniform(0.0025, 0.05)))
        assert all(abs(volts) <= RATED for volts in output.command)  # false for NaN as well
        assert all(map(math.isfinite, output.tip_velocity_reference))
        assert 0.0 <= output.scaling.factor <= 1.0


DRIVER = valve_driver_parameters.parameters(
    MACHINE, valve_driver_parameters.Settings(adapt=True, dither_frequency=20.0)
)
DRIVER = DRIVER._replace(axes=tuple(axis._replace(dither=0.5) for axis in DRIVER.axes))
PERIODS = st.sampled_from((0.0, 0.0025, 0.005, 0.05))


@given(
    st.lists(
        st.tuples(near(-12.0, 12.0), near(0.0, 3e7), near(0.0, 3e7), ANY, near(-2.0, 2.0), PERIODS),
        max_size=6,
    )
)
def test_whatever_is_commanded_and_measured_no_valve_gets_more_than_its_rating(steps):
    """Neither NaN nor the infinite; what is commanded so gets nothing."""
    state = valve_driver.REST
    for command, port_1, port_2, supply, positions, dt in steps:
        motion = load_estimate.Motion(positions, port_1, port_2)
        pressures = Pressures(port_1, port_2, supply)
        state, volts = valve_driver.step(state, command, pressures, motion, DRIVER, dt)
        assert all(abs(v) <= RATED for v in (*volts, *state.voltages))  # false for NaN as well
        assert all(v == 0.0 for v, c in zip(volts, command, strict=True) if not math.isfinite(c))


@pytest.mark.parametrize("dt", [0.0, 1e-18, 1e-6])
def test_two_commands_for_one_moment_of_the_machine_open_no_valve_wide(dt):
    """A first command after a rest may come with the pressures that another one was answered by."""
    p = valve_driver_parameters.parameters(MACHINE, valve_driver_parameters.Settings())
    command = (0.1, 0.1, -0.1)
    _, usual = valve_driver.step(
        valve_driver.REST, command, load_estimate.UNSEEN, load_estimate.STILL, p, 0.0025
    )
    _, volts = valve_driver.step(valve_driver.REST, command, load_estimate.UNSEEN, load_estimate.STILL, p, dt)
    assert all(abs(v) <= abs(u) * (1.0 + 1e-9) < 0.7 * RATED for v, u in zip(volts, usual, strict=True))
