"""The benchmark runs, says what it must, and compares equal things. No time is asserted."""

import importlib
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import appendix_b
import numpy as np
import pytest

pytest.importorskip("numba")

from forest_compile.frontend import translate
from forest_description.hydraulics.valve_characteristic import edges
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
FIELDS = {"real_time_factor", "error_rad", "error_mpa", "cpu_seconds", "start_cold_s", "start_cached_s"}


@pytest.fixture
def benchmark(monkeypatch):
    """Imports a module of benchmarks/."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    yield importlib.import_module
    for name in [
        n
        for n in sys.modules
        if n.split(".")[0]
        in {
            "plant",
            "peers",
            "work",
            "reference",
            "compilers",
            "components",
            "recorder",
            "closed_loop",
            "lockstep",
            "stopping",
            "energy",
            "killed",
        }
    ]:
        del sys.modules[name]


def test_short_work_runs_in_both_modes_and_reports_all_fields(tmp_path):
    report = tmp_path / "report.json"
    options = ["--seconds", "0.2", "--warm", "--peers", "lsoda-numpy"]
    command = [sys.executable, BENCHMARKS / "plant.py", *options]
    done = subprocess.run([*command, "--json", report], check=True, capture_output=True, text=True)
    rows = json.loads(report.read_text())["rows"]
    assert [(r["contestant"], r["mode"]) for r in rows] == [
        ("ours", "open"), ("ours", "held"), ("ours-even", "open"), ("ours-even", "held"),
        ("lsoda-numpy", "open"), ("lsoda-numpy", "held"),
    ]  # fmt: skip
    for row in rows:
        assert row.keys() >= FIELDS
        assert row["error_rad"] <= 1e-5
        assert row["error_mpa"] <= 0.04
        assert row["name"] in done.stdout


def test_peer_that_is_not_installed_is_named(benchmark):
    plant, peers = benchmark("plant"), benchmark("peers")
    peers.CONTESTANTS["ghost"] = peers.Contestant("Ghost", "ghost", ("scipy", "no_such_solver"), {})
    rows = plant.run_contestant("ghost", ["open"], 0.1, None)
    assert rows == [{"contestant": "ghost", "name": "Ghost", "mode": "open", "missing": ["no_such_solver"]}]
    assert "missing: no_such_solver" in "".join(plant.table(rows))


def test_peers_equations_are_those_of_appendix_b(benchmark):
    equations = benchmark("peers.equations")
    machine, rng = load_machine("c180_thesis"), np.random.default_rng(7)
    for _ in range(50):
        y = rng.uniform(-1.0, 1.0, 18)
        y[[6, 12]] = rng.uniform(-0.5, 1.0), rng.uniform(-2.0, -0.9)
        volts = rng.uniform(1.5, 9.0, 3)
        c_r = [edges(v, machine.valve.law).supply_1 for v in volts for _ in range(2)]
        wave = [x for v in volts for x in (v, 0.0, 0.0, 0.0)]
        expected = appendix_b.state_derivative(y * equations.SCALE, c_r, machine.pump.supply_pressure)
        actual = equations.right_hand_side(0.0, y, wave) * equations.SCALE
        np.testing.assert_allclose(actual / equations.SCALE, expected / equations.SCALE, rtol=1e-9, atol=1e-9)


def test_negative_voltage_swaps_supply_and_tank(benchmark):
    valve, supply = benchmark("peers.equations").valve, benchmark("peers.equations").supply
    p_1, p_2, q_1, q_2 = 0.7, 1.1, 0.2, -0.1
    forward, backward = valve(3.0, p_1, p_2, q_1, q_2, 1.0, 1.0), valve(-3.0, p_1, p_2, q_1, q_2, 1.0, 1.0)
    np.testing.assert_allclose(np.subtract(forward, backward), [supply, supply])


def test_input_opens_valves_by_steps_but_closes_them_smoothly(benchmark):
    work = benchmark("work")
    volts = work.step_voltages(work.open_loop(), 50)  # every 0.1 ms
    jump = np.diff(volts, axis=0)
    sudden = np.abs(jump) > 0.1
    assert np.all(sudden.any(axis=0)), "every axis has a step"
    assert np.all(np.abs(volts[:-1][sudden]) <= load_machine("c180_thesis").valve.deadband_voltage)


def test_held_commands_are_the_open_loop_s_at_every_sample(benchmark):
    work = benchmark("work")
    held = work.held(0.6)
    sampled = np.array([segment.wave[[0, 4, 8]] for segment in held.segments])
    np.testing.assert_array_equal(sampled, work.held_commands(work.open_loop(0.6)))
    np.testing.assert_array_equal(work.step_voltages(held, 5)[::5], sampled)


def test_a_component_that_is_cut_out_was_doing_nothing(benchmark):
    """The kernel without it believes the numbers that `c180_thesis` has, and no others."""
    components = benchmark("components")
    every = [part for parts in components.COMPONENTS.values() for part in parts]
    entry, parameters = components.entry_without(every)
    thesis, hoses = (plant_parameters(load_machine(name)) for name in ("c180_thesis", "c180_hoses"))
    assert eval(parameters, entry.names, {"p": thesis}) == thesis
    assert eval(parameters, entry.names, {"p": hoses}) != hoses
    assert translate.llvm_ir(entry)  # what is left is a kernel, too


def test_a_component_that_is_taken_away_was_there(benchmark):
    components = benchmark("components")
    whole = [plant_parameters(load_machine(name)) for name in components.FULL]
    for less in components.WITHOUT.values():
        assert any(less(p) != p for p in whole)
        assert all(less(less(p)) == less(p) for p in whole)


def test_recorder_s_table_compares_with_the_bare_node(benchmark):
    row = {"sent": 1000, "heard": 1000, "memory_growth_mb": 0.0}
    rows = [
        row | {"listener": "bare", "microseconds_per_message": 80.0},
        row | {"listener": "recorder zstd", "microseconds_per_message": 20.0, "heard": 998},
    ]
    *_, bare, recorder = benchmark("recorder").table(rows).splitlines()
    assert bare == "| bare | 1000 | 0 | 80.0 | 1.00 | 0.0 MB |"
    assert recorder == "| recorder zstd | 1000 | 2 | 20.0 | 0.25 | 0.0 MB |"


def test_killed_recorders_are_told_by_what_they_lost_and_how_many_left_nothing(benchmark):
    rows = [{"load": 4, "first": 0.0, "span": 1.5, "lost": [0.1, None, 0.02, 0.03]}]
    assert benchmark("killed").table(rows).endswith("| 4 | 0 to 1.5 | 4 | 1 | 0.030 | 0.100 | 0.100 |")


def test_the_closed_loops_benchmark_compares_equal_loops_and_tells_both_factors(benchmark):
    loop = benchmark("closed_loop")
    row = loop.compare(load_machine("c180_hoses"), "vertical", 1)
    assert row.keys() >= {"compiled", "interpreted", "with_set_up", "plan_seconds"}
    assert "| vertical | 8." in "".join(loop.table([row]))


def test_lockstep_s_table_counts_the_steps_between_two_runs(benchmark):
    told = benchmark("lockstep").table({"simulator": 1.0}, {"simulator": 3.0, "recorder": 1.0}, 1000, 2.5)
    assert "| simulator | 2.00 |\n| recorder | 1.00 |\n| together | 3.00 |" in told
    assert told.endswith("A step: 2.00 ms on the wall, 2.50 x real time.")


def test_a_random_motion_that_is_let_go_is_judged_and_told(benchmark):
    stopping = benchmark("stopping")
    ended = stopping.stops("c180_hoses", stopping.ROWS["exact"], 3)
    assert all(0.0 < stop.time <= stopping.WITHIN and stop.way < 0.070 for stop in ended)
    seconds, way, beside, over, rocks, rock, peak = stopping.cells(ended)
    assert [text.count("/") for text in (seconds, way, beside, rock, peak)] == [2] * 5
    assert float(peak.split(" / ")[2]) < 0.7
    assert over == "0 / 0 of 3"
    assert rocks.endswith(" %")
    assert stopping.summary({"exact": ended})["shut_s"] <= stopping.WITHIN


def test_a_random_motion_that_is_stopped_at_once_goes_less_far(benchmark):
    stopping = benchmark("stopping")
    ended = stopping.stops("c180_hoses", stopping.ROWS["emergency"], 3)
    assert all(stop.shut == 0.0 and stop.way < 0.045 and stop.beside < 0.025 for stop in ended)
    assert any(stop.later > stopping.SLOW for stop in ended)
    # Speed over the least angular frequency of the swing on one hose: 0.5 m/s at 2.3 Hz, the arm out.
    assert all(stop.rock < 0.035 for stop in ended)


class Sunk(NamedTuple):
    depth: float
    speed: float


def sinks(state, p, dt):
    speed = state.speed + dt * (p[0] - math.sin(state.depth))
    return Sunk(state.depth + dt * speed, speed)


def replaces(state, p, dt):
    return state._replace(depth=state.depth + dt * p[0])


def test_both_compilers_get_the_same_laws_and_a_refusal_is_told(benchmark):
    compilers = benchmark("compilers")
    for step in (sinks, replaces):
        law = compilers.Law(step, "state = step(state, p, dt)", Sunk(0.0, 0.5), (0.0,), (0.3,), 0.01)
        compilers.LAWS[step.__name__] = lambda law=law: law
    ours, numba, taken, refused = (
        compilers.measure(law, name) for law in ("sinks", "replaces") for name in ("ours", "numba")
    )
    assert ours["state"] == numba["state"] != (0.0, 0.5)
    assert ours.keys() == numba.keys() == taken.keys()
    assert refused["refused"] == "TypingError: Unknown attribute '_replace' of type Sunk"
    lines = list(compilers.table([ours, numba, taken, refused]))
    assert ["to compile" in line for line in lines] == [False, True, False, False]
    assert "| Numba | refuses: TypingError" in lines[3]
    sentence = "sinks: after 100 steps no number differs by more than 0e+00 of itself"
    assert list(compilers.differences([ours, numba, taken, refused])) == [sentence]


def test_every_codec_is_measured_on_the_same_bytes(benchmark):
    pytest.importorskip("rclpy")
    pytest.importorskip("mcap_ros2")
    table = benchmark("serialization").measured(10)
    assert list(table) == ["batch", "packing", "rosbags", "rclpy", "mcap-ros2-support"]
    assert all(decode >= 0.0 for _, decode in table.values())


@pytest.mark.parametrize("shape", ["random", "slams", "squares"])
def test_the_energy_benchmark_closes_on_the_crane_as_it_is_built(benchmark, shape):
    energy = benchmark("energy")
    total, failed = energy.run("c180", getattr(energy, shape), 5.0)
    assert failed == 0
    assert abs(energy.unaccounted(total)) < 0.005 * total.engine
