"""Claims about the sorts of pump: what they have in common, and what contradicts itself."""

from dataclasses import fields, replace

import pytest

from forest_description.config.parameter import MachineError
from forest_description.hydraulics.pump import (
    ConstantFlowPump,
    IdealPump,
    LoadSensingPump,
    PressureCompensatedPump,
)
from forest_description.machine import load_machine

PUMP = load_machine("c180_hoses").pump
SHARED = {field.name: getattr(PUMP, field.name) for field in fields(ConstantFlowPump)}
RELIEF = PUMP.relief_pressure
SENSING = LoadSensingPump(
    **SHARED, relief_pressure=RELIEF, compensator_band=5e5, margin=2e6, response_time=0.05
)


def test_each_sort_has_a_name_of_its_own():
    names = [sort.kind for sort in (IdealPump, PressureCompensatedPump, ConstantFlowPump, LoadSensingPump)]
    assert names == ["ideal", "pressure_compensated", "constant_flow", "load_sensing"]


def test_full_flow_is_that_of_all_pumps_at_the_shafts_speed():
    """Two A10VO45 at 2500 rpm: 225 litres a minute."""
    assert PUMP.flow_limit == pytest.approx(0.225 / 60.0)
    assert replace(PUMP, count=1).flow_limit == pytest.approx(0.1125 / 60.0)


@pytest.mark.parametrize("pump", [PUMP, SENSING], ids=["compensated", "load sensing"])
def test_a_relief_valve_below_the_controlled_pressure_is_refused(pump):
    with pytest.raises(
        MachineError, match=r"relief_pressure \(2e\+07 Pa\) must not be below supply_pressure"
    ):
        replace(pump, relief_pressure=2e7)
    assert replace(pump, relief_pressure=pump.supply_pressure).relief_pressure == pump.supply_pressure


def test_a_constant_flow_pump_has_one_pressure_that_of_its_relief_valve():
    assert not hasattr(ConstantFlowPump(**SHARED), "relief_pressure")


def test_a_margin_that_leaves_nothing_for_a_load_is_refused():
    with pytest.raises(MachineError, match=r"margin \(1.5e\+07 Pa\) must be smaller than supply_pressure"):
        replace(SENSING, margin=1.5e7, supply_pressure=1.5e7)


@pytest.mark.parametrize(
    "change",
    [
        {"count": 0.0},
        {"engine_power": -1.0},
        {"mechanical_efficiency": 1.1},
        {"manifold_capacitance": 0.0},
        {"relief_conductance": 0.0},
        {"response_time": 0.0},
    ],
)
def test_impossible_numbers_are_refused_by_name(change):
    (name,) = change
    with pytest.raises(MachineError, match=rf"LoadSensingPump\.{name}: .* is outside"):
        replace(SENSING, **change)
