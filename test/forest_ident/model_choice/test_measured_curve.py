"""The metering curve of a valve is read off its rig's record."""

import numpy as np
import pytest
from foreign_plants import foreign

from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.readings import openings
from forest_ident.measurements.session import Session
from forest_ident.model_choice import candidates, measured_curve
from forest_ident.model_choice.measured_curve import with_measured_curves
from forest_ident.refinement.identification import identify

CURVED = foreign("curved_valve", 1)


@pytest.fixture(scope="module")
def valve():
    return experiment("valve", CURVED.crane, seed=1)


def opening(machine, volts):
    """Return the flow through an edge of port 1 at one pressure drop, over voltages."""
    law = machine.valve.law
    shape = openings(volts, law.forward, law.curve)
    return shape / shape[-1]  # a fit finds the gain


def test_the_measured_curve_is_nearer_to_the_truth_than_the_straight_law_and_the_usual_notch(valve):
    straight = identify(CURVED.told, [valve], refine=False)
    usual = next(c for c in candidates.CANDIDATES if c.name == "curve").add(CURVED.told)
    measured = with_measured_curves(usual, [valve])
    volts = np.linspace(0.0, CURVED.crane.valve.rated_voltage, 60)
    truth = opening(CURVED.crane, volts)
    away = [np.max(np.abs(opening(m, volts) - truth)) for m in (measured, straight.machine, usual)]
    assert away[0] < 0.02
    assert away[0] < 0.5 * min(away[1:])


def test_without_a_record_of_the_rig_the_usual_curve_stays():
    usual = next(c for c in candidates.CANDIDATES if c.name == "curve").add(CURVED.told)
    assert with_measured_curves(usual, []) == usual


def usual():
    return next(c for c in candidates.CANDIDATES if c.name == "curve").add(CURVED.told)


def test_a_curve_rises_from_zero_and_is_straight_between_what_was_measured():
    """What falls is levelled with its neighbour (isotonic least squares)."""
    valve = usual().valve
    curve = measured_curve._curve(valve, np.array([0.4, 0.5, 1.0]), np.array([0.5, 0.3, 1.0]))
    edge = max(valve.law.forward.deadband_voltage, valve.law.backward.deadband_voltage)
    strokes = [0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0]
    assert (np.array(curve.voltages) - edge) / (valve.rated_voltage - edge) == pytest.approx(strokes)
    assert curve.voltages[-1] == valve.rated_voltage
    level = np.array([0.05, 0.1, 0.2, 0.3, 0.4, 0.52, 0.76, 1.0]) + 1e-4 * np.arange(1, 9)
    assert curve.flows == pytest.approx(1e-3 * level / level[-1])


def steady(volts, flows, drop=4e6):
    """A record of the valve's rig with holds of a second each."""
    rows = 200
    table = np.repeat(np.array(volts, dtype=float), rows)
    flow, out = np.repeat(np.array(flows), rows), np.repeat(np.array(volts) > 0.0, rows)
    readings = {
        "supply_pressure": np.full(len(table), 20e6),
        "swing_pressure_1_valve": np.where(out, 20e6 - drop, drop),
        "swing_pressure_2_valve": np.where(out, drop, 20e6 - drop),
        "swing_flow": flow,
    }
    voltages = np.zeros((len(table), 3))
    voltages[:, 0] = table
    return Session("valve", np.arange(len(table)) * 0.005, voltages, readings, {"exact_sensors": 1.0})


def test_points_are_strokes_and_openings_both_ways_the_backward_ones_scaled_to_the_forward():
    machine = usual()
    valve = machine.valve
    ways = valve.law.forward, valve.law.backward

    def volt(stroke, way):
        return way.deadband_voltage + stroke * (way.rated_voltage - way.deadband_voltage)

    forward = [(0.8, 8e-4), (0.2, 2e-4), (0.5, 5e-4)]
    backward = [(0.3, -6e-4), (0.6, -12e-4)]  # opens twice as wide
    volts = [volt(s, ways[0]) for s, _ in forward] + [-volt(s, ways[1]) for s, _ in backward]
    record = steady([*volts, 0.5 * ways[0].deadband_voltage], [q for _, q in (*forward, *backward)] + [1e-4])
    stroke, opening = measured_curve._points(machine, valve, record)
    assert stroke == pytest.approx([0.2, 0.3, 0.5, 0.6, 0.8])
    assert opening == pytest.approx(np.array([0.2, 0.3, 0.5, 0.6, 0.8]) * 1e-3 / np.sqrt(4e6))
    alone = steady([volt(0.4, ways[0])], [4e-4])
    assert [len(column) for column in measured_curve._points(machine, valve, alone)] == [1, 1]
    shut = steady([0.5 * ways[0].deadband_voltage], [4e-4])
    assert [len(column) for column in measured_curve._points(machine, valve, shut)] == [0, 0]


@pytest.mark.parametrize(("count", "taken"), [(5, False), (6, True)])
def test_six_points_make_a_curve(count, taken):
    machine = usual()
    way = machine.valve.law.forward
    strokes = np.linspace(0.1, 1.0, count)
    volts = way.deadband_voltage + strokes * (way.rated_voltage - way.deadband_voltage)
    found = with_measured_curves(machine, [steady(volts, 1e-3 * strokes**1.2)])
    assert (found.valve.curve != machine.valve.curve) == taken
