"""The valve's characteristic from holds made by hand, both ways."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.hydraulics.valve_parameters import BackwardValve
from forest_description.machine import load_machine
from forest_ident.estimators import valve_estimate
from forest_ident.estimators.valve_estimate import Points
from forest_ident.measurements.session import Session

VALVE = dataclasses.replace(
    load_machine("c180_hoses").valve, port_2_area=0.8, backward=BackwardValve(1.5, 2e12)
)


def record(*levels, rows=200):
    """Holds of (voltage, flow, supply, p_1, p_2); each begins with 60 rows of what the last one left."""
    columns = [np.repeat(column, rows) for column in np.array(levels, dtype=float).T]
    for k in range(len(levels)):
        for column in columns[1:]:
            column[rows * k : rows * k + 60] += 7.0
    volts = np.zeros((rows * len(levels), 3))
    volts[:, 0] = columns[0]
    names = ("swing_flow", "supply_pressure", "swing_pressure_1_valve", "swing_pressure_2_valve")
    readings = dict(zip(names, columns[1:], strict=True))
    return Session("valve", np.arange(len(volts)) * 0.005, volts, readings, {})


def test_a_hold_is_a_point_once_it_has_settled_with_the_drops_of_its_direction():
    session = record((4.0, 1e-3, 20e6, 14e6, 5e6), (0.0, 0.0, 20e6, 9e6, 9e6), (-6.0, -2e-3, 20e6, 3e6, 12e6))
    found = valve_estimate.points(session)
    assert found.voltage.tolist() == [4.0, -6.0]  # a shut valve tells nothing
    assert found.flow == pytest.approx([1e-3, -2e-3])
    assert found.drop_1 == pytest.approx([6e6, 3e6])
    assert found.drop_2 == pytest.approx([5e6, 8e6])
    assert found.samples.tolist() == [140.0, 140.0]
    session.readings["swing_flow"][-1] = -3e-3  # one reading at the meter's end
    assert valve_estimate.points(session, 8.0).voltage.tolist() == [4.0, -6.0]
    assert valve_estimate.points(session, 3e-3).voltage.tolist() == [4.0]
    assert valve_estimate.points(session, 3.001e-3).voltage.tolist() == [4.0, -6.0]


@pytest.mark.parametrize(("rows", "counts"), [(62, False), (63, True)])
def test_a_hold_that_is_too_short_tells_nothing(rows, counts):
    voltage = np.repeat([1.0, 2.0], [rows, 10])
    assert valve_estimate.holds(voltage, 0.005) == ([slice(60, rows)] if counts else [])


def points(voltage, flow, drop_1, drop_2=None):
    columns = (voltage, flow, drop_1, drop_1 if drop_2 is None else drop_2, np.ones(len(voltage)))
    return Points(*(np.array(column, dtype=float) for column in columns))


def test_a_resistance_is_told_where_the_meter_reads_more_than_its_floor():
    found = valve_estimate.resistance(points([1, 2, -3], [5.09e-5, 5.11e-5, -1e-3], [1e6, 1e6, 4e6]), 5e-5)
    assert math.isnan(found[0])
    assert found[1:] == pytest.approx([1e6 / 5.11e-5**2, 4e12])


def test_a_polynomial_takes_more_points_than_its_degree_and_weighs_them_alike():
    volts = np.array([-2.0, 3.0, 4.0, -5.0, 6.0])
    true = 3.0 - 0.5 * np.abs(volts) + 0.2 * volts**2
    assert valve_estimate.polynomial(volts, true, 2) == pytest.approx([3.0, -0.5, 0.2])
    assert valve_estimate.polynomial(volts[:3], true[:3], 2) == pytest.approx([3.0, -0.5, 0.2])
    assert np.isnan(valve_estimate.polynomial(volts[:2], true[:2], 2)).all()
    assert len(valve_estimate.polynomial(volts[:2], true[:2])) == 6
    hidden = np.where(volts == 4.0, np.nan, true)
    assert valve_estimate.polynomial(volts, hidden, 2) == pytest.approx([3.0, -0.5, 0.2])


def test_flows_are_those_of_the_open_directions_edges():
    full = VALVE.rated_voltage
    given = points([full, -full, 0.5, 0.0], [0.0] * 4, [4e6, 9e6, 4e6, 4e6], [1e6, 2.25e6, 1e6, -1.0])
    one, two = valve_estimate.flows(VALVE, given)
    forward, backward = VALVE.law.forward, VALVE.law.backward
    assert one == pytest.approx(
        [2e3 / math.sqrt(forward.resistance_1), -3e3 / math.sqrt(backward.resistance_1), 0.0, 0.0]
    )
    assert two == pytest.approx(
        [1e3 / math.sqrt(forward.resistance_2), -1.5e3 / math.sqrt(backward.resistance_2), 0.0, 0.0]
    )
    assert forward.resistance_1 == VALVE.minimum_resistance
    assert backward.resistance_1 == 2e12


def test_a_search_begins_with_the_gain_of_openings_beyond_four_fifths():
    full = VALVE.rated_voltage
    given = points(
        [0.81 * full, -0.9 * full, full, 0.79 * full], [1e-3, -1e-3, 1e-3, 1.0], [3e6, 4e6, 5e6, 1.0]
    )
    assert valve_estimate._gain(given, VALVE) == pytest.approx(4e12)
    low = points([0.79 * full], [1e-3], [3e6])
    assert valve_estimate._gain(low, VALVE) == VALVE.minimum_resistance


def test_a_law_is_put_into_the_valve_by_its_names():
    values = dict(zip(valve_estimate.KEYS, (1.1, 1e12, 1.2, 3e12, 0.9), strict=True))
    made = valve_estimate.with_law(VALVE, values)
    assert (made.deadband_voltage, made.minimum_resistance, made.port_2_area) == (1.1, 1e12, 0.9)
    assert made.backward == BackwardValve(1.2, 3e12)
