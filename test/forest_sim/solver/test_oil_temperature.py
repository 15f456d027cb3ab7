"""Claims about the oil's temperature: steady state, time constant, heat, and what it does to the plant."""

import dataclasses
import math

import pytest

from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.oil_temperature import (
    LOSS_SAMPLES,
    UPDATE_PERIOD,
    WarmingOil,
    dissipated_power,
    parameters_at,
    temperature_after,
    temperature_rate,
)
from forest_sim.solver.power_flows import power_flows

MACHINE = load_machine("c180_hoses")
OIL = MACHINE.oil
STEADY = OIL.ambient_temperature + 24e3 / OIL.heat_loss_coefficient
TIME_CONSTANT = OIL.heat_capacity / OIL.heat_loss_coefficient


def test_a_steady_machine_is_warmer_than_the_air_by_loss_over_coefficient():
    assert pytest.approx(333.15) == STEADY
    assert temperature_rate(STEADY, 24e3, OIL) == pytest.approx(0.0, abs=1e-12)
    assert temperature_after(250.0, 24e3, OIL, 100.0 * TIME_CONSTANT) == pytest.approx(STEADY, rel=1e-12)


def test_after_one_time_constant_the_gap_is_down_to_one_over_e():
    assert pytest.approx(544.67, abs=0.01) == TIME_CONSTANT
    reached = temperature_after(293.15, 24e3, OIL, TIME_CONSTANT)
    assert (STEADY - reached) / (STEADY - 293.15) == pytest.approx(math.exp(-1.0), rel=1e-12)


def test_many_short_steps_are_one_long_step():
    temperature = 280.0
    for _ in range(600):
        temperature = temperature_after(temperature, 24e3, OIL, UPDATE_PERIOD)
    assert temperature == pytest.approx(temperature_after(280.0, 24e3, OIL, 600.0 * UPDATE_PERIOD), rel=1e-12)


def test_the_step_has_the_rate_as_its_derivative():
    change = temperature_after(300.0, 10e3, OIL, 1e-3) - 300.0
    assert change / 1e-3 == pytest.approx(temperature_rate(300.0, 10e3, OIL), rel=1e-5)


def test_without_cooling_all_heat_stays_in_the_oil():
    sealed = dataclasses.replace(OIL, heat_loss_coefficient=0.0)
    warmed = temperature_after(300.0, 24e3, sealed, 60.0) - 300.0
    assert warmed * 860.0 * 0.2 * 1900.0 == pytest.approx(24e3 * 60.0, rel=1e-9)


def test_the_kernel_gets_the_warm_machine_and_at_the_reference_the_same_one():
    assert parameters_at(MACHINE, OIL.reference_temperature) == plant_parameters(MACHINE)
    warm = parameters_at(MACHINE, 353.15)
    assert warm.swing.line_1.resistance < 0.3 * plant_parameters(MACHINE).swing.line_1.resistance
    assert warm.supply.leakage > plant_parameters(MACHINE).supply.leakage
    assert parameters_at(load_machine("c180_thesis"), 353.15) == plant_parameters(load_machine("c180_thesis"))


def test_a_boiling_machine_keeps_the_oil_of_the_hottest_law():
    assert parameters_at(MACHINE, 500.0) == parameters_at(MACHINE, 423.15)
    assert parameters_at(MACHINE, 100.0) == parameters_at(MACHINE, 223.15)


def test_at_rest_the_heat_is_what_the_pump_needs_for_itself():
    p = plant_parameters(MACHINE)
    flows = power_flows(equilibrium((0.0, 0.5, -1.5), p), p)
    assert dissipated_power(flows) == pytest.approx(flows.pump.pump_friction + flows.pump.pump_leakage)


def driven(temperature, seconds):
    """Swing with the valve wide open from rest; yield (simulation, parameters) each 0.1 s."""
    p, advance = parameters_at(MACHINE, temperature), compiled_advance()
    simulation = equilibrium(inverse_kinematics((5.5, 0.0, 1.0), MACHINE.manipulator.links), p)
    for _ in range(round(10 * seconds)):
        simulation = advance(simulation, (10.0, 0.0, 0.0), 1e-3, 100, p)
        yield simulation, p


def test_the_heat_of_a_moving_machine_is_the_sum_of_its_losses():
    for simulation, p in driven(300.0, 1.5):
        flows = power_flows(simulation, p)
        pump = flows.pump
        losses = pump.pump_friction + pump.pump_leakage + pump.main_relief
        for a in (flows.swing, flows.boom, flows.stick):
            losses += a.throttling + a.port_valves + a.resistance + a.leakage + a.damping + a.dry_friction
            losses += a.cushion + a.gear
        assert dissipated_power(flows) == pytest.approx(losses, rel=1e-6)


def test_an_engine_that_gives_way_and_a_tank_line_that_fills_are_no_heat():
    p = plant_parameters(load_machine("forwarder"))
    simulation = equilibrium((0.0, 0.5, -1.5), p)
    for _ in range(10):
        simulation = compiled_advance()(simulation, (9.0, 9.0, -9.0), 1e-3, 20, p)
        flows = power_flows(simulation, p)
        pump = flows.pump
        losses = pump.pump_friction + pump.pump_leakage + pump.main_relief + pump.return_line
        for a in (flows.swing, flows.boom, flows.stick):
            losses += a.throttling + a.port_valves + a.resistance + a.leakage + a.damping + a.dry_friction
            losses += a.cushion + a.gear + a.holding + a.compression + a.bending
        assert dissipated_power(flows) == pytest.approx(losses, rel=1e-6)


def test_cold_oil_swings_slower():
    cold, warm = ([s.plant.swing.rate for s, _ in driven(t, 2.5)][-1] for t in (273.15, 333.15))
    assert 0.3 < cold < 0.95 * warm


def test_the_plant_goes_on_without_a_jump_when_its_oil_is_a_little_warmer():
    """Operator splitting: one second of plant, one step of temperature, new parameters."""
    *_, (simulation, p) = driven(313.15, 1.0)
    temperature = temperature_after(313.15, dissipated_power(power_flows(simulation, p)), OIL, UPDATE_PERIOD)
    assert 0.0 < temperature - 313.15 < 0.3
    advance, warm = compiled_advance(), parameters_at(MACHINE, temperature)
    same, other = (advance(simulation, (10.0, 0.0, 0.0), 1e-3, 1, q).plant for q in (p, warm))
    assert other.swing.rate == pytest.approx(same.swing.rate, rel=1e-4)
    assert other.swing.pressure_1 == pytest.approx(same.swing.pressure_1, rel=1e-3)


def test_oil_that_runs_period_by_period_is_asked_evenly_and_warms_by_the_mean_of_its_losses():
    p = plant_parameters(MACHINE)
    rests, oil = equilibrium((0.0, 0.5, -1.5), p), WarmingOil(OIL, UPDATE_PERIOD / 40)
    asked = []
    warmed = [
        period
        for period in range(1, 81)
        if oil.has_warmed(lambda period=period: asked.append(period) or rests, p)
    ]
    assert asked == list(range(4, 81, 40 // LOSS_SAMPLES))
    assert warmed == [40, 80]
    heat = dissipated_power(power_flows(rests, p))
    assert oil.temperature == pytest.approx(
        temperature_after(OIL.reference_temperature, heat, OIL, 2.0 * UPDATE_PERIOD), rel=1e-9
    )
