"""Claims about a machine with pressure compensators: load, shared pump, an axis at its end."""

import math
from dataclasses import replace

import numpy as np
import pytest
from full_machine import advance

from forest_description.derived.bodies import with_log
from forest_description.hydraulics.compensator_parameters import CompensatorAfterSpool, CompensatorBeforeSpool
from forest_description.hydraulics.valve_characteristic import edges
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.oil_volume import hose_drop
from forest_sim.solver.equilibrium import equilibrium

FORWARDER = load_machine("forwarder")
SHARED = {"control_range": 3e5, "minimum_resistance": 5e10, "response_time": 0.015}
BEFORE = CompensatorBeforeSpool(setting=1e6, **SHARED)
AFTER = CompensatorAfterSpool(setting=4e5, **SHARED)
START = (0.0, 0.2, -1.2)


def machine(compensator, **pump):
    """The forwarder with other compensators, without what holds loads or comes late."""
    part = replace(FORWARDER.valve, compensator=compensator)
    axes = {
        name: replace(drive, valve=replace(drive.valve, compensator=compensator) if drive.valve else None)
        for name, drive in (("swing", FORWARDER.swing), ("stick", FORWARDER.stick))
    }
    axes["stick"] = replace(axes["stick"], holding_1=None, holding_2=None)
    boom = replace(FORWARDER.boom, holding_1=None)
    at_once = {"stroke_up_time": None, "stroke_down_time": None, "engine": None}
    supply = replace(FORWARDER.pump, **at_once, **pump)
    return replace(FORWARDER, valve=part, boom=boom, pump=supply, tank_line=None, **axes)


def run(m, voltages, seconds):
    p = plant_parameters(m)
    return advance(equilibrium(START, p), voltages, 1e-3, round(1e3 * seconds), p)


def flow(simulation, axis):
    return simulation.plant.axes[axis].flow_1


def loaded(m, mass):
    return replace(m, manipulator=with_log(m.manipulator, mass, 4.0))


@pytest.mark.parametrize(
    ("kind", "least", "most"), [(None, 1.3, 3.0), (BEFORE, 0.93, 1.07), (AFTER, 0.93, 1.07)]
)
def test_a_boom_beside_a_swing_that_needs_much_pressure_keeps_its_speed(kind, least, most):
    """The swing starts against its inertia, and the pump follows it: the boom must not feel it."""
    rises = []
    for swing in (0.0, 7.0):
        under_way = run(machine(kind), (swing, 6.0, 0.0), 0.4)
        end = advance(under_way, (swing, 6.0, 0.0), 1e-3, 1200, plant_parameters(machine(kind)))
        rises.append(end.plant.boom.angle - under_way.plant.boom.angle)
    assert least < rises[1] / rises[0] < most


def openings(simulation, m):
    """C_R^-1/2 of the edges to the pump."""
    law = [m.valve_of(axis).law for axis in range(3)]
    return [edges(simulation.spools[axis].position, law[axis]).supply_1 ** -0.5 for axis in range(3)]


def test_a_pump_too_small_for_all_is_shared_in_proportion_to_the_openings():
    """Q sqrt(C_R) of every axis is the root of what the pump leaves, less each one's own control range."""
    m = machine(AFTER, displacement=0.3 * FORWARDER.pump.displacement)
    p, now, shared, flows = plant_parameters(m), run(m, (5.0, 7.0, 6.0), 1.0), [], []
    for _ in range(50):
        now = advance(now, (5.0, 7.0, 6.0), 1e-3, 10, p)
        supply, axes = now.plant.supply, now.plant.axes
        assert supply.pressure < supply.reference - 5e5  # it is too small
        heaviest = max(
            axis.pressure_1 + hose_drop(axis.flow_1, p.axes[i].oil_1) for i, axis in enumerate(axes)
        )
        left = supply.pressure - heaviest - AFTER.setting
        kept = [left - AFTER.control_range * lifts.compensator for lifts in now.midpoint.lifts]
        shared.append([edge * math.sqrt(drop) for edge, drop in zip(openings(now, m), kept, strict=True)])
        flows.append([axis.flow_1 for axis in axes])
    assert np.mean(flows, axis=0) == pytest.approx(np.mean(shared, axis=0), rel=0.02)


def test_before_the_spools_the_heaviest_axis_starves_first():
    small, unequal = {"displacement": 0.3 * FORWARDER.pump.displacement}, {}
    for kind in (BEFORE, AFTER):
        m = loaded(machine(kind, **small), 1000.0)
        end = run(m, (5.0, 7.0, 6.0), 0.8)
        shares = [flow(end, axis) / opening for axis, opening in enumerate(openings(end, m))]
        unequal[kind.kind] = max(shares) / min(shares)
    assert unequal["after_spool"] < 1.2
    assert unequal["before_spool"] > 1.4


def test_an_axis_at_its_end_leaves_the_others_their_flow():
    m = machine(AFTER)
    p = plant_parameters(m)
    end = advance(equilibrium((0.0, 1.13, -1.2), p), (5.0, 8.0, 5.0), 1e-3, 1500, p)
    assert end.plant.boom.angle > 1.13  # against its stop
    assert abs(end.plant.boom.rate) < 5e-3
    alone = run(m, (5.0, 0.0, 5.0), 0.8)
    for axis in (0, 2):
        assert flow(end, axis) > 0.8 * flow(alone, axis)


def test_a_load_far_above_standby_is_lifted_past_its_load_holding_valve():
    """The pump must climb to it by what its load-sensing line feels through the shut compensator."""
    m = loaded(FORWARDER, 800.0)
    p = plant_parameters(m)
    start = equilibrium(START, p)
    assert start.plant.boom.pressure_1 > 3.0 * start.plant.supply.pressure
    end = advance(start, (0.0, 7.0, 0.0), 1e-3, 1500, p)
    assert end.plant.boom.angle > START[1] + 0.15
