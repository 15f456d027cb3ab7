"""Claims about the kernel's parameters: each comes from its place in the machine, absent ones are neutral."""

import math
from dataclasses import replace

import pytest

from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.hydraulic_line import guard_flow
from forest_sim.hydraulics.supply import supply
from forest_sim.mechanics.end_stop import end_stop_force

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")


@pytest.mark.parametrize("machine", [C180, THESIS], ids=["c180_hoses", "thesis"])
def test_every_hose_is_that_of_its_axis_and_port(machine):
    p = plant_parameters(machine)
    lines = [line for axis in (p.swing, p.boom, p.stick) for line in (axis.line_1, axis.line_2)]
    assert lines == [machine.line(axis, port) for axis in range(3) for port in (1, 2)]
    assert p.stick.line_1 != p.stick.line_2


def test_actuators_are_those_of_their_axis():
    boom = replace(C180.boom, head_area=2e-2)
    p, plain = plant_parameters(replace(C180, boom=boom)), plant_parameters(C180)
    assert p.boom.actuator.displacement_1 == 2e-2
    assert (p.swing, p.stick) == (plain.swing, plain.stick)
    assert p.boom_linkage == C180.boom.linkage
    assert p.stick_linkage == C180.stick.linkage


def test_pump_and_valve_are_the_machines():
    p = plant_parameters(C180)
    assert p.supply == supply(C180.pump)
    assert p.supply.set_pressure == C180.pump.supply_pressure
    assert [valve.law for valve in p.valves] == [C180.valve.law] * 3


def test_an_axis_own_valve_is_its_and_the_others_share_theirs():
    own = replace(C180.valve, deadband_voltage=1.5, spool_bandwidth=None)
    p = plant_parameters(replace(C180, boom=replace(C180.boom, valve=own)))
    assert [valve.law.forward.deadband_voltage for valve in p.valves] == [1.0, 1.5, 1.0]
    assert [valve.lag.frequency < math.inf for valve in p.valves] == [True, False, True]


def test_spool_rate_is_the_bandwidth_in_radians_and_infinite_without_lag():
    rate = pytest.approx(2.0 * math.pi * C180.valve.spool_bandwidth)
    assert [(v.lag.frequency, v.lag.damping) for v in plant_parameters(C180).valves] == [(rate, 0.0)] * 3
    assert [v.lag.frequency for v in plant_parameters(THESIS).valves] == [math.inf] * 3


def test_port_valves_open_at_the_machines_settings():
    guard, valves = plant_parameters(C180).guard, C180.port_valves
    assert guard_flow(valves.relief_pressure, guard) == 0.0
    assert guard_flow(valves.relief_pressure + 1e5, guard) == pytest.approx(-1e5 * valves.relief_conductance)
    low = valves.anticavitation_pressure - 1e3
    assert guard_flow(low, guard) == pytest.approx(1e3 * valves.anticavitation_conductance)


def test_stops_stand_where_the_joint_limits_are():
    p, (swing, boom, stick) = plant_parameters(C180), joint_limits(C180)
    assert (p.swing.stop.lower, p.swing.stop.upper) == swing
    for axis, linkage, limits in ((p.boom, p.boom_linkage, boom), (p.stick, p.stick_linkage, stick)):
        ends = [cylinder_length(angle, linkage) for angle in limits]
        assert (axis.stop.lower, axis.stop.upper) == pytest.approx(ends, rel=1e-12)
        assert (
            end_stop_force(ends[0] - 1e-3, 0.0, axis.stop)
            > 0.0
            > end_stop_force(ends[1] + 1e-3, 0.0, axis.stop)
        )


def test_the_thesis_machine_has_neither_port_valves_nor_stops():
    p = plant_parameters(THESIS)
    for value in (-1e9, -1.0, 0.0, 1e9):
        assert guard_flow(value, p.guard) == 0.0
        assert all(end_stop_force(value, 1.0, axis.stop) == 0.0 for axis in (p.swing, p.boom, p.stick))


def test_equal_machines_share_their_parameters():
    assert plant_parameters(C180) is plant_parameters(replace(C180))
    assert plant_parameters(C180) is not plant_parameters(replace(C180, name="other"))
