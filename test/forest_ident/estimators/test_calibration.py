"""Offsets and gains of the sensors: record, machine file, simulated sensors, records put right."""

import dataclasses

import numpy as np
import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators import calibration
from forest_ident.measurements.session import Session, SessionError
from forest_ident.refinement import identification
from forest_ident.report import machine_writer
from forest_sim.sensors.sensor_suite import CHANNELS, sensor_suite

C180 = load_machine("c180_hoses")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    session = experiment("calibration", C180, seed=5)
    result = identification.identify(C180, [session], refine=False)
    return machine_writer.write(result, "c180_hoses", tmp_path_factory.mktemp("calibration") / "mine.yaml")


def test_what_a_calibration_found_is_in_the_file(calibrated):
    true = dict(zip(CHANNELS, sensor_suite(C180, noise=True, seed=5).channels, strict=True))
    told = calibration.lines(calibrated)
    assert set(told) == {n for n in CHANNELS if "pressure" in n or "temperature" in n}
    for name, (gain, bias) in told.items():
        at = 350.0 if "temperature" in name else 1e7
        error = gain * at + bias - (true[name].gain * at + true[name].bias)
        assert abs(error) < (0.01 if "temperature" in name else 250.0), name


def test_simulated_sensors_have_the_errors_of_the_file_whatever_the_seed(calibrated):
    told = calibration.lines(calibrated)
    one, two = (sensor_suite(calibrated, noise=True, seed=seed).channels for seed in (1, 2))
    for name, a, b in zip(CHANNELS, one, two, strict=True):
        if name in told:
            assert (a.gain, a.bias) == told[name]
            assert a == b
    resolver = CHANNELS.index("swing_resolver")
    assert one[resolver] != two[resolver]
    assert one[resolver] == sensor_suite(C180, noise=True, seed=1).channels[resolver]


def test_exact_sensors_have_no_calibration_error(calibrated):
    assert sensor_suite(calibrated).channels == sensor_suite(C180).channels


def test_correction_undoes_reading_but_at_the_ends(calibrated):
    name = "boom_pressure_1_valve"
    true = np.array([1e6, 5e6, 2e7])
    read = calibration.as_read({name: true}, calibrated)[name]
    assert np.all(read != true)
    session = Session("motion", np.arange(4.0), np.zeros((4, 3)), {name: np.append(read, 0.0)})
    assert calibration.corrected(session, calibrated).column(name) == pytest.approx([*true, 0.0], rel=1e-12)


def test_a_file_without_calibration_changes_no_record():
    session = experiment("calibration", C180, seed=5)
    again = calibration.corrected(session, C180)
    assert all(np.array_equal(again.readings[n], session.readings[n]) for n in session.readings)


def test_a_new_calibration_replaces_what_it_found_anew_alone(calibrated, tmp_path):
    flow = dataclasses.replace(
        calibrated.sensors,
        calibration=dataclasses.replace(calibrated.sensors.calibration, supply_pressure=None),
    )
    start = dataclasses.replace(calibrated, sensors=flow)
    session = experiment("calibration", C180, seed=6)
    kept = {n: y for n, y in session.readings.items() if n.startswith("supply")}
    told = identification.identify(start, [dataclasses.replace(session, readings=kept)], refine=False)
    now = told.machine.sensors.calibration
    assert now.supply_pressure is not None
    assert now.boom_pressure_1_valve == calibrated.sensors.calibration.boom_pressure_1_valve


def test_a_gain_beyond_the_range_is_named(calibrated):
    unit = calibrated.sensors.calibration.supply_pressure
    with pytest.raises(MachineError, match=r"CalibratedPressure.gain: 3 is outside 0.5 .. 2"):
        dataclasses.replace(unit, gain=3.0)


def baths(ice, boiling, **facts):
    """A record of 8 s of a thermocouple that lags for a second on either side of the change at 4 s."""
    time = np.arange(1600) * 0.005
    zigzag = np.where(np.arange(1600) % 2, 0.2, -0.2)
    read = np.where(time < 4.0, ice, boiling) + zigzag
    read[(time >= 3.0) & (time <= 5.0)] = 300.0
    return Session("calibration", time, np.zeros((1600, 3)), {"tank_temperature": read}, facts)


def test_a_thermocouple_is_put_right_by_ice_and_boiling_water():
    (found,) = calibration.calibrate(C180, baths(274.15, 375.15, ice_until=4.0))
    assert (found.channel, found.unit) == ("tank_temperature", "K")
    assert (found.offset, found.gain) == pytest.approx((1.0, 1.01), rel=1e-5)
    ice, boiling = 0.2 / np.sqrt(600), 0.2 / np.sqrt(599)  # rows before 3 s, and after 5 s
    assert found.offset_error == pytest.approx(ice, rel=1e-4)
    assert found.gain_error == pytest.approx(np.hypot(ice, boiling) / 100.0, rel=1e-4)
    calibration.calibrate(C180, baths(297.15, 349.15, ice_until=4.0))  # off by 24 K
    with pytest.raises(SessionError, match=r"reads 299.3 K in ice; allowed: 273.15 K within 25 K"):
        calibration.calibrate(C180, baths(299.27, 373.15, ice_until=4.0))
    with pytest.raises(SessionError, match=r"reads 347.2 K in boiling water; allowed: 373.15 K within 25 K"):
        calibration.calibrate(C180, baths(273.15, 347.2, ice_until=4.0))
    with pytest.raises(SessionError, match="reads nan K in boiling water"):
        calibration.calibrate(C180, baths(273.15, 373.15, ice_until=4.0, boiling_from=7.0))


def test_a_transducer_under_pressure_is_refused_and_one_that_shows_zero_stays_unknown():
    def found(read):
        readings = {"supply_pressure": np.asarray(read)}
        return calibration.calibrate(
            C180, Session("calibration", np.arange(400) * 0.005, np.zeros((400, 3)), readings)
        )

    with pytest.raises(SessionError, match=r"supply_pressure reads 1.25 MPa; allowed: less than 1 MPa"):
        found(np.full(400, 1.25e6))
    assert (found(np.full(400, 0.9e6))[0].offset, found(np.full(400, 5.0))[0].offset_error) == (0.9e6, 0.0)
    assert np.isinf(found(np.zeros(400))[0].offset_error)
    noise = np.random.default_rng(3).normal(0.0, 4e3, 400)
    (offset,) = found(np.maximum(2e3 + noise, 0.0))
    assert offset.offset == pytest.approx(2e3, abs=4.0 * offset.offset_error)
    assert 0.8 * 4e3 / 20.0 < offset.offset_error < 2.0 * 4e3 / 20.0


def test_a_simulated_calibration_is_of_20_s_in_each_bath_with_the_lines_open():
    session = calibration.simulated(sensor_suite(C180, noise=False, seed=1))
    assert (session.voltages.shape, session.time[200], session.metadata["ice_until"]) == (
        (8000, 3),
        1.0,
        20.0,
    )
    bath = next(column for name, column in session.readings.items() if "temperature" in name)
    assert bath[3000] == pytest.approx(273.15, abs=0.1)
    assert bath[7000] == pytest.approx(373.15, abs=0.1)
    assert not any(column.any() for name, column in session.readings.items() if "pressure" in name)


def test_the_second_meters_gain_is_over_the_first_where_flow_is_steady_and_well_above_the_floor():
    one = np.r_[np.full(20, 1e-3), np.full(20, -5e-4), np.full(20, 2e-5)]
    two = 1.02 * one
    two[[0, 20]], two[50] = 1.0, 5e-5  # where the flow has just changed, and at the floor
    readings = {"swing_flow": one, "stick_flow": two}
    session = Session("valve", np.arange(60) * 0.005, np.zeros((60, 3)), readings)
    found = calibration.meter_gain(session, 1e-5)
    assert (found.channel, found.unit, found.gain) == ("stick_flow", "m3/s", pytest.approx(1.02))
    assert found.gain_error == pytest.approx(0.0, abs=1e-12)
    assert (found.offset, found.offset_error) == (0.0, 0.0)
    assert calibration.meter_gain(session, 1e-2) is None
    assert calibration.meter_gain(dataclasses.replace(session, readings={"swing_flow": one}), 1e-5) is None


def series(gain):
    """Return a valve's record whose second meter reads a gain of the first one."""
    one = np.r_[np.full(20, 1e-3), np.full(20, -5e-4)]
    return Session(
        "valve", np.arange(40) * 0.005, np.zeros((40, 3)), {"swing_flow": one, "stick_flow": gain * one}
    )


@pytest.mark.parametrize("gain", [0.19, 2.1, -1.0])
def test_meters_that_have_nothing_in_common_are_named(gain):
    with pytest.raises(
        SessionError, match=r"valve: stick_flow reads .* in series with it; allowed: 0\.5 to 2"
    ):
        calibration.meter_gain(series(gain), 1e-5)


def test_meters_that_differ_more_than_their_file_allows_are_told():
    machine = load_machine("c180_hoses")  # 0.05 % each
    assert calibration.disagreement(machine, calibration.meter_gain(series(1.0009), 1e-5)) == ""
    apart = calibration.meter_gain(series(0.985), 1e-5)
    said = "the flow meters differ by 1.5 %, their file tells 0.05 % of each"
    assert calibration.disagreement(machine, apart) == said
    assert calibration.disagreement(machine, apart._replace(gain_error=0.01)) == ""


def test_readings_are_put_right_but_at_the_ends_of_a_range(calibrated):
    name = next(one for one in calibration.lines(calibrated) if "pressure" in one)
    (gain, bias), full = calibration.lines(calibrated)[name], calibrated.sensors.pressure.full_scale
    read = np.array([0.0, 1e6, 2e7, full])
    session = Session("valve", np.arange(4) * 0.005, np.zeros((4, 3)), {name: read})
    right = calibration.corrected(session, calibrated).readings[name]
    assert right == pytest.approx([0.0, (1e6 - bias) / gain, (2e7 - bias) / gain, full])
    again = calibration.as_read({name: right, "other": right}, calibrated)
    assert again[name][1:3] == pytest.approx([1e6, 2e7])
    assert again["other"] is right


def test_a_flow_at_an_end_of_its_meters_range_is_left_as_it_reads():
    units = calibration.updated(C180, [calibration.Offset("stick_flow", 0.0, 0.0, "m3/s", 1.02, 0.001)])
    machine = dataclasses.replace(C180, sensors=dataclasses.replace(C180.sensors, calibration=units))
    meter = C180.sensors.flow_meter
    read = np.array([meter.lowest, -meter.lowest, 1.02e-3, -meter.highest])
    session = Session("valve", np.arange(4) * 0.005, np.zeros((4, 3)), {"stick_flow": read})
    right = calibration.corrected(session, machine).readings["stick_flow"]
    assert right == pytest.approx([meter.lowest, -meter.lowest, 1e-3, -meter.highest])
