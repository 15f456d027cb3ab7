"""Claims about valves beyond the thesis' one: centres, directions, ports, measured curves."""

import math
from dataclasses import replace

import numpy as np
import pytest

from forest_description.config.parameter import MachineError
from forest_description.hydraulics.valve_characteristic import CURVE_SIZE, edges, voltage_for_opening
from forest_description.hydraulics.valve_parameters import (
    BackwardValve,
    FlowCurve,
    PolynomialCurve,
    TableCurve,
)
from forest_description.machine import load_machine

VALVE = load_machine("c180_hoses").valve
C_R = VALVE.minimum_resistance
VOLTS, MEASURED = (1.5, 2.0, 4.0, 7.0, 10.0), (4e15, 3e14, 9e12, 2e12, 8e11)
TABLE = replace(VALVE, curve=TableCurve(VOLTS, MEASURED))
FALLING = (121.0, -22.0, 1.0)  # (11 - V)^2
POLYNOMIAL = replace(VALVE, curve=PolynomialCurve(FALLING))
UNDERLAPPED = replace(VALVE, deadband_voltage=-0.5)
CRITICAL = replace(VALVE, deadband_voltage=0.0)
ASYMMETRIC = replace(VALVE, backward=BackwardValve(1.8, 3e12))
SORTS = {
    "linear": VALVE,
    "table": TABLE,
    "polynomial": POLYNOMIAL,
    "underlapped": UNDERLAPPED,
    "underlapped table": replace(TABLE, deadband_voltage=-0.5),
    "critical": CRITICAL,
    "asymmetric": ASYMMETRIC,
    "unequal ports": replace(VALVE, port_2_area=0.7),
}
each_sort = pytest.mark.parametrize("valve", SORTS.values(), ids=SORTS)


def conductances(voltage, valve):
    """1/sqrt(C_R) of the four edges, over that of the whole opening: supply 1, tank 1, supply 2, tank 2."""
    return np.sqrt(C_R / np.array(edges(voltage, valve.law)))


def net_opening(voltage, valve):
    """By how much more port 1 is open to the supply than to the tank, each over its own whole opening."""
    law, e = valve.law, edges(voltage, valve.law)
    ahead = math.sqrt(law.forward.resistance_1 / e.supply_1)
    return ahead - math.sqrt(law.backward.resistance_1 / e.tank_1)


def test_an_overlapped_centre_is_shut_and_an_underlapped_one_open_all_round():
    assert edges(0.0, VALVE.law) == (math.inf,) * 4
    assert edges(0.0, CRITICAL.law) == (math.inf,) * 4
    assert edges(1e-6, CRITICAL.law).supply_1 < math.inf
    assert np.ptp(edges(0.0, UNDERLAPPED.law)) == 0.0
    assert conductances(0.0, UNDERLAPPED) == pytest.approx(0.5 / 10.5)


@pytest.mark.parametrize(("valve", "edges_at_work"), [(VALVE, 0), (CRITICAL, 1), (UNDERLAPPED, 2)])
def test_flow_gain_at_the_centre_is_nothing_one_edges_or_twice_that(valve, edges_at_work):
    """Thesis fig. 2.5."""
    h = 0.1
    gain = (net_opening(h, valve) - net_opening(-h, valve)) / (2.0 * h)
    assert gain == pytest.approx(edges_at_work / (10.0 - valve.deadband_voltage))


def test_beyond_its_underlap_a_valve_works_with_one_edge():
    assert edges(0.5, UNDERLAPPED.law).tank_1 == math.inf
    assert edges(0.49, UNDERLAPPED.law).tank_1 < math.inf
    assert conductances(4.75, UNDERLAPPED) == pytest.approx([0.5, 0.0, 0.0, 0.5])


def test_each_direction_has_its_own_overlap_and_gain():
    assert edges(1.5, ASYMMETRIC.law).supply_1 < math.inf
    assert edges(-1.5, ASYMMETRIC.law) == (math.inf,) * 4
    forward, backward = edges(10.0, ASYMMETRIC.law), edges(-10.0, ASYMMETRIC.law)
    assert (forward.supply_1, forward.tank_2) == (C_R, C_R)
    assert (backward.supply_2, backward.tank_1) == (3e12, 3e12)
    assert edges(-5.9, ASYMMETRIC.law).tank_1 == pytest.approx(4.0 * 3e12)


def test_the_edges_of_port_2_differ_by_the_square_of_their_area():
    for voltage in (10.0, 4.0, -4.0):
        e = edges(voltage, SORTS["unequal ports"].law)
        one, two = min(e.supply_1, e.tank_1), min(e.supply_2, e.tank_2)
        assert two == pytest.approx(one / 0.7**2, rel=1e-12)


def test_a_table_gives_back_what_was_measured_in_proportion():
    for volts, c_r in zip(VOLTS, MEASURED, strict=True):
        assert edges(volts, TABLE.law).supply_1 == pytest.approx(C_R * c_r / MEASURED[-1], rel=1e-12)
        assert edges(-volts, TABLE.law).supply_2 == pytest.approx(C_R * c_r / MEASURED[-1], rel=1e-12)
    between = 0.5 * (conductances(4.0, TABLE)[0] + conductances(7.0, TABLE)[0])
    assert conductances(5.5, TABLE)[0] == pytest.approx(between, rel=1e-12)
    assert conductances(1.25, TABLE)[0] == pytest.approx(0.5 * conductances(1.5, TABLE)[0], rel=1e-12)
    assert edges(1.0, TABLE.law).supply_1 == math.inf


def test_a_flow_curve_opens_in_proportion_to_its_flow():
    flows = (1e-5, 2e-4, 4e-4, 8e-4, 1.6e-3)
    valve = replace(VALVE, curve=FlowCurve(VOLTS, flows))
    for volts, flow in zip(VOLTS, flows, strict=True):
        assert conductances(volts, valve)[0] == pytest.approx(flow / flows[-1], rel=1e-12)
    drop = 7e5  # [Pa]: the resistances that these flows stand for make the same valve
    table = TableCurve(VOLTS, tuple(drop / flow**2 for flow in flows))
    for volts in np.linspace(-11.0, 11.0, 89):
        assert conductances(volts, valve) == pytest.approx(conductances(volts, replace(valve, curve=table)))


@pytest.mark.parametrize(
    ("flows", "told"),
    [
        ((1e-3,), r"curve.voltages \(5\) and curve.flows \(1\) must be equally many"),
        ((1e-4, 2e-4, 1e-4, 3e-4, 4e-4), "curve.flows must rise with the voltage"),
    ],
)
def test_a_flow_curve_that_cannot_be_is_refused(flows, told):
    with pytest.raises(MachineError, match=told):
        replace(VALVE, curve=FlowCurve(VOLTS, flows))


def test_a_polynomial_gives_back_its_resistance_in_proportion():
    for volts in np.linspace(1.001, 10.0, 50):
        assert edges(volts, POLYNOMIAL.law).supply_1 == pytest.approx(C_R * (11.0 - volts) ** 2, rel=1e-9)
    assert edges(1.0, POLYNOMIAL.law).supply_1 == math.inf
    scaled = replace(VALVE, curve=PolynomialCurve(tuple(7e11 * c for c in FALLING)))
    assert edges(3.0, scaled.law).supply_1 == pytest.approx(edges(3.0, POLYNOMIAL.law).supply_1, rel=1e-12)


@each_sort
def test_more_voltage_never_opens_less(valve):
    openings = [net_opening(v, valve) for v in np.linspace(-11.0, 11.0, 441)]
    assert np.all(np.diff(openings) >= -1e-12)
    assert (openings[0], openings[-1]) == pytest.approx((-1.0, 1.0))
    inner = [e for v in np.linspace(-10.0, 10.0, 401) for e in edges(v, valve.law) if e < math.inf]
    assert min(inner) >= min(valve.law.forward[2:] + valve.law.backward[2:]) * (1 - 1e-12)


@each_sort
def test_voltage_for_opening_inverts_the_opening_both_ways(valve):
    least = 0.1 if valve is POLYNOMIAL else 0.0  # its opening begins with a tenth
    for wished in np.random.default_rng(4).uniform(-1.0, 1.0, 200).tolist():
        if abs(wished) > least:
            assert net_opening(voltage_for_opening(wished, valve.law), valve) == pytest.approx(
                wished, abs=1e-12
            )
    assert voltage_for_opening(2.0, valve.law) == pytest.approx(10.0)
    assert voltage_for_opening(-2.0, valve.law) == pytest.approx(-10.0)
    assert voltage_for_opening(0.0, valve.law) == 0.0
    assert voltage_for_opening(math.nan, valve.law) == 0.0


def test_a_small_opening_of_an_underlapped_valve_is_a_small_voltage_of_its_sign():
    """With one direction's edge inverted alone, it would be almost the whole underlap of the wrong sign."""
    for wished in (1e-3, -1e-3, 1e-6):
        voltage = voltage_for_opening(wished, UNDERLAPPED.law)
        assert voltage == pytest.approx(wished * 10.5 / 2.0, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"curve": TableCurve((2.0, 10.0), (1e13,))}, r"curve.voltages \(2\) and curve.resistances \(1\)"),
        ({"curve": TableCurve((2.0, 9.0), (1e13, 1e12))}, "to rated_voltage"),
        ({"curve": TableCurve((1.0, 10.0), (1e13, 1e12))}, "from above deadband_voltage"),
        ({"curve": TableCurve((3.0, 2.0, 10.0), (1e13, 1e13, 1e12))}, "curve.voltages must rise"),
        ({"curve": TableCurve((2.0, 10.0), (1e12, 1e13))}, "curve.resistances must fall"),
        ({"curve": PolynomialCurve((1.0, 1.0))}, "C_R must be positive and fall"),
        ({"curve": PolynomialCurve((5.0, -1.0))}, "C_R must be positive and fall"),
        ({"curve": PolynomialCurve((1e3, *[-1e-11] * CURVE_SIZE))}, "curve.coefficients: 1 too many"),
        ({"deadband_voltage": 5.0, "rated_voltage": 4.0}, "deadband_voltage .* rated_voltage"),
        ({"backward": BackwardValve(5.0, 1e12), "rated_voltage": 4.0}, r"backward\.deadband_voltage \(5 V\)"),
        ({"port_2_area": 0.0}, r"Valve\.port_2_area: 0 is outside"),
        ({"leakage_conductance": -1e-12}, r"Valve\.leakage_conductance"),
        ({"spool_damping": 0.0}, r"Valve\.spool_damping"),
    ],
)
def test_what_does_not_fit_is_refused_by_its_name(change, message):
    with pytest.raises(MachineError, match=message):
        replace(VALVE, **change)


def test_the_longest_curves_fit():
    volts = tuple(np.linspace(1.5, 10.0, CURVE_SIZE - 1).tolist())
    full = replace(VALVE, curve=TableCurve(volts, tuple(1e12 * (10.0 / v) ** 2 for v in volts)))
    assert edges(volts[4], full.law).supply_1 == pytest.approx(C_R * (10.0 / volts[4]) ** 2)
    one_more = tuple(np.linspace(1.5, 10.0, CURVE_SIZE).tolist())
    with pytest.raises(MachineError, match="voltages: 1 too many; a curve has at most 12 places"):
        replace(VALVE, curve=TableCurve(one_more, tuple(1e12 / v for v in one_more)))


@pytest.mark.parametrize("value", [(), 3.0, (1.0, "x"), (math.nan,), (1.0, True)])
def test_a_row_of_numbers_must_be_one(value):
    with pytest.raises(MachineError, match=r"PolynomialCurve\.coefficients: "):
        PolynomialCurve(value)


def test_a_single_number_cannot_be_a_row():
    with pytest.raises(MachineError, match=r"Valve\.rated_voltage: \(10\.0,\) is not a finite number"):
        replace(VALVE, rated_voltage=(10.0,))
