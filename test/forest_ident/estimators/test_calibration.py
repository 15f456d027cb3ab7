"""Offsets and gains of the sensors: record, machine file, simulated sensors, records put right."""

import dataclasses

import numpy as np
import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators import calibration
from forest_ident.measurements.session import Session
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
