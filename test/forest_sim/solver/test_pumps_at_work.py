"""Claims about the manifold that three axes share: what the pump cannot give, each lacks by its load."""

import numpy as np
import pytest
from full_machine import BAND, PRESSURE, RELIEF, START, advance, full_machine, with_pump

from forest_sim.equations.plant import supply_draw
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.supply import available_flow, pump_flow
from forest_sim.sensors.sensor_readings import at_rest, measure
from forest_sim.solver.equilibrium import equilibrium

FULL = (10.0, 10.0, 10.0)


def run(machine, voltages, seconds, start=None, h=1e-3):
    p = plant_parameters(machine)
    return advance(start or equilibrium(START, p), voltages, h, round(seconds / h), p)


def saturation(machine, simulation):
    p = plant_parameters(machine)
    return measure(simulation, at_rest(simulation, p), p, 5e-3)[1].supply_saturation


def drawn(machine, simulation):
    return supply_draw(simulation.plant, ports_at(simulation.spools, plant_parameters(machine))).flow


@pytest.mark.parametrize("name", ["compensated", "constant flow", "load sensing"])
def test_the_manifold_stores_what_the_pump_gives_and_nobody_draws(name):
    """Over a motion from rest to full speed and back, C dP equals the integral of both flows."""
    machine = full_machine(name)
    p = plant_parameters(machine)
    now, h = equilibrium(START, p), 1e-4
    start, stored = now.plant.supply.pressure, 0.0
    for k in range(600):
        before, now = now, advance(now, (6.0, 4.0, -5.0) if k < 300 else (0.0,) * 3, h, 1, p)
        for weight, s in ((0.5, before), (0.5, now)):
            pump = pump_flow(*s.plant.supply, p.supply).delivered
            stored += weight * h * (pump - drawn(machine, s))
    gained = p.supply.capacitance * (now.plant.supply.pressure - start)
    assert stored == pytest.approx(gained, abs=2e-3 * p.supply.capacitance * PRESSURE)


def test_a_compensated_pump_keeps_its_pressure_within_its_band_while_it_is_strong_enough():
    machine = with_pump("compensated")
    p, now = plant_parameters(machine), None
    for voltage in (3.0, -3.0, 2.0):
        now = run(machine, (voltage, voltage, voltage), 0.5, now)
        assert PRESSURE - BAND < now.plant.supply.pressure <= PRESSURE
        assert drawn(machine, now) < available_flow(PRESSURE, p.supply)


def test_all_axes_at_full_draw_all_that_the_pump_can_give():
    machine = with_pump("compensated")
    p, now = plant_parameters(machine), run(machine, FULL, 1.0)
    pressure = now.plant.supply.pressure
    assert pressure < PRESSURE - BAND
    most = available_flow(pressure, p.supply) - p.supply.leakage * pressure
    assert drawn(machine, now) == pytest.approx(most, rel=1e-3)
    assert saturation(machine, now) == pytest.approx(1.0, abs=1e-3)
    assert saturation(machine, equilibrium(START, p)) == 0.0


def test_on_a_saturated_pump_the_heavier_loaded_axis_slows_first():
    """The boom lifts against gravity, the swing has little to do: the boom loses the larger share."""
    rates = {
        name: np.array([axis.rate for axis in run(with_pump(name), FULL, 0.6).plant[:3]])
        for name in ("ideal", "compensated")
    }
    kept = rates["compensated"] / rates["ideal"]
    assert kept[1] < kept[0] < 1.0
    assert kept[1] < 0.75


def test_what_one_axis_leaves_the_others_get():
    machine = with_pump("compensated")
    alone, together = (run(machine, (0.0, v, 10.0), 0.6).plant.stick.rate for v in (0.0, 10.0))
    assert abs(together) < 0.9 * abs(alone)


def test_an_engine_too_weak_for_full_flow_gives_its_power():
    machine = with_pump("compensated", engine_power=3e4)
    p, now = plant_parameters(machine), run(machine, FULL, 1.0)
    pressure = now.plant.supply.pressure
    flow = pump_flow(*now.plant.supply, p.supply)
    assert flow.displaced * pressure == pytest.approx(3e4 * 0.93, rel=1e-9)
    assert flow.displaced < 0.9 * p.supply.flow_limit
    assert run(with_pump("compensated"), FULL, 1.0).plant.swing.rate > 1.05 * now.plant.swing.rate


def test_a_constant_flow_goes_over_the_relief_valve_when_nobody_takes_it():
    machine = with_pump("constant flow")
    idle = equilibrium(START, plant_parameters(machine))
    later = run(machine, (0.0,) * 3, 1.0, idle)
    assert later.plant.supply.pressure == pytest.approx(idle.plant.supply.pressure, rel=1e-9)
    assert PRESSURE < later.plant.supply.pressure < PRESSURE + 1e6
    assert run(machine, (3.0, 0.0, 0.0), 0.5).plant.supply.pressure < later.plant.supply.pressure


def test_load_sensing_reaches_the_load_and_its_margin_with_its_time_constant():
    machine = with_pump("load sensing", response_time=0.3)
    p = plant_parameters(machine)
    begin = run(machine, (3.0, 0.0, 0.0), 6.0)
    load = supply_draw(begin.plant, ports_at(begin.spools, p)).load
    assert begin.plant.supply.reference == pytest.approx(load + 2e6, rel=1e-3)
    assert 0.0 < begin.plant.supply.reference - begin.plant.supply.pressure < BAND
    shut = advance(begin, (0.0,) * 3, 1e-3, 1000, p)  # the spool is centred after a few of its lags
    then = advance(shut, (0.0,) * 3, 1e-3, 300, p)
    gap, later = shut.plant.supply.reference - 2e6, then.plant.supply.reference - 2e6
    assert later / gap == pytest.approx(np.exp(-1.0), rel=2e-3)


def test_load_sensing_follows_the_greatest_load():
    machine = with_pump("load sensing")
    light, heavy, both = (
        run(machine, volts, 1.0).plant.supply.reference
        for volts in ((3.0, 0.0, 0.0), (0.0, 3.0, 0.0), (3.0, 3.0, 0.0))
    )
    assert light < 0.8 * heavy
    assert both == pytest.approx(heavy, rel=0.1)


@pytest.mark.parametrize("name", ["compensated", "load sensing"])
def test_the_main_relief_valve_bounds_the_manifold_when_a_load_drives_oil_back(name):
    machine = with_pump(name)
    p, now, highest = plant_parameters(machine), None, 0.0
    for k in range(40):
        v = 10.0 if k % 2 else -10.0
        now = run(machine, (v, -v, v), 0.1, now)
        highest = max(highest, now.plant.supply.pressure)
    assert highest < RELIEF + 1.5e6
    assert now.events.unconverged_stages == 0
    assert p.supply.relief_pressure == RELIEF
