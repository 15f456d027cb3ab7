"""Cranes of other makes (`test/helpers/foreign_plants.py`); what `benchmarks/foreign_coverage.py` counts."""

import importlib.util
import sys
from pathlib import Path

import pytest
from foreign_plants import SCALE, STRUCTURES, WITHIN, foreign

from forest_ident.measurements.parameter_path import value_of
from forest_ident.refinement.result import value_in
from forest_sim.equations.plant_parameters import plant_parameters

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


@pytest.fixture(scope="module")
def benchmark_module():
    """Imports the benchmark, which finds its neighbours as a script does."""
    sys.path.insert(0, str(BENCHMARKS))
    spec = importlib.util.spec_from_file_location("foreign_coverage", BENCHMARKS / "foreign_coverage.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.path.remove(str(BENCHMARKS))
    return module


@pytest.mark.parametrize("structure", STRUCTURES)
def test_a_draw_is_a_crane_that_can_be_simulated_and_drawn_again(structure):
    first, again, other = foreign(structure, 4), foreign(structure, 4), foreign(structure, 5)
    assert first == again
    assert first.crane != other.crane
    plant_parameters(first.crane)


@pytest.mark.parametrize("structure", STRUCTURES)
def test_every_number_is_drawn_within_its_share(structure):
    plant = foreign(structure, 4)
    for key in plant.drawn:
        share = value_of(plant.crane, key) / value_in(plant.told, key) - 1.0
        assert 0.0 < abs(share) <= (SCALE if key.endswith("_mass") else WITHIN), key


def test_the_told_machine_lacks_what_the_crane_has():
    crane = {name: foreign(name, 4).crane for name in STRUCTURES}
    told = foreign("own", 4).told
    assert told.boom.friction is None
    assert crane["dry_friction"].boom.friction is not None
    assert told.valve.curve is None
    assert crane["curved_valve"].valve.curve is not None
    assert told.pump.kind != crane["load_sensing"].pump.kind == "load_sensing"


def session(**changes):
    """Returns what a session told: two intervals, one of which misses."""
    told = {
        "structure": "own",
        "off": {"boom.damping": 0.1, "valve.deadband_voltage": 0.02},
        "away": {"boom.damping": 3.0, "valve.deadband_voltage": 0.5},
        "doubts": {},
        "nrmse": {"boom velocity": 0.01},
        "tip_mm": {"sweep": [2.0, 1.0, 5.0]},
        "verdict": 0,
        "named": ["damping_boom: …; try `--allow friction`"],
    }
    return told | changes


def test_a_row_counts_intervals_that_hold_and_leaves_out_the_doubted(benchmark_module):
    cells = benchmark_module.row("own", [session()]).split(" | ")
    assert cells[2] == "1 of 2 (50 %)"
    assert cells[4:7] == ["0.02 V; 10.5 % (boom.damping)", "1 %", "2.00 (5.0)"]
    assert cells[7:] == ["trusted 1", "friction 1 |"]
    doubted = benchmark_module.row("own", [session(doubts={"boom.damping": "why"})]).split(" | ")
    assert doubted[2:4] == ["1 of 1 (100 %)", "1"]


def test_a_crash_is_counted(benchmark_module):
    assert "2, 1 crashed" in benchmark_module.row("own", [session(), {"structure": "own", "crash": "why"}])


def test_a_path_without_an_end_is_told_as_infinite_and_is_no_crash(benchmark_module, monkeypatch):
    def endless(*_):
        raise benchmark_module.PathError("the tip is not at the end")

    monkeypatch.setattr(benchmark_module, "track", endless)
    plant = foreign("own", 4)
    assert benchmark_module._tip("sweep", plant, plant.told, 4) == [float("inf")] * 3
    row = benchmark_module.row("own", [session(tip_mm={"sweep": [float("inf"), 1.0, 5.0]})])
    assert row.split(" | ")[6] == "inf (5.0)"
