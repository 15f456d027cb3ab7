"""Claims about a machine's sensors: which there are, what each is worth, what the seed decides."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.config.parameter import MachineError
from forest_description.config.units import UNITS
from forest_description.machine import load_machine
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_model import ABSENT, DROPPED, EXACT, FROZEN, WORKS
from forest_sim.sensors.sensor_suite import (
    CHANNELS,
    KINDS,
    NO_DRAWS,
    PLACES,
    UNIT,
    calibrated,
    conditions,
    draw,
    noise_generator,
    sensor_suite,
)

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")
PSI, GALLON_PER_MINUTE = 6894.7, UNITS["gal/min"].factor


def fitted(machine):
    """Return the channels of the kinds that a machine has."""
    kinds = [kind for kind in KINDS if getattr(machine.sensors, kind.name) is not None]
    return {name for kind in kinds for name in kind.channels}


def channel(name, machine=THESIS, seed=0):
    return sensor_suite(machine, noise=True, seed=seed).channels[CHANNELS.index(name)]


def test_there_are_the_sensors_of_table_4_2_and_those_of_section_4_2_2():
    counts = {kind.name: len(kind.channels) for kind in KINDS}
    assert (
        counts.items()
        >= {
            "resolver": 3,
            "linear_transducer": 2,
            "pressure": 12 + 1,  # and the pump's
            "flow_meter": 2,
            "thermocouple": 3,
            "tachometer": 1,
            "spool_sensor": 3,
            "inclinometer": 2,
            "case_drain": 1,
        }.items()
    )
    assert len(set(CHANNELS)) == len(CHANNELS) == sum(counts.values())
    assert {name for kind in KINDS for name in CHANNELS[PLACES[kind.name]]} == set(CHANNELS)
    assert all(CHANNELS[PLACES[kind.name]] == kind.channels for kind in KINDS)


def test_without_noise_every_sensor_is_exact_and_read_whenever_asked():
    suite = sensor_suite(C180)
    assert {name for name, c in zip(CHANNELS, suite.channels, strict=True) if c == EXACT} == fitted(C180)
    assert suite.period == 0.0


@pytest.mark.parametrize("noise", [False, True])
def test_a_kind_that_the_machine_lacks_is_absent_with_noise_and_without(noise):
    suite = sensor_suite(THESIS, noise)
    modes = dict(zip(CHANNELS, (c.mode for c in suite.channels), strict=True))
    assert modes["case_drain"] == ABSENT
    assert {name for name, mode in modes.items() if mode == WORKS} == fitted(THESIS)
    assert set(modes.values()) == {WORKS, ABSENT}


BOUNDS = {
    "boom_resolver": ("bias", 0.0, 7 / 60 * math.pi / 180.0),
    "stick_pressure_2_valve": ("bias", 0.0, 1e-4 * 5000 * PSI),
    "supply_pressure": ("bias", 0.0, 1e-4 * 5000 * PSI),
    "swing_flow": ("gain", 1.0, 5e-4),
    "pump_temperature": ("bias", 0.0, 0.2),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_static_errors_fill_the_printed_accuracy_evenly_and_never_leave_it(name):
    field, middle, bound = BOUNDS[name]
    errors = np.array([getattr(channel(name, seed=seed), field) - middle for seed in range(300)]) / bound
    assert np.all(np.abs(errors) <= 1.0 + 1e-9)
    assert errors.min() < -0.95
    assert errors.max() > 0.95
    assert errors.std() == pytest.approx(1.0 / math.sqrt(3.0), rel=0.1)


def test_calibration_takes_out_what_is_constant_and_nothing_else():
    noisy = sensor_suite(C180, noise=True, seed=1)
    without = calibrated(noisy)
    assert {(c.bias, c.gain) for c in without.channels} == {(0.0, 1.0)}
    assert any(c.bias for c in noisy.channels)
    for before, after in zip(noisy.channels, without.channels, strict=True):
        assert after == before._replace(bias=0.0, gain=1.0)
    assert without[1:] == noisy[1:]


def test_ranges_lag_floor_and_resolution_are_those_printed():
    turn, pressure, oil = (
        channel("swing_resolver"),
        channel("boom_pressure_1_valve"),
        channel("tank_temperature"),
    )
    assert (turn.low, turn.high) == (-math.pi, math.pi)
    assert (pressure.low, pressure.high) == (0.0, 5000 * PSI)
    assert (oil.low, oil.high) == (3.15, 1633.15)
    flow, length = channel("stick_flow"), channel("stick_transducer")
    assert (flow.low, flow.high) == (-50 * GALLON_PER_MINUTE, 50 * GALLON_PER_MINUTE)
    assert (flow.floor, flow.time_constant) == (0.85 * GALLON_PER_MINUTE, 0.01)
    assert length.resolution == pytest.approx(0.0004 * 36.5 * 0.0254)
    assert length.high - length.low == pytest.approx(36.5 * 0.0254)
    assert THESIS.stick.retracted_length - length.low == pytest.approx(0.25 * 0.0254)


def test_resolvers_and_pressure_transducers_read_in_steps_where_the_file_says_so():
    sensors = C180.sensors
    turn = dataclasses.replace(sensors.resolver, resolution=2.0 * math.pi / 4096)
    pressure = dataclasses.replace(sensors.pressure, resolution=1 / 4096)
    coarse = dataclasses.replace(C180, sensors=dataclasses.replace(sensors, resolver=turn, pressure=pressure))
    assert channel("boom_resolver", coarse).resolution == turn.resolution
    assert channel("supply_pressure", coarse).resolution == pressure.full_scale / 4096
    assert channel("boom_resolver", C180).resolution == channel("supply_pressure", C180).resolution == 0.0


def test_a_cable_encoder_has_a_static_error_of_its_range_and_play():
    cable = dataclasses.replace(C180.sensors.linear_transducer, accuracy=0.001, play=3e-4)
    crane = dataclasses.replace(C180, sensors=dataclasses.replace(C180.sensors, linear_transducer=cable))
    biases = [channel("boom_transducer", crane, seed).bias for seed in range(200)]
    assert 0.9 < max(biases) / (0.001 * cable.full_scale) <= 1.0
    assert 0.9 < -min(biases) / (0.001 * cable.full_scale) <= 1.0
    assert channel("stick_transducer", crane).play == 3e-4
    assert channel("stick_transducer", C180).play == channel("stick_transducer", C180).bias == 0.0


def by(kind, base=C180):
    """The crane with angles of boom and stick by a kind of sensor."""
    return dataclasses.replace(base, sensors=dataclasses.replace(base.sensors, joint_angles=kind))


def test_what_makes_the_angles_stands_in_for_two_resolvers_and_leaves_all_noise_as_it_was():
    before, after = sensor_suite(C180, True, 3), sensor_suite(by("linear_transducer"), True, 3)
    changed = [name for name, a, b in zip(CHANNELS, before.channels, after.channels, strict=True) if a != b]
    assert changed == ["boom_resolver", "stick_resolver"]
    assert all(after.channels[CHANNELS.index(name)].mode == ABSENT for name in changed)
    assert sensor_suite(by("resolver"), True, 3) == before
    drawn = draw(noise_generator(after))
    assert drawn == draw(noise_generator(before))
    assert drawn.normal[CHANNELS.index("boom_inertial_unit")] == drawn.normal[CHANNELS.index("boom_resolver")]


@pytest.mark.parametrize("kind", ["linear_transducer", "inertial_unit"])
def test_angles_by_what_is_not_fitted_are_refused(kind):
    bare = dataclasses.replace(C180.sensors, linear_transducer=None)
    with pytest.raises(
        MachineError, match=f"joint_angles: {kind} is not fitted; allowed: resolver, its numbers"
    ):
        dataclasses.replace(bare, joint_angles=kind)
    with pytest.raises(MachineError, match="'sundial' is none of resolver, linear_"):
        dataclasses.replace(bare, joint_angles="sundial")


def test_the_thesis_prints_no_noise_and_the_c180_has_that_of_realistic_control():
    assert {c.noise for c in sensor_suite(THESIS, True).channels} == {0.0}
    assert all(channel(name, C180).noise > 0.0 for name in fitted(C180))
    assert channel("boom_resolver", C180).noise == 2e-4
    assert channel("boom_transducer", C180).noise == pytest.approx(0.18e-3)
    assert channel("supply_pressure", C180).noise == pytest.approx(0.5 * PSI)


def test_equal_seeds_give_equal_units_and_draws_and_other_seeds_others():
    one, same, other = (sensor_suite(C180, True, seed) for seed in (3, 3, 4))
    assert one == same
    assert all(a != b for a, b in zip(one.channels, other.channels, strict=True) if is_random(a))
    first, second, third = (draw(noise_generator(suite)) for suite in (one, same, other))
    assert first == second
    assert not set(first.normal) & set(third.normal)


def is_random(c):
    """Tell whether a unit has a static error of its own."""
    return c.mode != ABSENT and not c.resolution


def test_taking_a_sensor_away_changes_no_other():
    without = dataclasses.replace(C180, sensors=dataclasses.replace(C180.sensors, linear_transducer=None))
    before, after = sensor_suite(C180, True, 1).channels, sensor_suite(without, True, 1).channels
    changed = [name for name, a, b in zip(CHANNELS, before, after, strict=True) if a != b]
    assert changed == ["boom_transducer", "stick_transducer"]


def mode(faults, name="boom_resolver", time=1.0, uniform=NO_DRAWS.uniform):
    suite = sensor_suite(C180, faults=parse_faults(faults))
    return conditions(suite, time, uniform)[CHANNELS.index(name)]


@pytest.mark.parametrize(("time", "expected"), [(1.995, WORKS), (2.0, FROZEN), (2.995, FROZEN), (3.0, WORKS)])
def test_a_fault_holds_from_its_start_until_before_its_end(time, expected):
    assert mode("boom_resolver: frozen from 2 s until 3 s", time=time).mode == expected


def test_a_fault_is_of_its_channel_alone():
    suite = sensor_suite(C180, faults=parse_faults("swing_flow: absent"))
    now = conditions(suite, 0.0, NO_DRAWS.uniform)
    changed = {name for name, c in zip(CHANNELS, now, strict=True) if c != EXACT}
    assert changed & fitted(C180) == {"swing_flow"}


def test_a_noisy_channel_has_so_much_of_its_own_noise():
    suite = sensor_suite(C180, noise=True, faults=parse_faults("boom_resolver: noise 500 % from 1 s"))
    place = CHANNELS.index("boom_resolver")
    before, after = (conditions(suite, time, NO_DRAWS.uniform)[place] for time in (0.9, 1.1))
    assert after.noise == 5.0 * before.noise > 0.0
    assert after._replace(noise=before.noise) == before


def test_faults_of_one_channel_add_up_and_the_worst_way_of_not_working_wins():
    channel = mode("boom_resolver: bias 1 deg; boom_resolver: bias 0.5 deg; boom_resolver: frozen")
    assert channel.bias == pytest.approx(math.radians(1.5))
    assert channel.mode == FROZEN
    assert mode("boom_resolver: drop; boom_resolver: frozen").mode == DROPPED
    assert mode("boom_resolver: absent; boom_resolver: drop").mode == ABSENT


def test_a_share_of_samples_is_dropped():
    generator, faults = np.random.default_rng(5), "boom_resolver: drop 20 %"
    lost = [mode(faults, uniform=draw(generator).uniform).mode == DROPPED for _ in range(2000)]
    assert np.mean(lost) == pytest.approx(0.2, abs=0.03)


def test_every_channel_has_its_unit():
    assert UNIT["boom_resolver"] == "rad"
