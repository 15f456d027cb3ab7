"""Claims about oil that is pressed first behind a compensator: of empty ports, under shut holding valves."""

import math
from dataclasses import replace

import pytest
from unlike_ways import with_unlike_ways

from forest_control.valve.inlet_oil import FreeAir, Holding, free_air, holding, lacking_oil, shut_share
from forest_control.valve.load_estimate import Motion, Pressures
from forest_control.valve.valve_driver import REST, step
from forest_control.valve.valve_driver_parameters import Settings, parameters
from forest_control.valve.valve_inverse import PASSES, PRESSING, OilState, required_opening, spool_voltage
from forest_description.hydraulics.load_holding_parameters import PilotCheckValve, RuptureValve
from forest_description.hydraulics.valve_characteristic import opening_at, stroke
from forest_description.machine import load_machine
from forest_sim.hydraulics.oil_law import density, oil_law

FORWARDER = load_machine("forwarder")
P = with_unlike_ways(parameters(FORWARDER, Settings()))
WAYS = pytest.mark.parametrize("way", [1.0, -1.0])


def inlet_flow(i, share, port_1, port_2, outlet=0.0, rocking=0.0):
    """Return the flow into an axis [m^3/s] for a share of its rated speed, at these pressures [Pa]."""
    axis = P.axes[i]
    load = axis.displacement_1 * port_1 - axis.displacement_2 * port_2
    mean = 0.5 * (port_1 + port_2 * axis.displacement_2 / axis.displacement_1)
    oil = OilState(load - rocking, rocking, mean, 20e6, 0.0, outlet)
    volts = spool_voltage(share * axis.valve.forward.rated_voltage, oil, axis.middle, axis, axis.valve, P)
    law = axis.valve.forward if share > 0.0 else axis.valve.backward
    edge = law.resistance_1 if share > 0.0 else law.resistance_2
    return opening_at(stroke(abs(volts), law), axis.valve.curve) * math.sqrt(axis.metering_drop / edge)


@pytest.mark.parametrize(("i", "way"), [(1, -1.0), (2, 1.0), (2, -1.0)])
def test_a_piston_between_two_springs_of_oil_moves_as_commanded(i, way):
    """Its outlet is shut: both chambers are pressed until the flow has moved it as far as was asked."""
    axis, share = P.axes[i], 0.02 * way
    flow, dt, steps = inlet_flow(i, share, 8e6, 8e6), 1e-4, 100
    c = [oil.fixed + oil.growing * axis.middle for oil in (axis.oil_1, axis.oil_2)]
    areas = (axis.displacement_1, axis.displacement_2)
    a, b = (0, 1) if way > 0.0 else (1, 0)
    # The load's force stays: A_a dP_a = A_b dP_b, while dV_a = q dt - A_a dx and dV_b = A_b dx.
    x = 0.0
    for _ in range(steps):
        x += flow * dt * areas[a] / c[a] / (areas[a] ** 2 / c[a] + areas[b] ** 2 / c[b])
    assert x == pytest.approx(abs(share) * axis.rated_speed * dt * steps, rel=1e-9)


@pytest.mark.parametrize(("i", "way"), [(1, -1.0), (2, 1.0), (2, -1.0)])
@pytest.mark.parametrize("rocking", [0.0, 3e4])
def test_a_holding_valve_that_is_half_open_by_its_ports_counts_half(i, way, rocking):
    """Whatever part of the load is its mean: what the ports bear now opens the valve."""
    axis = P.axes[i]
    held = axis.holding_2 if way > 0.0 else axis.holding_1
    inlet = 4e6
    outlet = (held.reseat * (1.0 - 0.5 * 0.25) - held.pilot * inlet) / held.load
    ports = (inlet, outlet) if way > 0.0 else (outlet, inlet)
    c_1, c_2 = (oil.fixed + oil.growing * axis.middle for oil in (axis.oil_1, axis.oil_2))
    k_1, k_2 = axis.displacement_1**2 / c_1, axis.displacement_2**2 / c_2
    area, ratio = (axis.displacement_1, k_2 / k_1) if way > 0.0 else (axis.displacement_2, k_1 / k_2)
    told = 0.05 * axis.rated_speed * area * (1.0 + 0.5 * ratio)
    assert inlet_flow(i, 0.05 * way, *ports, rocking=rocking) == pytest.approx(told, rel=1e-9)


def test_a_stick_whose_holding_valves_differ_asks_the_one_at_its_outlet(monkeypatch):
    stick = P.axes[2]
    for way, other in ((1.0, {"holding_1": Holding()}), (-1.0, {"holding_2": Holding()})):
        flows = []
        for axis in (stick, stick._replace(**other)):
            monkeypatch.setitem(globals(), "P", P._replace(axes=(*P.axes[:2], axis)))
            flows.append(inlet_flow(2, 0.05 * way, 4e6, 4e6))
        assert flows[0] == flows[1]


@WAYS
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_oil_comes_back_from_half_the_metering_drop_on(way, share):
    """At the valve, where both edges pass the same."""
    axis, moved = P.axes[2], 0.05 * P.axes[2].rated_speed
    area = axis.displacement_1 if way > 0.0 else axis.displacement_2
    flow = inlet_flow(2, 0.05 * way, 4e6, 4e6, share * 0.5 * axis.metering_drop)
    assert (flow == pytest.approx(moved * area, rel=1e-9)) == (share > 1.0)
    assert PASSES == 0.5


@pytest.mark.parametrize("i", [0, 1, 2])
def test_no_compensated_valve_is_opened_further_than_it_goes(i):
    for speed, whole in ((10.0, 1.0), (-10.0, -1.0)):
        assert required_opening(speed, 0.0, 20e6, 0.0, P.axes[i], P) == whole


@WAYS
@pytest.mark.parametrize("i", [0, 1, 2])
def test_oil_that_is_pressed_and_an_outlet_that_is_open_take_the_actuators_flow_alone(i, way):
    axis = P.axes[i]
    area = axis.displacement_1 if way > 0.0 else axis.displacement_2
    assert inlet_flow(i, 0.1 * way, 13e6, 13e6) == pytest.approx(0.1 * axis.rated_speed * area, rel=1e-9)


@pytest.mark.parametrize(("i", "way"), [(1, -1.0), (2, 1.0), (2, -1.0)])
@pytest.mark.parametrize("outlet", [2e6, math.nan])
def test_a_dead_transducer_at_a_cylinder_makes_it_no_faster(i, way, outlet):
    """Its pressures say that the holding valve is shut; yet oil comes back, or nothing is measured there."""
    axis = P.axes[i]
    area = axis.displacement_1 if way > 0.0 else axis.displacement_2
    assert inlet_flow(i, 0.1 * way, 4e6, 4e6, outlet) == pytest.approx(
        0.1 * axis.rated_speed * area, rel=1e-9
    )
    assert inlet_flow(i, 0.1 * way, 4e6, 4e6) > 0.12 * axis.rated_speed * area


@WAYS
@pytest.mark.parametrize("command", [0.5, 2.0])
def test_the_driver_looks_at_the_port_where_the_oil_comes_back(way, command):
    """The stick has a holding valve at either port."""
    volts = []
    for back in (0.0, 3e6):
        at = ((1e7,) * 3, (back,) * 3) if way > 0.0 else ((back,) * 3, (1e7,) * 3)
        motion = Motion(tuple(axis.middle for axis in P.axes), *at)
        ports = Pressures((4e6,) * 3, (4e6,) * 3, 20e6)
        volts.append(step(REST, (0.0, 0.0, command * way), ports, motion, P, 0.0)[0].voltages[2] * way)
    assert volts[0] > volts[1] > 0.0


def test_a_counterbalance_valve_is_open_from_where_load_and_pilot_together_reseat_it():
    valve = holding(FORWARDER.boom.holding_1)
    assert valve == Holding(24e6, 1.0, 1.0)
    assert shut_share(12e6, 12e6, valve) == 0.0
    assert shut_share(12e6 - 6e6, 12e6, valve) == 1.0
    assert shut_share(9e6, 12e6, valve) == shut_share(12e6, 9e6, valve) == pytest.approx(0.5)


def test_between_reseating_and_a_quarter_of_it_a_holding_valve_is_partly_shut():
    valve = Holding(20e6, 1.0, 2.0)
    for lacking, share in ((-1.0, 0.0), (0.0, 0.0), (1.0, 2e-7), (2.5e6, 0.5), (5e6, 1.0), (9e6, 1.0)):
        assert shut_share(4e6, 12e6 - lacking, valve) == pytest.approx(share, rel=1e-9, abs=1e-12)
    assert Holding() == (-math.inf, 1.0, 0.0)
    assert FreeAir() == (0.0, 1e5, 0.0)


def test_a_pilot_check_is_shut_by_its_load_and_opened_by_its_pilot():
    check = PilotCheckValve(
        setting=5e5,
        pilot_ratio=4.0,
        hysteresis=1e5,
        opening_range=1e6,
        minimum_resistance=1e11,
        check_resistance=1e11,
        response_time=0.01,
    )
    valve = holding(check)
    assert shut_share(0.0, 10e6, valve) == 1.0
    assert shut_share(3e6, 10e6, valve) == 0.0  # 4 * 3 - 10 MPa is over 0.4
    assert shut_share(2e6, 8e6, valve) == 1.0  # 4 * 2 - 8 MPa is under 0.3


@pytest.mark.parametrize(
    "valve", [None, RuptureValve(closing_flow=1e-3, minimum_resistance=1e10, response_time=0.01)]
)
def test_a_port_without_a_valve_that_holds_its_load_is_open(valve):
    assert shut_share(0.0, 0.0, holding(valve)) == 0.0


@pytest.mark.parametrize("pressure", [0.0, 2e5, 8e5])
def test_what_presses_the_air_is_what_the_simulators_oil_gives_way(pressure):
    """Beside it the law here lets no air dissolve: within a third of what is left."""
    air, law = free_air(FORWARDER, 0), oil_law(FORWARDER.oil)
    c_of_oil = 1.0 / FORWARDER.oil.bulk_modulus
    room = [1.0 / density(p, law).ratio for p in (pressure, air.loose)]
    given_way = room[0] - room[1] - c_of_oil * (air.loose - pressure)
    assert c_of_oil * lacking_oil(pressure, air) == pytest.approx(given_way, rel=0.35, abs=2e-5)


def test_air_that_is_pressed_lacks_nothing_and_oil_without_air_never_does():
    air = free_air(FORWARDER, 0)
    assert air.loose == pytest.approx(1300.0 / P.axes[0].displacement_1)
    assert free_air(FORWARDER, 2).loose == pytest.approx(2400.0 / P.axes[2].displacement_2)
    assert lacking_oil(air.loose, air) == lacking_oil(5e6, air) == 0.0
    assert lacking_oil(-1e5, air) == lacking_oil(0.0, air) > 0.0
    assert free_air(replace(FORWARDER, oil=replace(FORWARDER.oil, air=None)), 0) == FreeAir()
    smooth = replace(FORWARDER, swing=replace(FORWARDER.swing, friction=None))
    assert free_air(smooth, 0) == air._replace(loose=0.0)


@WAYS
def test_an_empty_swing_gets_its_air_pressed_in_the_stated_time_and_one_that_brakes_nothing(way):
    axis = P.axes[0]
    area, share = axis.displacement_1, 0.01 * way
    lacking = (axis.oil_1 if way > 0.0 else axis.oil_2).fixed * lacking_oil(0.0, axis.air)
    moved = abs(share) * axis.rated_speed * area
    assert PRESSING == 0.1
    assert inlet_flow(0, share, 0.0, 0.0) == pytest.approx(moved + lacking / 0.1, rel=1e-6)
    braking = (0.0, 6e6) if way > 0.0 else (6e6, 0.0)
    assert inlet_flow(0, share, *braking) == pytest.approx(moved, rel=1e-6)
