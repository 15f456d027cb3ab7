"""Claims about the valve's inverse: at the opening it gives, the oil's pressures balance."""

import math
from pathlib import Path

import pytest
from unlike_ways import with_unlike_ways

from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.load_estimate import STILL, UNSEEN
from forest_control.valve.valve_driver import REST
from forest_control.valve.valve_driver_parameters import Settings
from forest_control.valve.valve_inverse import (
    LEAST_DROP,
    LEAST_PART,
    OilState,
    required_opening,
    spool_voltage,
)
from forest_description.hydraulics.valve_characteristic import opening_at, stroke
from forest_description.machine import load_machine

REAL = load_machine("c180")
PLAIN = load_machine(str(Path(__file__).parents[3] / "docs/studies/plain_sections.yaml"))
P = with_unlike_ways(valve_driver_parameters.parameters(REAL, Settings()))
SUPPLY, TANK = 17e6, 6e5
MACHINES = (PLAIN, REAL, load_machine("forwarder"))
AXES = pytest.mark.parametrize("i", [0, 1, 2])
SPEEDS = pytest.mark.parametrize("share", [-0.4, -0.1, 0.1, 0.4])


def flows(i, speed, at, p_1, p_2):
    """Speeds [m/s; rad/s] that the flows over edge 1 and 2 would move the actuator at."""
    axis = P.axes[i]
    way = axis.valve.forward if speed > 0.0 else axis.valve.backward
    drop_1, drop_2 = (SUPPLY - p_1, p_2 - TANK) if speed > 0.0 else (p_1 - TANK, SUPPLY - p_2)
    one = at * math.sqrt(drop_1 / way.resistance_1) / axis.displacement_1
    two = at * math.sqrt(drop_2 / way.resistance_2) / axis.displacement_2
    return one, two


def loss(valve, area, speed, inwards):
    """Pressure [Pa] over a holding valve that is open."""
    if valve is None:
        return 0.0
    return (valve.check_resistance if inwards else valve.minimum_resistance) * (area * speed) ** 2


@AXES
@SPEEDS
def test_edges_hoses_holding_valves_and_tank_line_take_what_the_load_leaves(i, share):
    axis, drive = P.axes[i], REAL.drives[i]
    speed, load = share * axis.rated_speed, 0.2 * axis.displacement_1 * SUPPLY
    at = abs(required_opening(speed, load, SUPPLY, TANK, axis, P))
    way = axis.valve.forward if speed > 0.0 else axis.valve.backward
    along = []
    for port, resistance in ((1, way.resistance_1), (2, way.resistance_2)):
        area, line = (axis.displacement_1, axis.displacement_2)[port - 1], REAL.line(i, port)
        flow, turbulent = area * abs(speed), drive.flow_regime == "turbulent"
        hose = line.resistance * (flow * flow if turbulent else flow)
        inwards = (port == 1) == (speed > 0.0)
        held = loss((drive.holding_1, drive.holding_2)[port - 1], area, speed, inwards)
        along.append(resistance * (flow / at) ** 2 + hose + held)
    if speed > 0.0:
        force = axis.displacement_1 * (SUPPLY - along[0]) - axis.displacement_2 * (TANK + along[1])
    else:
        force = axis.displacement_1 * (TANK + along[0]) - axis.displacement_2 * (SUPPLY - along[1])
    assert force == pytest.approx(load, rel=1e-9)


@AXES
@SPEEDS
@pytest.mark.parametrize("place", [0.1, 0.9])
@pytest.mark.parametrize("pressed", [0.3, 0.8])
def test_while_the_oil_is_pressed_the_edges_move_the_springs_ends_as_commanded(i, share, place, pressed):
    """The mean of both flows, weighted by the springs of oil on either side of the piston."""
    axis = P.axes[i]._replace(hose_linear=0.0, ahead_square=0.0, back_square=0.0)
    load, position = 0.1 * axis.displacement_1 * SUPPLY, axis.middle
    if i > 0:
        drive = REAL.drives[i]
        position = drive.retracted_length + place * drive.stroke
    p_1 = pressed * 0.7 * SUPPLY
    p_2 = (axis.displacement_1 * p_1 - load) / axis.displacement_2
    mean = 0.5 * (p_1 + p_2 * axis.displacement_2 / axis.displacement_1)
    fed = share * axis.valve.forward.rated_voltage
    volts = spool_voltage(fed, OilState(load, 0.0, mean, SUPPLY, TANK), position, axis, axis.valve, P)
    way = axis.valve.forward if share > 0.0 else axis.valve.backward
    one, two = flows(i, share, opening_at(stroke(abs(volts), way), axis.valve.curve), p_1, p_2)
    c_1 = axis.oil_1.fixed + axis.oil_1.growing * position
    c_2 = axis.oil_2.fixed + axis.oil_2.growing * position
    k_1, k_2 = axis.displacement_1**2 / c_1, axis.displacement_2**2 / c_2
    speed = (k_1 * one + k_2 * two) / (k_1 + k_2)
    assert speed == pytest.approx(abs(share) * axis.rated_speed, rel=1e-9)


@pytest.mark.parametrize("i", [1, 2])
def test_the_oil_of_a_cylinder_is_what_the_its_dimensions_say(i):
    """Its capacitance at rest, from dead volumes, stroke and bulk modulus."""
    drive, axis, modulus = REAL.drives[i], P.axes[i], REAL.oil.bulk_modulus
    for place in (0.0, 0.3, 1.0):
        x = drive.retracted_length + place * drive.stroke
        head = drive.chambers.head_dead_volume + drive.head_area * place * drive.stroke
        rod = drive.chambers.rod_dead_volume + drive.rod_area * (1.0 - place) * drive.stroke
        one, two = (REAL.line(i, port).capacitance for port in (1, 2))
        assert axis.oil_1.fixed + axis.oil_1.growing * x == pytest.approx(one + head / modulus)
        assert axis.oil_2.fixed + axis.oil_2.growing * x == pytest.approx(two + rod / modulus)


def test_the_tank_lines_pressure_is_that_of_all_the_oil_that_returns():
    """Driven against a preload alone, each axis' voltage is the one under that pressure."""
    swing, boom, stick = P.axes
    law = swing.valve._replace(backward=swing.valve.backward._replace(rated_voltage=7.0))
    stick = stick._replace(displacement_1=0.012, displacement_2=0.008)
    p = P._replace(axes=(swing._replace(valve=law), boom, stick))
    commands, line = (2.0, -3.0, 5.0), REAL.tank_line
    speeds = [axis.rated_speed * c / 10.0 for axis, c in zip(p.axes, commands, strict=True)]
    flow = speeds[0] * swing.displacement_2 - speeds[1] * boom.displacement_1
    flow += speeds[2] * stick.displacement_2
    tank = line.preload + line.resistance * flow**2
    _, volts = valve_driver.step(REST, commands, UNSEEN, STILL, p, 0.0)
    for i, given in enumerate(volts):
        axis = p.axes[i]
        oil = OilState(0.0, 0.0, -1.0, P.idle_pressure, tank)
        wanted = spool_voltage(commands[i], oil, math.nan, axis, axis.valve, p)
        assert given == pytest.approx(wanted)  # dither begins at a node


def test_only_behind_a_load_sensing_pump_and_without_compensators_a_counterbalance_valve_throttles():
    """At the boom's head side and both of the stick's; a pump of constant pressure opens it wide."""
    told = [
        [(a.throttled_1, a.throttled_2) for a in valve_driver_parameters.axis_drivers(m)] for m in MACHINES
    ]
    assert told == [[(False, False), (True, False), (True, True)], 3 * [(False, False)], 3 * [(False, False)]]


@pytest.mark.parametrize(("i", "share"), [(1, -0.3), (2, -0.3), (2, 0.3)])
@pytest.mark.parametrize("held", [2e6, 14e6])
def test_where_a_counterbalance_valve_throttles_the_inlets_edge_alone_sets_the_speed(i, share, held):
    """Whatever stands before the valve, the flow of the inlet's measured drop is that of the speed."""
    p = with_unlike_ways(valve_driver_parameters.parameters(PLAIN, Settings()))
    axis, supply, inlet = p.axes[i], 9e6, 6.5e6
    p_1, p_2 = (inlet, held) if share > 0.0 else (held, inlet)
    load = axis.displacement_1 * p_1 - axis.displacement_2 * p_2
    mean = 0.5 * (p_1 + p_2 * axis.displacement_2 / axis.displacement_1)
    fed = share * axis.valve.forward.rated_voltage
    volts = spool_voltage(fed, OilState(load, 0.0, mean, supply, TANK), axis.middle, axis, axis.valve, p)
    way = axis.valve.forward if share > 0.0 else axis.valve.backward
    edge, area = (
        (way.resistance_1, axis.displacement_1) if share > 0.0 else (way.resistance_2, axis.displacement_2)
    )
    at = math.copysign(opening_at(stroke(abs(volts), way), axis.valve.curve), volts)
    assert at * math.sqrt((supply - inlet) / edge) == pytest.approx(share * axis.rated_speed * area, rel=1e-9)


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_a_boom_that_rises_heeds_what_its_outlet_leaves(share):
    """Only its head side has a counterbalance valve: what leaves the rod's does so over the edge."""
    p = with_unlike_ways(valve_driver_parameters.parameters(PLAIN, Settings()))
    axis, volts = p.axes[1], []
    for outlet in (1e6, 4e6):
        load = axis.displacement_1 * 5e6 - axis.displacement_2 * outlet
        mean = 0.5 * (5e6 + outlet * axis.displacement_2 / axis.displacement_1)
        fed, oil = share * axis.valve.forward.rated_voltage, OilState(load, 0.0, mean, 9e6, TANK)
        volts.append(spool_voltage(fed, oil, axis.middle, axis, axis.valve, p))
    assert abs(volts[0] - volts[1]) > 0.01 * volts[0]


@pytest.mark.parametrize("share", [-0.05, 0.05])
def test_an_inlet_at_the_pumps_pressure_is_taken_to_leave_a_little(share):
    """So that a dead transducer opens the valve by a bounded part: 3 % of the pump's pressure remain."""
    p = with_unlike_ways(valve_driver_parameters.parameters(PLAIN, Settings()))
    axis, fed = p.axes[2], share * p.axes[2].valve.forward.rated_voltage
    speed = share * axis.rated_speed

    def asked(inlet):
        p_1, p_2 = (inlet, 5e6) if share > 0.0 else (5e6, inlet)
        load = axis.displacement_1 * p_1 - axis.displacement_2 * p_2
        mean = 0.5 * (p_1 + p_2 * axis.displacement_2 / axis.displacement_1)
        return spool_voltage(fed, OilState(load, 0.0, mean, 9e6, TANK), axis.middle, axis, axis.valve, p)

    assert LEAST_DROP == 0.03
    left = 9e6 - 0.03 * p.supply_pressure
    assert asked(left) == pytest.approx(asked(20e6))
    assert abs(asked(left - 1e6)) < abs(asked(left))
    way = axis.valve.forward if share > 0.0 else axis.valve.backward
    edge, area = (
        (way.resistance_1, axis.displacement_1) if share > 0.0 else (way.resistance_2, axis.displacement_2)
    )
    at = math.copysign(opening_at(stroke(abs(asked(20e6)), way), axis.valve.curve), share)
    assert at * math.sqrt(0.03 * p.supply_pressure / edge) == pytest.approx(speed * area, rel=1e-9)


def one_sided(i, share, soft):
    """Return an axis without hoses, whose oil on the inlet's or the outlet's side is no spring."""
    axis = P.axes[i]._replace(hose_linear=0.0, ahead_square=0.0, back_square=0.0)
    oil = axis.oil_1._replace(fixed=1e9)
    return axis._replace(oil_1=oil) if (soft == "inlet") == (share > 0.0) else axis._replace(oil_2=oil)


def opened(axis, share, load, mean, tank=0.0):
    """Return the opening for a share of the rated speed."""
    fed = share * axis.valve.forward.rated_voltage
    volts = spool_voltage(fed, OilState(load, 0.0, mean, SUPPLY, tank), axis.middle, axis, axis.valve, P)
    way = axis.valve.forward if share > 0.0 else axis.valve.backward
    return opening_at(stroke(abs(volts), way), axis.valve.curve)


@AXES
@pytest.mark.parametrize("share", [-0.01, 0.01])
@pytest.mark.parametrize(("soft", "impossible"), [("outlet", 90e6), ("inlet", 0.0)])
def test_ports_that_leave_no_drop_open_the_valve_ten_times_as_far_at_the_most(i, share, soft, impossible):
    """Full, they leave the inlet's edge none; empty, the outlet's."""
    axis = one_sided(i, share, soft)
    assert opened(axis, share, 0.0, impossible) == pytest.approx(
        opened(axis, share, 0.0, -1.0) / LEAST_PART, rel=1e-6
    )
    assert LEAST_PART == 0.1


@AXES
@pytest.mark.parametrize("share", [-0.01, 0.01])
def test_under_a_load_beyond_the_pump_a_tenth_of_its_pressure_is_taken_to_remain(i, share):
    """The inlet's share of it is what its edge usually has; the port leaves it 2 MPa."""
    axis = one_sided(i, share, "outlet")
    area, drop = axis.displacement_1 if share > 0.0 else axis.displacement_2, 2e6
    load = math.copysign(0.95 * area * SUPPLY, share)
    inlet = (SUPPLY - drop) * area / axis.displacement_1  # at the mean's scale
    mean = inlet - 0.5 * abs(load) / axis.displacement_1
    way = axis.valve.forward if share > 0.0 else axis.valve.backward
    s = [way.resistance_1 * axis.displacement_1**3, way.resistance_2 * axis.displacement_2**3]
    usual = 2.0 * s[0 if share > 0.0 else 1] / sum(s) * LEAST_PART * SUPPLY
    assert opened(axis, share, load, mean) == pytest.approx(
        opened(axis, share, load, -1.0) * math.sqrt(usual / drop), rel=1e-6
    )


@AXES
@pytest.mark.parametrize("share", [-0.1, 0.1])
def test_what_the_tank_line_takes_is_missing_at_the_inlets_edge(i, share):
    """Half the pump's pressure, less half the load and half the line's, is the inlet's and the outlet's."""
    axis = one_sided(i, share, "outlet")
    a_1, a_2, load, tank, mean = axis.displacement_1, axis.displacement_2, 0.0, 2e6, 4e6
    way = axis.valve.forward if share > 0.0 else axis.valve.backward
    s = [way.resistance_1 * a_1**3, way.resistance_2 * a_2**3]
    a_in, a_out, s_in = (a_1, a_2, s[0]) if share > 0.0 else (a_2, a_1, s[1])
    usual = 2.0 * s_in / sum(s) * 0.5 * (SUPPLY - tank * a_out / a_in)
    drop = SUPPLY - mean * a_1 / a_in
    assert opened(axis, share, load, mean, tank) == pytest.approx(
        opened(axis, share, load, -1.0, tank) * math.sqrt(usual / drop), rel=1e-6
    )


@AXES
def test_no_opening_is_more_than_the_whole(i):
    for speed, whole in ((10.0, 1.0), (-10.0, -1.0)):
        assert required_opening(speed, 0.0, SUPPLY, TANK, P.axes[i], P) == whole
