"""Claims about oil that is pressed first behind a compensator: of empty ports, under shut holding valves."""

import math
from dataclasses import replace

import pytest

from forest_control.valve import valve_driver_parameters
from forest_control.valve.inlet_oil import FreeAir, Holding, free_air, holding, lacking_oil, shut_share
from forest_control.valve.valve_driver import REST, Motion, Pressures, step
from forest_control.valve.valve_driver_parameters import Settings, parameters
from forest_control.valve.valve_inverse import PRESSING, OilState, spool_voltage
from forest_description.hydraulics.load_holding_parameters import PilotCheckValve, RuptureValve
from forest_description.hydraulics.valve_characteristic import opening_at, stroke
from forest_description.machine import load_machine
from forest_sim.hydraulics.oil_law import density, oil_law
from forest_study.notebook import closed_loop

FORWARDER = load_machine("forwarder")
P = parameters(FORWARDER, Settings())
WAYS = pytest.mark.parametrize("way", [1.0, -1.0])


def inlet_flow(i, share, port_1, port_2, outlet=0.0):
    """Return the flow into an axis [m^3/s] for a share of its rated speed, at these pressures [Pa]."""
    axis = P.axes[i]
    load = axis.displacement_1 * port_1 - axis.displacement_2 * port_2
    mean = 0.5 * (port_1 + port_2 * axis.displacement_2 / axis.displacement_1)
    oil = OilState(load, 0.0, mean, 20e6, 0.0, outlet)
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
def test_the_driver_looks_at_the_port_where_the_oil_comes_back(way):
    """The stick has a holding valve at either port."""
    volts = []
    for back in (0.0, 3e6):
        at = ((1e7,) * 3, (back,) * 3) if way > 0.0 else ((back,) * 3, (1e7,) * 3)
        motion = Motion(tuple(axis.middle for axis in P.axes), *at)
        ports = Pressures((4e6,) * 3, (4e6,) * 3, 20e6)
        volts.append(step(REST, (0.0, 0.0, 2.0 * way), ports, motion, P, 0.0)[0].voltages[2] * way)
    assert volts[0] > volts[1] > 0.0


def test_a_counterbalance_valve_is_open_from_where_load_and_pilot_together_reseat_it():
    valve = holding(FORWARDER.boom.holding_1)
    assert valve == Holding(24e6, 1.0, 1.0)
    assert shut_share(12e6, 12e6, valve) == 0.0
    assert shut_share(12e6 - 6e6, 12e6, valve) == 1.0
    assert shut_share(9e6, 12e6, valve) == shut_share(12e6, 9e6, valve) == pytest.approx(0.5)


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


@WAYS
def test_an_empty_swing_gets_its_air_pressed_in_the_stated_time_and_one_that_brakes_nothing(way):
    axis = P.axes[0]
    area, share = axis.displacement_1, 0.01 * way
    lacking = (axis.oil_1 if way > 0.0 else axis.oil_2).fixed * lacking_oil(0.0, axis.air)
    moved = abs(share) * axis.rated_speed * area
    assert inlet_flow(0, share, 0.0, 0.0) == pytest.approx(moved + lacking / PRESSING, rel=1e-6)
    braking = (0.0, 6e6) if way > 0.0 else (6e6, 0.0)
    assert inlet_flow(0, share, *braking) == pytest.approx(moved, rel=1e-6)


def test_pressed_oil_takes_a_third_of_what_the_tip_of_a_forwarder_falls_behind_by(monkeypatch):
    """Its swing's ports are empty, and its stick's valve is opened by 13 MPa."""

    def furthest():
        path = [(6.0, 0.0, 0.5), (6.0, 1.5, 0.5)]
        return closed_loop("forwarder").follow(path, speed=0.5).score.governed_max_mm

    pressed = furthest()
    monkeypatch.setattr(valve_driver_parameters, "free_air", lambda *_: FreeAir())
    monkeypatch.setattr(valve_driver_parameters, "holding", lambda _: Holding())
    assert furthest() > 1.5 * pressed
