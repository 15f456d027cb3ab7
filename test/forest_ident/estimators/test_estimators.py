"""The estimators on simulated experiments with the sensors of Table 4.2: the truth is known."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators import (
    calibration,
    damping,
    gravity,
    hose_estimators,
    motor_leakage,
    valve_estimate,
)
from forest_ident.refinement import linear_estimates
from forest_sim.sensors.sensor_suite import CHANNELS, sensor_suite


def points_and_law(machine, session):
    points = valve_estimate.points(session, linear_estimates.highest(machine, session))
    low = linear_estimates.floor(machine, session)
    return points, valve_estimate.law(points, load_machine("c180_hoses").valve, low, 1e-7)


def test_overlap_and_gain_of_the_valve_are_found_by_direction(unknown_machine, sessions):
    _, law = points_and_law(unknown_machine, sessions("valve"))
    valve = unknown_machine.valve
    for way in ("", "backward."):
        assert law.values[f"{way}deadband_voltage"] == pytest.approx(valve.deadband_voltage, abs=0.005)
        assert law.values[f"{way}minimum_resistance"] == pytest.approx(valve.minimum_resistance, rel=0.01)
    assert law.values["port_2_area"] == pytest.approx(1.0, rel=0.005)


def test_the_meters_floor_is_not_taken_for_flow(unknown_machine, sessions):
    """What stands at the floor, taken as flow, would put the overlap's edge a tenth of a volt too low."""
    points, censored = points_and_law(unknown_machine, sessions("valve"))
    taken = valve_estimate.law(points, load_machine("c180_hoses").valve, 0.0, 1e-7)
    truth = unknown_machine.valve.deadband_voltage
    wrong = abs(taken.values["deadband_voltage"] - truth)
    assert wrong > 10.0 * abs(censored.values["deadband_voltage"] - truth)


def test_the_polynomial_goes_through_what_was_read(unknown_machine, sessions):
    points, _ = points_and_law(unknown_machine, sessions("valve"))
    c_r = valve_estimate.resistance(points, linear_estimates.floor(unknown_machine, sessions("valve")))
    coefficients = valve_estimate.polynomial(points.voltage, c_r)
    open_wide = np.isfinite(c_r) & (np.abs(points.voltage) > 5.0)
    said = np.polynomial.polynomial.polyval(np.abs(points.voltage[open_wide]), coefficients)
    assert said == pytest.approx(c_r[open_wide], rel=0.6)


def test_the_hoses_resistance_is_found(unknown_machine, sessions):
    session = sessions("hose")
    line = hose_estimators.resistance(*hose_estimators.steady(session, 5.4e-5, 3.1e-3), laminar=False)
    assert line.values[0] == pytest.approx(unknown_machine.hose.turbulent_resistance, rel=0.01)


def test_inertance_and_capacitance_are_found_in_phase(unknown_machine, sessions):
    session, hose = sessions("hose"), unknown_machine.hose
    lag = unknown_machine.sensors.flow_meter.time_constant
    r = hose.turbulent_resistance
    inertance, capacitance = hose_estimators.joint(session, r, False, lag, 5.4e-5, 3.1e-3)
    assert inertance.values[0] == pytest.approx(hose.inertance, rel=0.05)
    assert capacitance.values[0] == pytest.approx(hose.capacitance, rel=0.05)


def test_a_bend_at_a_sample_is_made_up_for_in_sums_over_samples():
    h, voltage = 0.005, np.where(np.arange(400) < 100, 0.0, 1.0)
    time = h * np.maximum(np.arange(400) - 100.0, 0.0)
    column = 1e6 * np.exp(-time / 0.1) * (1.0 - np.exp(-time / 0.013)) / 0.013
    exact = 1e6 / 0.013 * (0.1 - 1.0 / (1.0 / 0.1 + 1.0 / 0.013))
    bent, unbent = (h * np.sum(c) for c in (column, hose_estimators.unbent(column, voltage)))
    assert abs(unbent - exact) < 0.1 * abs(bent - exact)


def test_both_leakages_of_the_motor_are_found(unknown_machine, sessions):
    external = motor_leakage.external(unknown_machine, sessions("motor_external")).values[0]
    internal = motor_leakage.internal(unknown_machine, sessions("motor_internal"), external).values[0]
    assert 1.0 / external == pytest.approx(unknown_machine.swing.external_leakage_resistance, rel=0.02)
    assert 1.0 / internal == pytest.approx(unknown_machine.swing.internal_leakage_resistance, rel=0.02)


def test_a_vessel_under_the_case_drain_does_as_well(unknown_machine, sessions):
    session = sessions("motor_external")
    blind = {name: column for name, column in session.readings.items() if name != "case_drain"}
    line = motor_leakage.external(unknown_machine, dataclasses.replace(session, readings=blind))
    assert 1.0 / line.values[0] == pytest.approx(unknown_machine.swing.external_leakage_resistance, rel=0.01)


def test_damping_is_found_though_angles_are_off(unknown_machine, sessions):
    found = damping.damping(unknown_machine, sessions("damping_swing"), 0)
    assert found.values[0] == pytest.approx(unknown_machine.swing.damping, rel=0.01)


def test_a_load_that_nobody_told_is_weighed(unknown_machine):
    loaded = dataclasses.replace(
        unknown_machine, manipulator=dataclasses.replace(unknown_machine.manipulator, head_mass=900.0)
    )
    session = experiment("gravity", loaded, seed=3)
    assert gravity.masses(unknown_machine, session).values[0] == pytest.approx(900.0, rel=0.02)


def test_boom_and_head_are_weighed_together(unknown_machine):
    links = dataclasses.replace(
        unknown_machine.manipulator, boom_mass=1.2 * unknown_machine.manipulator.boom_mass
    )
    session = experiment("gravity", dataclasses.replace(unknown_machine, manipulator=links), seed=3)
    found = {e.key: e.value for e in linear_estimates.estimates(unknown_machine, session)}
    assert found["manipulator.boom_mass"] == pytest.approx(links.boom_mass, rel=0.02)
    assert found["manipulator.head_mass"] == pytest.approx(links.head_mass, rel=0.02)


def test_a_transducers_offset_is_found_even_below_its_zero():
    machine = load_machine("c180_hoses")
    suite = sensor_suite(machine, noise=True, seed=1)
    truth = {name: c.bias for name, c in zip(CHANNELS, suite.channels, strict=True)}
    found = calibration.calibrate(machine, calibration.simulated(suite))
    offsets = [o for o in found if o.unit == "Pa"]
    assert min(truth[o.channel] for o in offsets) < -2000.0
    for o in offsets:
        assert abs(o.offset - truth[o.channel]) < 4.5 * o.offset_error + 1.0
    assert all(math.isclose(o.gain, 1.0, abs_tol=1e-3) for o in found if o.unit == "K")
