"""Claims about the law of a sensor: lag, errors, noise, floor, resolution, range, and ways not to work."""

import math

import numpy as np
import pytest

from forest_sim.sensors.sensor_model import (
    ABSENT,
    DROPPED,
    EXACT,
    FROZEN,
    WORKS,
    SensorMemory,
    SensorModel,
    sample,
    sample_exactly,
    sample_if,
)

REST = SensorMemory(0.0, 0.0)


def read(channel, true, normal=0.0, state=REST, dt=0.005):
    return sample(channel, state, true, dt, normal)[1]


@pytest.mark.parametrize("true", [0.0, -3.7, 1e9, 1e-12])
def test_an_exact_channel_reads_the_truth_to_the_last_bit(true):
    assert read(EXACT, true, normal=2.0) == true


def test_a_step_is_at_63_percent_after_the_time_constant():
    channel, state = SensorModel(time_constant=0.01), REST
    readings = []
    for _ in range(10):
        state, reading = sample(channel, state, 2.0, 0.005, 0.0)
        readings.append(reading)
    assert readings[1] == pytest.approx(2.0 * (1.0 - math.exp(-1.0)), rel=1e-12)
    assert readings == pytest.approx([2.0 * (1.0 - math.exp(-0.5 * k)) for k in range(1, 11)], rel=1e-12)


def test_the_lag_does_not_depend_on_how_time_is_cut():
    channel = SensorModel(time_constant=0.01)
    whole = sample(channel, REST, 1.0, 0.006, 0.0)[0].lagged
    half = sample(channel, REST, 1.0, 0.003, 0.0)[0]
    assert sample(channel, half, 1.0, 0.003, 0.0)[0].lagged == pytest.approx(whole, rel=1e-12)


def test_a_cable_with_play_follows_half_of_it_behind_and_stays_where_the_way_turns():
    channel, memory, shown = SensorModel(play=0.2), REST, []
    for true in (0.05, 1.0, 0.95, 0.8, 0.5, 0.6, 0.75):
        memory, reading = sample(channel, memory, true, 0.005, 0.0)
        shown.append(reading)
    assert shown == pytest.approx([0.0, 0.9, 0.9, 0.9, 0.6, 0.6, 0.65])


def test_gain_and_bias_are_the_static_error():
    assert read(SensorModel(gain=1.01, bias=0.5), 100.0) == pytest.approx(101.5)


def test_noise_has_its_standard_deviation_and_no_mean():
    channel, draws = SensorModel(noise=2e-4), np.random.default_rng(0).standard_normal(20_000)
    readings = np.array([read(channel, 0.3, normal) for normal in draws.tolist()])
    assert readings.std() == pytest.approx(2e-4, rel=0.03)
    assert abs(readings.mean() - 0.3) < 4.0 * 2e-4 / math.sqrt(20_000)


@pytest.mark.parametrize(
    ("true", "shown"), [(0.9, 0.9), (0.5, 0.85), (0.0, 0.85), (-0.0, 0.85), (-0.2, -0.85), (-2.0, -2.0)]
)
def test_below_the_floor_the_floor_is_shown_with_the_sign_of_the_flow(true, shown):
    assert read(SensorModel(floor=0.85), true) == shown


def test_noise_does_not_turn_the_sign_of_a_small_flow():
    assert {read(SensorModel(floor=0.85, noise=0.1), 1e-3, n) for n in (-3.0, -1.0, 0.0, 2.0)} == {0.85}


def test_a_reading_stands_on_whole_steps_at_most_half_of_one_away():
    channel = SensorModel(resolution=0.25)
    for true in np.random.default_rng(1).uniform(-3.0, 3.0, 200).tolist():
        reading = read(channel, true)
        assert reading / 0.25 == round(reading / 0.25)
        assert abs(reading - true) <= 0.125 + 1e-12


def test_beyond_the_range_a_reading_stands_at_its_end():
    channel = SensorModel(low=0.0, high=5.0, bias=0.5)
    assert [read(channel, true) for true in (-9.0, 3.0, 4.9, 9.0)] == [0.0, 3.5, 5.0, 5.0]


@pytest.mark.parametrize("true", [math.nan, math.inf, -math.inf, 1e308])
def test_no_true_value_makes_the_law_raise(true):
    for channel in (
        EXACT,
        SensorModel(0.01, 1.1, 0.1, 0.1, 0.85, 1e-6),
        SensorModel(resolution=0.1, low=0.0, high=1.0),
    ):
        read(channel, true)


def test_a_frozen_channel_repeats_its_last_reading():
    state, last = sample(EXACT, REST, 1.0, 0.005, 0.0)
    for true in (2.0, 3.0):
        state, reading = sample(EXACT._replace(mode=FROZEN), state, true, 0.005, 1.0)
        assert reading == last == 1.0
    assert sample(EXACT, state, 4.0, 0.005, 0.0)[1] == 4.0


@pytest.mark.parametrize("mode", [ABSENT, DROPPED])
def test_without_a_sample_there_is_no_reading_but_the_sensor_goes_on(mode):
    channel = SensorModel(time_constant=0.01)
    state, _ = sample(channel, REST, 1.0, 0.005, 0.0)
    missed, reading = sample(channel._replace(mode=mode), state, 1.0, 0.005, 0.0)
    assert math.isnan(reading)
    assert missed.reading == state.reading
    assert missed.lagged == sample(channel, state, 1.0, 0.005, 0.0)[0].lagged


def test_the_law_compiles_and_says_the_same_compiled():
    numba = pytest.importorskip("numba")
    compiled = numba.njit(sample)
    channel = SensorModel(0.01, 1.001, 0.2, 0.1, 0.85, 0.01, -5.0, 5.0)
    for c in (channel, channel._replace(mode=FROZEN), EXACT._replace(mode=ABSENT)):
        for true, normal in np.random.default_rng(2).normal(0.0, 3.0, (20, 2)).tolist():
            arguments = (c, SensorMemory(0.3, 0.4), true, 0.005, normal)
            np.testing.assert_array_equal(np.hstack(compiled(*arguments)), np.hstack(sample(*arguments)))


def test_an_exact_channel_reads_what_the_law_of_all_channels_says():
    for true in (0.0, -0.0, 1.5, -2e7, 5e-324, math.inf):
        assert repr(sample_exactly(true)) == repr(sample(EXACT, SensorMemory(3.0, 4.0), true, 0.005, -0.7))


def test_between_samples_everything_holds_and_what_is_absent_stays_so():
    before = SensorMemory(3.0, 4.0)
    for mode in (WORKS, FROZEN, DROPPED):
        state, reading = sample_if(False, EXACT._replace(mode=mode), before, 7.0, 0.005, 0.0)
        assert (state.reading, reading) == (4.0, 4.0)
    assert math.isnan(sample_if(False, EXACT._replace(mode=ABSENT), before, 7.0, 0.005, 0.0)[1])
    assert sample_if(True, EXACT, before, 7.0, 0.005, 0.0)[1] == 7.0
