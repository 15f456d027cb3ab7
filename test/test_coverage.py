"""The counting behind `benchmarks/coverage.py`, and a reduced run of what it counts."""

import importlib.util
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
    away = benchmark.trial(3, ("spool_lag",))
    assert set(away) == {"valve.spool_bandwidth"}
    assert all(math.isfinite(z) and abs(z) < 4.0 for z in away.values())
