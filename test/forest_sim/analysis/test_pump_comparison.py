"""Four pumps in one motion under one load: what differs is what the thesis says differs."""

from dataclasses import fields

import pytest

from forest_description.machine import load_machine
from forest_sim.analysis.pump_comparison import SORTS, compare, table, with_pump
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.open_loop import Run, start_angles

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")


@pytest.fixture(scope="module")
def comparison():
    return compare(C180, voltage_profiles.thesis(), start_angles(C180), Run(9.5))


@pytest.mark.parametrize("machine", [C180, THESIS], ids=["c180_hoses", "c180_thesis"])
@pytest.mark.parametrize("sort", SORTS, ids=lambda sort: sort.kind)
def test_a_variant_keeps_the_machines_own_numbers(machine, sort):
    variant = with_pump(machine, sort)
    assert type(variant.pump) is sort
    assert variant.boom == machine.boom
    own = {field.name for field in fields(machine.pump)} & {field.name for field in fields(variant.pump)}
    for name in own:
        assert getattr(variant.pump, name) == getattr(machine.pump, name)


def test_constant_flow_wastes_most_and_load_sensing_least(comparison):
    engine = {name: energy["engine"] for name, energy in comparison.energies.items()}
    assert list(engine) == ["ideal", "pressure compensated", "constant flow", "load sensing"]
    assert engine["constant flow"] > 3.0 * engine["pressure compensated"]
    assert engine["pressure compensated"] > engine["ideal"] > engine["load sensing"]
    assert engine["load sensing"] < 0.4 * engine["pressure compensated"]


def test_a_constant_flow_pump_runs_at_full_power_all_the_time(comparison):
    power = comparison.powers["constant flow"][:, 0]
    full = 2 * 45e-6 * 2500 / 60 * 3000 * 6894.7 / 0.93  # flow times relief pressure over efficiency
    assert full < power.min() < power.max() < 1.05 * full


def test_all_pumps_move_the_same_crane_alike(comparison):
    """Same motion, same load: the tip's paths and what the links and their friction take are one."""
    led = comparison.energies["load sensing"]
    for name, energy in comparison.energies.items():
        assert abs(energy["unaccounted"]) < 0.005 * energy["engine"]
        assert comparison.paths[name] == pytest.approx(comparison.paths["load sensing"], rel=0.02)
        assert comparison.apart[name] < 0.025
        assert energy["friction"] == pytest.approx(led["friction"], rel=0.02)
        assert energy["mechanical"] == pytest.approx(led["mechanical"], abs=0.01 * led["friction"])


def test_more_pressure_than_the_load_needs_is_throttled(comparison):
    """Fig. 2.3: at equal load the systems differ by what they throttle, and by what the pump relieves."""
    lost = {name: energy["throttling"] + energy["pump"] for name, energy in comparison.energies.items()}
    assert lost["load sensing"] < 0.5 * lost["ideal"]
    assert lost["ideal"] < lost["pressure compensated"] < 0.2 * lost["constant flow"]


def test_the_table_has_a_column_for_each_pump_and_a_row_for_each_entry(comparison):
    head, *rows = table(comparison).splitlines()
    assert head.split()[-6:] == ["pressure", "compensated", "constant", "flow", "load", "sensing"]
    assert [row.split()[0] for row in rows][:3] == ["engine", "pump", "throttling"]
    assert all(len(row) == len(head) for row in rows)
