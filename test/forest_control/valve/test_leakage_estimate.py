"""Claims about learning a motor's leakage: what sinks behind a shut valve tells it, and nothing else does."""

import numpy as np
import pytest

from forest_control.valve import leakage_estimate, valve_driver, valve_driver_parameters
from forest_control.valve.leakage_estimate import LeakageEstimate
from forest_control.valve.valve_adaptation import NO_ESTIMATE, updated_estimate
from forest_control.valve.valve_driver import Motion, Pressures
from forest_control.valve.valve_driver_parameters import Settings
from forest_control.valve.valve_flow import AxisMeasurement
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
P = valve_driver_parameters.parameters(MACHINE, Settings())
FLOW, LAW, SUPPLY, PERIOD = P.flows[0], P.axes[0].valve, MACHINE.pump.supply_pressure, 0.005


def sunk(factor, spool=0.0, load=6e6, duration=2.0, noise=FLOW.position_noise, seed=0):
    """Learn from a swing on a slope that sinks through its motor: the file's leakage times a factor."""
    rng, learner, position = np.random.default_rng(seed), NO_ESTIMATE, 0.0
    one, two = 2e6, 2e6 + load
    leaks = FLOW.internal_leakage * (two - one) + 0.5 * FLOW.external_leakage * (two - one)
    for _ in range(round(duration / PERIOD)):
        position += PERIOD * factor * leaks / FLOW.displacement_1
        seen = AxisMeasurement(position + noise * rng.standard_normal(), one, two, one, two, SUPPLY, spool)
        learner = updated_estimate(learner, seen, LAW, FLOW, P.adaptation, PERIOD)
    return learner


@pytest.mark.parametrize("factor", [0.3, 1.0, 3.0])
def test_a_shut_swing_that_sinks_tells_its_leakage(factor):
    told = [sunk(factor, seed=seed).leakage for seed in range(8)]
    off = [(one.factor - factor) / (leakage_estimate.SPREAD * one.variance**0.5) for one in told]
    assert max(one.variance for one in told) < 0.1
    assert np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.mean([one.factor for one in told]) == pytest.approx(factor, abs=0.15)


def test_without_a_load_or_behind_a_valve_that_may_be_open_no_leakage_is_learnt():
    level = sunk(3.0, load=0.0, noise=0.0).leakage
    assert level.factor == pytest.approx(1.0, abs=1e-6)
    assert sunk(3.0, spool=0.95).leakage == LeakageEstimate()


def test_a_leak_that_is_learnt_is_no_flow_through_the_valve():
    """Thrice the leakage would feign 0.1 V of opening, and teach an overlap that is too narrow."""
    learner = sunk(3.0, duration=4.0)
    seen, position = learner, learner.last.position
    one, two = 2e6, 8e6
    leaks = (FLOW.internal_leakage + 0.5 * FLOW.external_leakage) * (two - one)
    for _ in range(200):
        position += PERIOD * 3.0 * leaks / FLOW.displacement_1
        sample = AxisMeasurement(position, one, two, one, two, SUPPLY, 1.01)
        seen = updated_estimate(seen, sample, LAW, FLOW, P.adaptation, PERIOD)
    assert abs(seen.forward.deadband) < 0.02


def test_the_driver_feeds_what_it_has_learnt_to_leak():
    def fed(factor):
        state = valve_driver.REST._replace(
            estimates=(NO_ESTIMATE._replace(leakage=LeakageEstimate(factor, 0.01)), NO_ESTIMATE, NO_ESTIMATE)
        )
        pressures = Pressures((8e6, 5e6, 5e6), (2e6, 5e6, 5e6), SUPPLY)
        motion = Motion((0.0, 2.0, 2.0), (8e6, 5e6, 5e6), (2e6, 5e6, 5e6))
        for _ in range(40):
            state, _ = valve_driver.step(state, (1e-7, 0.0, 0.0), pressures, motion, P, PERIOD)
        return state.voltages[0]

    edge = LAW.forward.deadband_voltage
    assert fed(2.0) - edge == pytest.approx(2.0 * (fed(1.0) - edge), rel=0.1)
