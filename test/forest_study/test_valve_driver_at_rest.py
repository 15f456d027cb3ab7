"""Claims about the driver within the loop: at rest nothing chatters, and nothing cycles."""

import dataclasses

import numpy as np
import pytest

from forest_control import controller, valve_driver
from forest_control.levers import REST, levers_for_tip_velocity
from forest_control.schemes import Scheme
from forest_description.machine import load_machine
from forest_study import loop_kernel
from forest_study.closed_loop import PERIOD, Operator
from forest_study.loop_kernel import by_heart as run
from forest_study.track import noisy

C180 = load_machine()
START = (0.2, 0.5, -1.6)
PUSHED, RELEASED, END = 0.5, 1.5, 6.0  # [s]


def session(scheme, overlap=1.0, pushed=True, seed=0):
    """A push that stops suddenly; the driver believes an overlap of so many times the true one."""
    valve = dataclasses.replace(C180.valve, deadband_voltage=overlap * C180.valve.deadband_voltage)
    push = levers_for_tip_velocity((0.1, 0.2, 0.1), 0.5)

    def operator(time):
        return Operator(push if pushed and PUSHED < time < RELEASED else REST)

    settings, driver = controller.Settings(scheme=scheme), valve_driver.Settings()
    model = dataclasses.replace(C180, valve=valve)
    return run(C180, operator, END if pushed else 3.0, START, settings, driver, model, noisy(C180, seed))


def variation(moved, start):
    """Total variation of the voltages [V/s] from a time on."""
    volts = moved.voltages[round(start / PERIOD) :]
    return np.abs(np.diff(volts, axis=0)).sum(axis=0) / (PERIOD * len(volts))


@pytest.mark.parametrize("scheme", [Scheme.COORDINATED, Scheme.JACOBIAN_VELOCITY, Scheme.JOINT])
@pytest.mark.parametrize("seed", [0, 1])
def test_at_rest_the_voltage_does_not_chatter_under_sensor_noise(scheme, seed):
    assert variation(session(scheme, pushed=False, seed=seed), 0.3).max() < 0.5


@pytest.mark.parametrize("scheme", [Scheme.COORDINATED, Scheme.JACOBIAN_POSITION])
@pytest.mark.parametrize("seed", [0, 1])
def test_an_overlap_over_compensated_by_a_tenth_makes_no_limit_cycle(scheme, seed):
    moved = session(scheme, 1.1, seed=seed)
    swing = moved.angles[round(4.0 / PERIOD) :, 0]
    assert np.ptp(swing) < 1e-3  # 6 mm of the tip
    assert variation(moved, 4.0)[0] < 0.5


@pytest.mark.parametrize("overlap", [1.0, 1.1])
def test_after_any_push_the_tip_comes_to_rest(overlap):
    valve = dataclasses.replace(C180.valve, deadband_voltage=overlap * C180.valve.deadband_voltage)
    model, rng = dataclasses.replace(C180, valve=valve), np.random.default_rng(5)
    time = PERIOD * np.arange(round(8.0 / PERIOD))
    for seed in range(8):
        push = rng.normal(size=3)
        push *= rng.uniform(0.05, 0.5) / np.linalg.norm(push)
        levers = np.zeros((len(time), 4))
        levers[(time > PUSHED) & (time < RELEASED), :3] = levers_for_tip_velocity(tuple(push), 0.5)
        levers[:, 3] = 1.0
        start = (0.2, 0.3 + 0.1 * seed, -1.2 - 0.1 * seed)
        settings = controller.Settings(), valve_driver.Settings()
        moved = loop_kernel.run(C180, levers, start, *settings, model, noisy(C180, seed))
        assert np.ptp(moved.tip[round(4.0 / PERIOD) :], axis=0).max() < 8e-3
        assert variation(moved, 4.0).max() < (0.5 if overlap == 1.0 else 3.0)
