"""Claims about the spool: its steps are the exact solutions of its law, and a stuck one stays."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.command_history import held
from forest_sim.hydraulics.spool_dynamics import CENTRED, STUCK, Spool, SpoolLag, spool_after, spool_lag
from forest_sim.solver.integrator import spools_after

C180 = load_machine("c180_hoses")
W = 2.0 * math.pi * 12.0
SECOND = {name: SpoolLag(W, zeta) for name, zeta in {"under": 0.4, "critical": 1.0, "over": 2.5}.items()}
LAGS = {"first": SpoolLag(W, 0.0), **SECOND}
each_lag = pytest.mark.parametrize("lag", LAGS.values(), ids=LAGS)


def integrated(spool, voltage, time, lag):
    """The law itself, by scipy."""

    def slope(_, y):
        if lag.damping == 0.0:
            return [lag.frequency * (voltage - y[0]), 0.0]
        return [y[1], -2.0 * lag.damping * lag.frequency * y[1] + lag.frequency**2 * (voltage - y[0])]

    return solve_ivp(slope, (0.0, time), spool[:2], method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]


@each_lag
@pytest.mark.parametrize("time", [1e-4, 5e-3, 0.08])
def test_a_step_is_the_solution_of_the_law(lag, time):
    begin = Spool(2.0, -300.0 if lag.damping else 0.0)
    after = spool_after(begin, -4.0, time, lag)
    position, rate = integrated(begin, -4.0, time, lag)
    assert after.position == pytest.approx(position, rel=1e-8, abs=1e-8)
    assert after.rate == pytest.approx(rate, rel=1e-7, abs=1e-6)


@each_lag
def test_two_half_steps_are_one_whole(lag):
    begin, rng = Spool(1.0, 200.0 if lag.damping else 0.0), np.random.default_rng(1)
    for voltage, time in zip(rng.uniform(-10, 10, 50), 10.0 ** rng.uniform(-5, 0, 50), strict=True):
        whole = spool_after(begin, voltage, time, lag)
        halves = spool_after(spool_after(begin, voltage, time / 2, lag), voltage, time / 2, lag)
        np.testing.assert_allclose(halves, whole, rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("zeta", [1.0 - 1e-9, 1.0 + 1e-9, 1.0 - 1e-5, 1.0 + 1e-5])
def test_both_dampings_meet_at_the_critical_one(zeta):
    begin = Spool(2.0, -300.0)
    for time in (1e-4, 1e-2, 0.1):
        near, at = (
            spool_after(begin, 5.0, time, SpoolLag(W, zeta)),
            spool_after(begin, 5.0, time, LAGS["critical"]),
        )
        np.testing.assert_allclose(near, at, rtol=1e-4, atol=1e-4)


def test_a_well_damped_spool_survives_a_long_step():
    far = spool_after(Spool(-3.0, 0.0), 7.0, 100.0, SpoolLag(2.0 * math.pi * 500.0, 5.0))
    assert far[:2] == pytest.approx((7.0, 0.0), abs=1e-9)


def test_an_underdamped_spool_overshoots_and_others_do_not():
    peak = {
        name: max(spool_after(CENTRED, 1.0, t, lag).position for t in np.linspace(0.0, 0.2, 400))
        for name, lag in LAGS.items()
    }
    assert peak["under"] == pytest.approx(1.0 + math.exp(-math.pi * 0.4 / math.sqrt(1 - 0.16)), abs=1e-3)
    assert max(peak["first"], peak["critical"], peak["over"]) <= 1.0


def test_a_spool_without_lag_is_there_at_once():
    assert spool_after(Spool(3.0, 0.0), -2.0, 1e-9, SpoolLag(math.inf, 0.0))[:2] == (-2.0, 0.0)


def test_a_stuck_spool_stays_whatever_the_voltage():
    spool = Spool(3.7, 0.0)
    for voltage in (-10.0, 0.0, 0.1, 10.0):
        assert spool_after(spool, voltage, 1e-3, STUCK) == spool


def test_the_lag_is_the_valves():
    valve = C180.valve
    assert spool_lag(dataclasses.replace(valve, spool_bandwidth=None)) == SpoolLag(math.inf, 0.0)
    assert spool_lag(dataclasses.replace(valve, spool_bandwidth=10.0)) == SpoolLag(20.0 * math.pi, 0.0)
    second = dataclasses.replace(valve, spool_bandwidth=10.0, spool_damping=0.7)
    assert spool_lag(second) == SpoolLag(20.0 * math.pi, 0.7)
    late = dataclasses.replace(valve, hysteresis=0.3, dead_time=0.006, spool_slew_limit=90.0)
    assert spool_lag(late)[2:] == (0.3, 90.0, 0.006, 0.0)
    pushed = spool_lag(dataclasses.replace(valve, centring_force=100.0), 800.0)
    assert pushed.jet == pytest.approx(40.0 * math.cos(math.radians(69.0)) / 100.0)


def test_one_stuck_spool_of_three_leaves_the_others_free():
    p = plant_parameters(C180)
    stuck = p._replace(valves=(p.valves[0], p.valves[1]._replace(lag=STUCK), p.valves[2]))
    spools = (CENTRED, Spool(4.0, 0.0), CENTRED)
    after = spools_after(spools, held((5.0, -5.0, 5.0)), 10.0, stuck)
    assert [spool.position for spool in after] == pytest.approx([5.0, 4.0, 5.0])


def test_spools_end_at_the_rated_voltage_in_both_directions():
    p = plant_parameters(C180)
    ends = spools_after((CENTRED,) * 3, held((80.0, -80.0, 9.0)), 10.0, p)
    assert [spool.position for spool in ends] == pytest.approx([10.0, -10.0, 9.0])
