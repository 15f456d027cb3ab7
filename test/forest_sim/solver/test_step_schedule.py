"""Claims about the lengths of steps: they fill the rows, are short after jumps, and pay."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.open_loop import Run, start_angles, whole
from forest_sim.solver import step_schedule
from forest_sim.solver.state_recording import STATE

THESIS = load_machine("c180_thesis")
START = start_angles(THESIS)


@pytest.mark.parametrize("period", [1e-3, 5e-3, 1.0 / 60.0, 0.1])
def test_steps_fill_every_row_and_are_never_longer_than_the_longest(period):
    jumped = np.random.default_rng(1).uniform(size=200) < 0.05
    given = step_schedule.after_jumps(jumped, period)
    np.testing.assert_allclose(given.steps * given.counts, period, rtol=1e-12)
    assert given.steps.max() <= step_schedule.LONGEST * (1.0 + 1e-9)
    assert set(np.unique(given.counts)) == {
        step_schedule.long_steps(period),
        step_schedule.FINER * step_schedule.long_steps(period),
    }


def test_a_schedule_stays_and_a_step_becomes_the_one_of_even_steps():
    given = step_schedule.even(0.1, 3, 4)
    assert step_schedule.schedule_of(given, 9, 9) is given
    steps, counts = step_schedule.schedule_of(0.001, 3, 6)
    assert (steps.tolist(), counts.tolist()) == ([0.001] * 3, [2.0] * 3)


def test_steps_are_short_from_a_jump_on_and_for_as_long_as_hoses_ring():
    jumped = np.zeros(30, dtype=bool)
    jumped[10] = True
    short = step_schedule.after_jumps(jumped, 5e-3).counts > 3
    np.testing.assert_array_equal(np.flatnonzero(short), np.arange(10, 18))


def test_a_jump_is_found_and_a_fast_sinusoid_is_none():
    times = (np.arange(300) + 0.5) * step_schedule.LONGEST
    wave = np.outer(5.0 * np.sin(2.0 * np.pi * 4.0 * times), np.ones(3))
    assert not step_schedule.jumps(wave, np.zeros(3), 100).any()
    wave[150:, 1] += 1.0
    np.testing.assert_array_equal(np.flatnonzero(step_schedule.jumps(wave, np.zeros(3), 100)), [50])


def test_middles_lie_in_the_middle_of_the_steps():
    given = step_schedule.StepSchedule(np.array([0.5, 1.0]), np.array([2.0, 1.0]))
    np.testing.assert_allclose(step_schedule.middles(given, 3.0), [3.25, 3.75, 4.5])


def error(run, reference):
    pressures = [
        STATE.index(f"{axis}_pressure_{port}") for axis in ("swing", "boom", "stick") for port in (1, 2)
    ]
    deviation = np.abs(run.states - reference.states)
    return deviation[:, STATE.index("swing_angle")].max(), deviation[:, pressures].max()


def test_short_steps_after_jumps_are_nearer_to_the_truth_than_even_steps_of_a_millisecond():
    """Two seconds hold a jump up, its end, and, at a block's border, the ring of one before."""
    voltages = voltage_profiles.steps()
    reference = whole(THESIS, voltages, START, Run(2.0, step=5e-5))
    runs = Run(2.0), Run(2.0, short_after_jumps=True)
    even, short = (error(whole(THESIS, voltages, START, run), reference) for run in runs)
    assert short[0] < even[0]
    assert short[1] < even[1]
