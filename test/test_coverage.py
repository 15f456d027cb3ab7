"""The counting behind `benchmarks/coverage.py`, and a reduced run of what it counts."""

import importlib.util
import json
import math
from pathlib import Path

import numpy as np
import pytest

FILE = Path(__file__).resolve().parents[1] / "benchmarks" / "interval_coverage.py"
SPEC = importlib.util.spec_from_file_location("interval_coverage", FILE)
assert SPEC is not None
assert SPEC.loader is not None
benchmark = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(benchmark)


def test_shares_are_those_of_a_normal_distribution():
    generator = np.random.default_rng(8)
    trials = [{"a": float(z), "b": float(2.0 * z)} for z in generator.standard_normal(4000)]
    shares = benchmark.coverage(trials)
    assert shares["a"] == pytest.approx(0.95, abs=0.01)
    assert shares["b"] == pytest.approx(0.673, abs=0.02)
    assert shares["pooled"] == pytest.approx(0.5 * (shares["a"] + shares["b"]))


def test_a_session_of_the_coverage_run_is_near_its_truth():
    away, doubts = benchmark.trial(3, ("spool_lag",))
    assert not doubts
    assert set(away) == {"valve.spool_bandwidth"}
    assert all(math.isfinite(z) and abs(z) < 4.0 for z in away.values())


@pytest.mark.parametrize(
    ("seed", "names", "why"),
    [
        (344, ("valve",), "next to shut a difference of 1 % is no derivative"),
        (359, ("valve", "hose"), "the flow turns round between two rows"),
    ],
)
def test_a_valve_next_to_shut_feigns_no_knowledge(seed, names, why):
    away, doubts = benchmark.trial(seed, names)
    assert max(map(abs, away.values())) < 3.0, why
    assert not doubts


def test_a_count_goes_on_where_it_was_stopped(tmp_path):
    file, one = tmp_path / "coverage.json", {"away": {"a": 1.0}, "cpu_s": 2.0, "source": "x"}
    file.write_text(json.dumps({"experiments": ["valve"], "sessions": {"7": one}}))
    assert benchmark.kept(file, ("valve",)) == {7: one}
    assert benchmark.kept(file, ("hose",)) == {}
    assert benchmark.kept(None, ("valve",)) == {}


def test_the_table_has_every_parameter_and_all_of_them():
    lines = benchmark.table([{"a": 1.0, "b": 3.0}, {"a": -1.0}]).splitlines()
    assert lines[2].startswith("| a | 2 | 100.0 |")
    assert lines[3].startswith("| b | 1 | 0.0 |")
    assert lines[4].startswith("| pooled | 3 | 66.7 |")
