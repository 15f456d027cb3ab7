"""Claims about the spool that the driver knows: the simulated one; its hysteresis is taken out by dither."""

import dataclasses
import math

import numpy as np
import pytest

from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.load_estimate import STILL, UNSEEN
from forest_control.valve.spool_model import SpoolLaw, after
from forest_control.valve.valve_driver import REST
from forest_description.machine import load_machine
from forest_sim.hydraulics.spool_dynamics import Spool, SpoolLag, spool_after

PERIOD = 0.005
REAL = load_machine("c180")
NEVER = math.inf


@pytest.mark.parametrize("lag", [0.0, 0.0133])
@pytest.mark.parametrize("slew", [NEVER, 250.0, 40.0])
def test_the_drivers_spool_is_the_simulated_one(lag, slew):
    rng = np.random.default_rng(3)
    simulated = SpoolLag(1.0 / lag if lag > 0.0 else math.inf, 0.0, 0.0, slew)
    law, spool, y = SpoolLaw(lag, slew), Spool(0.0, 0.0), 0.0
    for voltage, dt in zip(rng.normal(0.0, 3.0, 400), rng.uniform(0.0, 0.02, 400), strict=True):
        spool = spool_after(spool, voltage, dt, simulated)
        y = after(y, voltage, law, dt)
        assert y == pytest.approx(spool.position, abs=1e-12)


def spools(hysteresis, dither):
    """Where the simulated spool is in motion [V], and where the driver thinks it is, up and down."""
    settings = valve_driver_parameters.Settings(dither_amplitude=dither)
    p = valve_driver_parameters.parameters(REAL, settings)
    lag = SpoolLag(1.0 / p.axes[1].spool.lag, 0.0, hysteresis, p.axes[1].spool.slew)
    state, spool, seen = REST, Spool(0.0, 0.0), []
    for k in range(400):
        command = (0.0, 3.0 + math.sin(0.02 * k), 0.0)
        state, volts = valve_driver.step(state, command, UNSEEN, STILL, p, PERIOD)
        spool = spool_after(spool, volts[1], PERIOD, lag)
        state_ahead = after(state.spools[1], state.voltages[1], p.axes[1].spool, PERIOD)
        seen.append((spool.position, state_ahead))
    return np.array(seen[40:])  # across the overlap


@pytest.mark.parametrize("hysteresis", [0.0, 0.1, 0.3, 0.4])
def test_dither_takes_out_every_hysteresis_up_to_the_files(hysteresis):
    true, known = spools(hysteresis, -1.0).T
    turns = (true - known).reshape(-1, 4)  # 50 Hz at 200 Hz
    assert np.abs(turns.mean(axis=1)).max() < 0.03
    assert np.ptp(turns, axis=1).max() < 0.15


def test_without_dither_the_spool_is_behind_by_half_the_hysteresis():
    true, known = spools(0.4, 0.0).T
    assert np.abs(true - known).max() == pytest.approx(0.2, abs=0.01)


def test_a_spool_that_flow_forces_push_is_dithered_as_others():
    p = valve_driver_parameters.parameters(load_machine("forwarder"), valve_driver_parameters.Settings())
    assert [axis.dither for axis in p.axes] == [0.5 * load_machine("forwarder").valve.hysteresis] * 3


def test_the_amplitude_is_half_the_hysteresis_of_each_axis_own_valve():
    coarse = dataclasses.replace(REAL.valve, hysteresis=0.6)
    machine = dataclasses.replace(REAL, stick=dataclasses.replace(REAL.stick, valve=coarse))
    p = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
    assert [axis.dither for axis in p.axes] == pytest.approx([0.2, 0.2, 0.3])


@pytest.mark.parametrize("off", [{"beyond_valve": False}, {"compensate": False}])
def test_without_what_lies_beyond_the_valve_the_driver_knows_no_hysteresis(off):
    p = valve_driver_parameters.parameters(REAL, valve_driver_parameters.Settings(**off))
    assert [axis.dither for axis in p.axes] == [0.0] * 3
