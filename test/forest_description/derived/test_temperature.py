"""Claims about a machine with warm oil: what changes with which of the oil's numbers, and what stays."""

import dataclasses

import pytest

from forest_description.config.parameter import MachineError
from forest_description.derived.temperature import at_temperature
from forest_description.hydraulics.hose import BLASIUS, GeometricHose
from forest_description.hydraulics.load_holding_parameters import RuptureValve
from forest_description.hydraulics.valve_parameters import BackwardValve
from forest_description.machine import load_machine
from forest_description.mechanics.drives import Cushion

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")
OIL = C180.oil
LEAKY = dataclasses.replace(
    C180.valve,
    leakage_conductance=1e-13,
    backward=BackwardValve(deadband_voltage=1.5, minimum_resistance=2e12),
)
TUBE = GeometricHose(0.01905, 1.3e9, BLASIUS, 1e-3)
EVERYTHING = dataclasses.replace(
    C180,
    valve=LEAKY,
    boom=dataclasses.replace(C180.boom, hose=TUBE, cushion=Cushion(0.1, 5e6)),
    stick=dataclasses.replace(
        C180.stick,
        valve=dataclasses.replace(LEAKY, minimum_resistance=3e12),
        hose=dataclasses.replace(C180.hose, capacitance=3e-12),
    ),
)
WARM = 353.15


def ratios(temperature):
    """Viscosity, density, bulk modulus at a temperature over those at the reference."""
    viscosity = OIL.absolute_viscosity(temperature) / OIL.absolute_viscosity(OIL.reference_temperature)
    slope = OIL.bulk_modulus_slope * (temperature - OIL.reference_temperature)
    return (
        viscosity,
        OIL.density_at(temperature) / OIL.density,
        (OIL.bulk_modulus + slope) / OIL.bulk_modulus,
    )


def flat(part):
    """All numbers of a machine or of a part of it, in order."""
    found = []
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            found += flat(value)
        elif isinstance(value, float):
            found.append(value)
    return found


def test_at_its_reference_temperature_a_machine_is_itself():
    assert at_temperature(C180, 313.15) is C180


@pytest.mark.parametrize("temperature", [273.15, 313.15, 353.15])
def test_without_oil_a_machine_knows_no_temperature(temperature):
    assert at_temperature(THESIS, temperature) is THESIS


@pytest.mark.parametrize("temperature", [263.15, WARM])
def test_a_measured_hose_follows_equation_4_3_and_its_oil(temperature):
    m, r, _ = ratios(temperature)
    hot, hose = at_temperature(C180, temperature).hose, C180.hose
    assert hot.laminar_resistance == pytest.approx(hose.laminar_resistance * m, rel=1e-12, abs=0.0)
    assert hot.turbulent_resistance == pytest.approx(
        hose.turbulent_resistance * m**0.25 * r**0.75, rel=1e-12, abs=0.0
    )
    assert hot.inertance == pytest.approx(hose.inertance * r, rel=1e-12, abs=0.0)
    assert (hot.length, hot.bore) == (hose.length, hose.bore)


def test_of_a_measured_capacitance_only_the_oil_softens():
    hot = at_temperature(C180, WARM)
    volume = 0.25 * 3.141592653589793 * C180.hose.bore**2 * C180.hose.length
    wall = C180.hose.capacitance - volume / OIL.bulk_modulus
    assert hot.hose.capacitance == pytest.approx(wall + volume / hot.oil.bulk_modulus, rel=1e-12, abs=0.0)


def test_a_geometric_hose_follows_the_oil_by_itself():
    m, r, _ = ratios(WARM)
    machine = dataclasses.replace(C180, hose=TUBE)
    hot = at_temperature(machine, WARM)
    assert hot.hose == TUBE
    for axis, resistance in ((0, m), (1, m**0.25 * r**0.75)):
        before, after = machine.line(axis, 1), hot.line(axis, 1)
        assert after.resistance == pytest.approx(before.resistance * resistance, rel=1e-12, abs=0.0)
        assert after.inertance == pytest.approx(before.inertance * r, rel=1e-12, abs=0.0)


def test_measured_and_geometric_hoses_of_the_same_numbers_warm_alike():
    same = dataclasses.replace(TUBE, wall_modulus=1e9)
    laminar, turbulent = same.line(4.0, True, OIL), same.line(4.0, False, OIL)
    measured = dataclasses.replace(
        C180.hose,
        turbulent_resistance=turbulent.resistance,
        laminar_resistance=laminar.resistance,
        inertance=laminar.inertance,
        capacitance=laminar.capacitance,
    )
    one = at_temperature(dataclasses.replace(C180, hose=measured), WARM)
    two = at_temperature(dataclasses.replace(C180, hose=same), WARM)
    for axis in range(3):
        assert one.line(axis, 1) == pytest.approx(two.line(axis, 1), rel=1e-12, abs=0.0)


def test_leakage_of_motor_pump_and_spool_flows_easier_as_the_oil_thins():
    m, _, b = ratios(WARM)
    hot = at_temperature(EVERYTHING, WARM)
    assert m < 0.3
    for name in ("internal_leakage_resistance", "external_leakage_resistance"):
        assert getattr(hot.swing, name) == pytest.approx(getattr(C180.swing, name) * m, rel=1e-12, abs=0.0)
    assert hot.pump.leakage_resistance == pytest.approx(C180.pump.leakage_resistance * m, rel=1e-12, abs=0.0)
    assert hot.pump.manifold_capacitance == pytest.approx(
        C180.pump.manifold_capacitance / b, rel=1e-12, abs=0.0
    )
    assert hot.valve.leakage_conductance == pytest.approx(1e-13 / m, rel=1e-12, abs=0.0)


def test_orifices_know_the_density_alone_on_every_axis_and_in_both_directions():
    _, r, _ = ratios(WARM)
    hot = at_temperature(EVERYTHING, WARM)
    assert hot.valve_of(0).law.forward.resistance_1 == pytest.approx(1.04e12 * r, rel=1e-12, abs=0.0)
    assert hot.valve_of(0).law.backward.resistance_2 == pytest.approx(2e12 * r, rel=1e-12, abs=0.0)
    assert hot.valve_of(2).law.forward.resistance_1 == pytest.approx(3e12 * r, rel=1e-12, abs=0.0)
    assert hot.boom.cushion.resistance == pytest.approx(5e6 * r, rel=1e-12, abs=0.0)
    assert hot.valve.deadband_voltage == C180.valve.deadband_voltage


def test_an_axis_own_hose_warms_too():
    hot = at_temperature(EVERYTHING, WARM)
    assert hot.stick.hose.inertance == pytest.approx(
        C180.hose.inertance * ratios(WARM)[1], rel=1e-12, abs=0.0
    )
    assert hot.stick.hose.capacitance > EVERYTHING.stick.hose.capacitance


def test_metal_stays_as_it_is():
    hot = at_temperature(EVERYTHING, WARM)
    for name in ("manipulator", "port_valves", "end_stops", "name"):
        assert getattr(hot, name) == getattr(EVERYTHING, name)
    assert (hot.boom.damping, hot.swing.damping) == (C180.boom.damping, C180.swing.damping)


@pytest.mark.parametrize("temperature", [253.15, 300.0, WARM])
def test_a_machine_comes_back_from_any_temperature_by_any_way(temperature):
    there = at_temperature(EVERYTHING, temperature)
    assert there != EVERYTHING
    assert flat(at_temperature(there, 313.15)) == pytest.approx(flat(EVERYTHING), rel=1e-12, abs=0.0)
    detour = at_temperature(at_temperature(EVERYTHING, 330.0), temperature)
    assert flat(detour) == pytest.approx(flat(there), rel=1e-12, abs=0.0)


def test_a_number_at_the_edge_of_its_range_follows_the_oil_beyond_it():
    tight = dataclasses.replace(C180.swing, internal_leakage_resistance=1e9)
    hot = at_temperature(dataclasses.replace(C180, swing=tight), WARM)
    thinner = C180.oil.absolute_viscosity(WARM) / C180.oil.absolute_viscosity(313.15)
    assert hot.swing.internal_leakage_resistance == pytest.approx(1e9 * thinner)


def test_a_temperature_that_no_oil_has_is_refused_with_the_range():
    with pytest.raises(
        MachineError, match=r"at 40 K: Oil\.reference_temperature: 40 K is outside 223\.15 \.\."
    ):
        at_temperature(C180, 40.0)


def test_a_warm_forwarders_compensators_load_holding_valves_and_tank_line_have_its_oil():
    machine = load_machine("forwarder")
    warm = at_temperature(machine, 353.15)
    thin, soft = warm.oil.density / machine.oil.density, warm.oil.bulk_modulus / machine.oil.bulk_modulus
    assert thin < 1.0 > soft
    assert warm.tank_line.resistance == pytest.approx(thin * machine.tank_line.resistance)
    assert warm.tank_line.capacitance == pytest.approx(machine.tank_line.capacitance / soft)
    for axis in range(3):
        as_told, now = machine.valve_of(axis), warm.valve_of(axis)
        resistance = thin * as_told.compensator.minimum_resistance
        assert now.compensator.minimum_resistance == pytest.approx(resistance)
    for told, now in (
        (machine.boom.holding_1, warm.boom.holding_1),
        (machine.stick.holding_2, warm.stick.holding_2),
    ):
        assert now.minimum_resistance == pytest.approx(thin * told.minimum_resistance)
        assert now.check_resistance == pytest.approx(thin * told.check_resistance)
        assert (now.setting, now.response_time) == (told.setting, told.response_time)


def test_a_warm_rupture_valve_has_one_thinner_resistance():
    valve = RuptureValve(closing_flow=1e-3, minimum_resistance=1e11, response_time=0.01)
    machine = load_machine("c180")
    machine = dataclasses.replace(machine, boom=dataclasses.replace(machine.boom, holding_1=valve))
    warm = at_temperature(machine, 353.15)
    assert warm.boom.holding_1.minimum_resistance == pytest.approx(
        1e11 * warm.oil.density / machine.oil.density
    )
    assert warm.boom.holding_1.closing_flow == 1e-3
