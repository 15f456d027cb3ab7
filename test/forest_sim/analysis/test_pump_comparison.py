"""Four pumps under one input: what differs is what the thesis says differs."""

from dataclasses import fields

import pytest

from forest_description.machine import load_machine
from forest_sim.analysis.pump_comparison import SORTS, compare, table, with_pump
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.open_loop import Run, start_angles

C180, THESIS = load_machine("c180"), load_machine("c180_thesis")


@pytest.fixture(scope="module")
def comparison():
    return compare(C180, voltage_profiles.thesis(), start_angles(C180), Run(9.5))


@pytest.mark.parametrize("machine", [C180, THESIS], ids=["c180", "c180_thesis"])
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
    per_metre = {name: engine[name] / comparison.paths[name] for name in engine}
    assert per_metre["load sensing"] < 0.6 * per_metre["pressure compensated"]


def test_a_constant_flow_pump_runs_at_full_power_all_the_time(comparison):
    power = comparison.powers["constant flow"][:, 0]
    full = 2 * 45e-6 * 2500 / 60 * 3000 * 6894.7 / 0.93  # flow times relief pressure over efficiency
    assert full < power.min() < power.max() < 1.05 * full


def test_a_load_sensing_pump_answers_later(comparison):
    """The thesis' reason for constant pressure: the speed of response."""
    risen = {
        name: comparison.time[(power[:, 0] > 0.5 * power[comparison.time < 2.0, 0].max()).argmax()]
        for name, power in comparison.powers.items()
    }
    assert risen["load sensing"] > risen["pressure compensated"] + 0.05


def test_every_account_closes_and_pumps_of_one_pressure_move_alike(comparison):
    for energy in comparison.energies.values():
        assert abs(energy["unaccounted"]) < 0.005 * energy["engine"]
    paths = comparison.paths
    assert paths["constant flow"] == pytest.approx(paths["pressure compensated"], rel=0.03)


def test_the_table_has_a_column_for_each_pump_and_a_row_for_each_entry(comparison):
    head, *rows = table(comparison).splitlines()
    assert head.split()[-6:] == ["pressure", "compensated", "constant", "flow", "load", "sensing"]
    assert [row.split()[0] for row in rows][:3] == ["engine", "pump", "throttling"]
    assert all(len(row) == len(head) for row in rows)
