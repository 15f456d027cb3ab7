"""Claims about what stands between a voltage and its spool: dead time, play and slew limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.command_history import (
    AGED,
    NO_COMMANDS,
    SIZE,
    after_dead_time,
    held,
    held_commands,
)
from forest_sim.hydraulics.spool_dynamics import CENTRED, Spool, SpoolLag, behind_play, spool_after
from forest_sim.solver.compiled_plant import FlatPlant, compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import advance, spools_after
from forest_sim.solver.state_recording import STATE, record, store

REAL = load_machine("c180")
POSE = (0.1, 0.4, -1.4)
AT_ONCE = SpoolLag(math.inf, 0.0)
W, S, B = 2.0 * math.pi * 12.0, 250.0, 0.4
LIMITED = {
    "at once": SpoolLag(math.inf, 0.0, slew=S),
    "first": SpoolLag(W, 0.0, slew=S),
    **{f"second, {zeta}": SpoolLag(W, zeta, slew=S) for zeta in (0.3, 0.75, 1.0, 1.8)},
}
each_limit = pytest.mark.parametrize("lag", LIMITED.values(), ids=LIMITED)


def test_held_voltages_act_from_the_beginning_of_a_step_and_none_is_a_voltage_of_zero():
    assert held((1.0, -2.0, 3.0)) == ((1.0, 0.0, 1.0), (-2.0, 0.0, -2.0), (3.0, 0.0, 3.0))
    assert held_commands((0.0, 0.0, 0.0)) == NO_COMMANDS


def test_voltages_that_stay_are_no_change():
    given, dead_times = (1.0, 2.0, 3.0), (0.01, 0.01, 0.01)
    once = after_dead_time(NO_COMMANDS, given, 1e-3, dead_times).history
    again = after_dead_time(once, given, 1e-3, dead_times).history
    assert (again.swing, again.boom, again.stick) == (once.swing, once.boom, once.stick)


def test_the_loop_is_as_wide_as_the_play_at_every_height():
    lag, spool, path = AT_ONCE._replace(play=B), CENTRED, []
    sweep = 8.0 * np.sin(np.linspace(0.0, 4.0 * np.pi, 20001))
    for voltage in sweep:
        spool = spool_after(spool, voltage, 1e-3, lag)
        path.append(spool.position)
    up, down = np.array(path[7500:12500]), np.array(path[12500:17500])
    for height in (-6.0, -1.0, 0.0, 0.3, 5.0):
        rising = np.interp(height, up, sweep[7500:12500])
        falling = np.interp(height, down[::-1], sweep[12500:17500][::-1])
        assert rising - falling == pytest.approx(B, abs=1e-3)


def test_play_does_not_move_within_its_width_and_is_all_there_is_at_the_turn():
    target = 0.0
    for voltage, expected in ((3.0, 2.8), (2.7, 2.8), (2.61, 2.8), (2.5, 2.7), (2.5, 2.7), (-1.0, -0.8)):
        target = behind_play(target, voltage, B)
        assert target == pytest.approx(expected, abs=1e-12)


def test_a_lagging_spool_goes_for_what_is_behind_its_play_exactly():
    lag = SpoolLag(W, 0.0, play=B)
    for time in (1e-4, 1e-3, 0.02):
        after = spool_after(Spool(1.0, 0.0, 1.0), 5.0, time, lag)
        assert after.position == pytest.approx(4.8 - 3.8 * math.exp(-W * time), rel=1e-13)
        assert after.target == pytest.approx(4.8)


def test_a_slew_limit_ramps_and_then_lags_in_closed_form():
    lag, jump = LIMITED["first"], 9.0
    ramp = (jump - S / W) / S
    for time in (0.25 * ramp, ramp, ramp + 0.01, ramp + 0.1):
        expected = S * time if time <= ramp else jump - S / W * math.exp(-W * (time - ramp))
        assert spool_after(CENTRED, jump, time, lag).position == pytest.approx(expected, rel=1e-12)
    for way in (1.0, -1.0):
        at_once = LIMITED["at once"]
        assert spool_after(CENTRED, way * jump, 0.02, at_once).position == pytest.approx(way * 5.0)
        assert spool_after(CENTRED, way * jump, jump / S, at_once).position == pytest.approx(way * jump)


def integrated(begin, target, times, lag):
    """The law with the limit of its rate, by scipy in short steps."""

    def slope(_, y):
        if lag.damping == 0.0:
            return [np.clip(lag.frequency * (target - y[0]), -S, S), 0.0]
        acceleration = lag.frequency**2 * (target - y[0]) - 2.0 * lag.damping * lag.frequency * y[1]
        return [y[1], 0.0 if abs(y[1]) >= S and acceleration * y[1] > 0.0 else acceleration]

    found, y, now = [], [begin.position, begin.rate], 0.0
    for time in times:
        y = solve_ivp(slope, (now, time), y, rtol=1e-8, atol=1e-8, max_step=2e-4).y[:, -1]
        y[1], now = np.clip(y[1], -S, S), time
        found.append(y[0])
    return found


@pytest.mark.parametrize("lag", list(LIMITED.values())[1:], ids=list(LIMITED)[1:])
def test_a_limited_step_is_the_solution_of_its_law(lag):
    times = (2e-3, 8e-3, 0.02, 0.035, 0.06)
    for begin, target in ((CENTRED, 9.0), (Spool(4.0, 200.0 if lag.damping else 0.0), -7.0)):
        ours = [spool_after(begin, target, time, lag).position for time in times]
        np.testing.assert_allclose(ours, integrated(begin, target, times, lag), atol=2e-3)


@each_limit
def test_parts_of_a_step_are_the_whole_and_no_rate_is_above_the_limit(lag):
    rng, lag = np.random.default_rng(5), lag._replace(play=B)
    spool, middle = CENTRED, CENTRED
    for target, time in zip(rng.uniform(-10, 10, 300), 10.0 ** rng.uniform(-4, -1, 300), strict=True):
        before, share = spool, rng.uniform(0.05, 0.95)
        middle = spool_after(spool, target, share * time, lag)
        spool = spool_after(before, target, time, lag)
        parts = spool_after(middle, target, (1.0 - share) * time, lag)
        np.testing.assert_allclose(parts, spool, rtol=1e-9, atol=1e-6)
        assert abs(spool.rate) <= S * (1.0 + 1e-9)
        assert abs(spool.position - before.position) <= S * time * (1.0 + 1e-9)


@pytest.mark.parametrize("step", [1e-3, 5e-4, 2.5e-4, 1e-4])
@pytest.mark.parametrize("dead_times", [(8e-3, 0.0, 3e-3), (11e-3, 2e-3, 1e-3), (20e-3, 20e-3, 7e-3)])
def test_held_voltages_act_a_dead_time_later_to_the_step(step, dead_times):
    rng, hold = np.random.default_rng(3), round(5e-3 / step)
    given = np.repeat(rng.uniform(-10, 10, (40, 3)), hold, axis=0)
    history, acted = NO_COMMANDS, []
    for voltages in given.tolist():
        acting, history = after_dead_time(history, tuple(voltages), step, dead_times)
        acted.append([one.voltage for one in acting])
        assert not any(one.change for one in acting)
    for axis, dead_time in enumerate(dead_times):
        late = round(dead_time / step)
        expected = np.concatenate([np.zeros(late), given[: len(given) - late, axis]])
        assert np.array_equal(np.array(acted)[:, axis], expected)


def test_a_voltage_that_changes_in_every_step_is_late_by_its_dead_time_up_to_eleven_steps():
    given = np.random.default_rng(4).uniform(-10, 10, (200, 3))
    for late in (1, SIZE - 1):
        history, acted = NO_COMMANDS, []
        for voltages in given.tolist():
            acting, history = after_dead_time(history, tuple(voltages), 1e-3, (1e-3 * late,) * 3)
            acted.append([one.voltage for one in acting])
        assert np.array_equal(np.array(acted)[late:], given[:-late])


def test_changes_too_many_to_keep_are_sampled_and_the_last_one_is_never_lost():
    time, dead_time = np.arange(0.0, 0.5, 1e-3), 20e-3
    given = np.where(time < 0.4, 5.0 * np.sin(2.0 * np.pi * 2.0 * time), 3.3)
    history, acted = NO_COMMANDS, []
    for voltage in given:
        acting, history = after_dead_time(history, (float(voltage), 0.0, 0.0), 1e-3, (dead_time,) * 3)
        acted.append(acting[0].voltage)
    expected = np.interp(time - dead_time, time, given, left=0.0)
    period = dead_time / (SIZE - 1) + 1e-3
    smooth = time < 0.4
    assert np.max(np.abs(acted - expected)[smooth]) < 5.0 * 2.0 * np.pi * 2.0 * period
    assert acted[-1] == 3.3
    assert max(history.ages) <= AGED


@pytest.mark.parametrize("step", [1e-3, 2.5e-3, 5e-3])
def test_dead_time_play_slew_and_lag_together_are_their_composition(step):
    """Beside them written apart: a delayed row, the play and the limited lag in steps of 2 us."""
    p, dead_time = plant_parameters(REAL), REAL.valve.dead_time
    given = np.repeat(np.random.default_rng(6).uniform(-9, 9, 12), round(0.025 / step)).tolist()
    history, spools, ours = NO_COMMANDS, (CENTRED,) * 3, []
    for voltage in given:
        acting, history = after_dead_time(history, (0.0, voltage, 0.0), step, (0.0, dead_time, 0.0))
        spools = spools_after(spools, acting, step, p)
        ours.append(spools[1].position)
    position = target = 0.0
    theirs, fine = [], 2e-6
    for k in range(round(len(given) * step / fine)):
        late = k * fine - dead_time
        voltage = given[int(late / step + 1e-6)] if late >= 0.0 else 0.0
        target = min(max(target, voltage - 0.2), voltage + 0.2)
        position += fine * min(max(2.0 * np.pi * 12.0 * (target - position), -250.0), 250.0)
        if (k + 1) % round(step / fine) == 0:
            theirs.append(position)
    np.testing.assert_allclose(ours, theirs, atol=2e-3)


def test_a_stage_before_the_change_does_not_see_it():
    p, dead_time = plant_parameters(REAL), (0.0, 8e-3, 0.0)
    _, history = after_dead_time(NO_COMMANDS, (0.0, 9.0, 0.0), 5e-3, dead_time)
    acting, _ = after_dead_time(history, (0.0, 9.0, 0.0), 5e-3, dead_time)
    assert acting[1] == pytest.approx((0.0, 3e-3, 9.0))
    before, since = (spools_after((CENTRED,) * 3, acting, time, p)[1].position for time in (2.9e-3, 4e-3))
    assert before == 0.0
    assert since == pytest.approx(250.0 * 1e-3)


def driven(machine, seed=8, steps=600):
    voltages = np.repeat(np.random.default_rng(seed).uniform(-9, 9, (steps // 5, 3)), 5, axis=0)
    return plant_parameters(machine), voltages


def test_the_compiled_plant_has_the_same_spools_to_the_last_bit():
    for machine in (REAL, replace(REAL, valve=replace(REAL.valve, spool_damping=0.6, dead_time=0.011))):
        p, voltages = driven(machine)
        rows = [np.zeros((120, len(STATE))) for _ in range(2)]
        for run, states in zip((record, compiled_record()), rows, strict=True):
            run(equilibrium(POSE, p), voltages, 1e-3, p, states, None)
        assert np.array_equal(rows[0], rows[1])
        spools = rows[0][:, STATE.index("boom_spool_position")]
        assert np.ptp(spools) > 5.0


def test_a_run_in_pieces_is_the_run_as_a_whole_however_the_dead_time_falls():
    p, voltages = driven(REAL, steps=200)
    states = np.zeros((40, len(STATE)))
    record(equilibrium(POSE, p), voltages, 1e-3, p, states, None)
    flat, now = FlatPlant(), equilibrium(POSE, p)
    flat.lay_out(now)
    flat.set_parameters(p)
    for row in range(40):
        held = tuple(voltages[5 * row].tolist())
        now = advance(now, held, 1e-3, 5, p)
        flat.advance(held, 1e-3, 5)
        packed = np.zeros(len(STATE))
        store(now, packed)
        assert np.array_equal(packed, states[row])
        assert np.array_equal(flat.state, states[row])


def test_zero_voltage_shuts_the_valves_later_by_dead_time_and_slew():
    """What safety deadlines owe to a real valve: from full opening to the overlap's edge."""
    p = plant_parameters(REAL)
    now = advance(equilibrium(POSE, p), (0.0, 10.0, 0.0), 1e-3, 300, p)
    late, edge, w = (
        REAL.valve.dead_time,
        REAL.valve.deadband_voltage,
        2.0 * math.pi * REAL.valve.spool_bandwidth,
    )
    assert now.spools[1].position == pytest.approx(10.0 - 0.5 * REAL.valve.hysteresis)
    slew, rest = REAL.valve.spool_slew_limit, 0.5 * REAL.valve.hysteresis  # it stops short of the centre
    ramp = (now.spools[1].position - rest - slew / w) / slew
    shut = late + ramp + math.log(slew / w / (edge - rest)) / w
    steps = 0
    while now.spools[1].position > edge:
        now, steps = advance(now, (0.0, 0.0, 0.0), 1e-3, 1, p), steps + 1
    assert steps == math.ceil(shut / 1e-3)
