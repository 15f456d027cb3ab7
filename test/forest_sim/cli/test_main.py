"""`forest-sim` as a user meets it: files, tables, one sentence for each error, and its exit code."""

import contextlib
import errno
import json
import signal
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_bag.read.timeseries import read_bag
from forest_description.config.source_tree import shipped_machines
from forest_msgs_py.interfaces import topics
from forest_sim.cli import commands
from forest_sim.cli import main as cli
from forest_sim.cli.main import main
from forest_sim.solver import compiled_plant, state_recording

PICTURES = {"tip_path.png", "joints.png", "voltages.png", "hydraulics.png", "spools.png", "power.png"}


@pytest.fixture
def forest_sim(capsys):
    def run(*arguments):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as stopped:
            code = stopped.code
        done = capsys.readouterr()
        return code, done.out, done.err

    return run


@pytest.fixture
def no_pictures(monkeypatch):
    """Leave out what takes longest where pictures are not the claim."""
    monkeypatch.setattr("forest_sim.analysis.plots.draw_run", lambda *_: [])


def png_size(path):
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG")
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


def test_simulate_leaves_trajectory_pictures_and_summary(forest_sim, tmp_path):
    out = tmp_path / "run"
    code, told, err = forest_sim("simulate", "--duration", "2.5", "--out", out)
    assert (code, err) == (0, "")
    assert {path.name for path in out.iterdir()} == {
        *PICTURES,
        *("trajectory", "trajectory.csv", "summary.json"),
    }
    assert {path.name for path in (out / "trajectory").iterdir()} == {"trajectory_0.mcap", "metadata.yaml"}
    for name in PICTURES:
        assert png_size(out / name)[0] >= 1000
    assert all(str(path) in told for path in (out / "trajectory", out / "power.png"))
    summary = json.loads((out / "summary.json").read_text())
    assert summary["machine"] == "c180"
    assert summary["duration_s"] == 2.5
    assert summary["real_time_factor"] > 1.0
    energy = summary["energy_j"]
    assert energy["engine"] > 1000.0
    parts = sum(value for name, value in energy.items() if name != "engine")
    assert parts == pytest.approx(energy["engine"], rel=1e-4)
    assert set(summary["events"]) == {"relief_openings", "anticavitation_openings", "unconverged_stages"}
    assert summary["highest_pressure_pa"]["swing_pressure_1"] > 20e6
    assert summary["beyond_joint_limit_deg"] == {"swing": 0.0, "boom": 0.0, "stick": 0.0}


def test_simulate_takes_voltages_from_a_file(forest_sim, no_pictures, tmp_path):
    (tmp_path / "v.csv").write_text("time,swing,boom,stick\n0,0,0,0\n0.2,0,-4,0\n0.5,0,0,0\n")
    arguments = ("--voltages", tmp_path / "v.csv", "--out", tmp_path / "run", "--machine", "c180_thesis")
    code, _, _ = forest_sim("simulate", *arguments, "--rate", "100", "--step", "0.0005")
    assert code == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert (summary["duration_s"], summary["rate_hz"], summary["step_s"]) == (0.5, 100.0, 0.0005)
    assert summary["end_tip_m"][2] < summary["start_tip_m"][2] - 0.1
    assert len((tmp_path / "run" / "trajectory.csv").read_text().splitlines()) == 52


@pytest.mark.parametrize("machine", shipped_machines())
def test_every_shipped_machine_starts_where_it_can_be_without_being_told(
    forest_sim, no_pictures, tmp_path, machine
):
    code, told, err = forest_sim("equilibrium", "--machine", machine)
    assert (code, err) == (0, ""), told
    code, told, err = forest_sim("modes", "--machine", machine)
    assert (code, err) == (0, ""), told
    where = ("--duration", "0.05", "--out", tmp_path / "run")
    code, told, err = forest_sim("simulate", "--machine", machine, *where)
    assert (code, err) == (0, ""), told
    assert machine in forest_sim("check", "--help")[1]


def test_sensors_err_by_seed_and_fail_as_told(forest_sim, no_pictures, tmp_path):
    def joints(name, *options):
        code, _, _ = forest_sim("simulate", "--duration", "0.5", "--out", tmp_path / name, *options)
        assert code == 0
        return read_bag(tmp_path / name / "trajectory")

    exact, one = joints("exact"), joints("one", "--sensor-noise", "--seed", "4")
    again, other = joints("again", "--sensor-noise", "--seed", "4"), joints("other", "--sensor-noise")
    angles = [bag.series(topics.JOINT_STATES).column("boom.position") for bag in (exact, one, again, other)]
    assert np.array_equal(angles[1], angles[2])
    assert not np.array_equal(angles[0], angles[1])
    assert not np.array_equal(angles[1], angles[3])
    np.testing.assert_allclose(angles[1], angles[0], atol=0.02)
    truths = [bag.series(topics.GROUND_TRUTH_JOINT_STATES).values for bag in (exact, one)]
    assert np.array_equal(*truths)
    blind = joints("blind", "--sensor-faults", "swing_flow: absent")
    assert blind.series(topics.FLOWS).labels == ("stick_1",)


def test_cold_oil_is_another_machine(forest_sim):
    cold, warm = (forest_sim("modes", "--temperature", degrees)[1] for degrees in ("0", "40"))
    assert cold != warm
    code, _, err = forest_sim("check", "c180_hoses", "--temperature", "400")
    assert code == 2
    assert "allowed: -50 .. 150 degC" in err
    code, _, err = forest_sim("modes", "--machine", "c180_thesis", "--temperature", "20")
    assert code == 1
    assert err == "forest-sim: c180_thesis has no oil section, so --temperature means nothing to it\n"


def test_pumps_is_one_command(forest_sim, tmp_path):
    code, told, _ = forest_sim("pumps", "--duration", "2", "--out", tmp_path / "pumps")
    assert code == 0
    assert told.splitlines()[1].split()[0] == "engine"
    assert png_size(tmp_path / "pumps" / "pumps.png")[0] == 1000
    result = json.loads((tmp_path / "pumps" / "pumps.json").read_text())
    assert len(result["energy_j"]) == 4


def test_machines_are_compared_under_the_same_voltages(forest_sim, tmp_path):
    out, path = tmp_path / "compared", tmp_path / "step.csv"
    path.write_text("time,swing,boom,stick\n0,0,4,0\n0.3,0,0,0\n", "utf-8")
    code, told, _ = forest_sim(
        *("compare", "c180_hoses", "c180", "--voltages", path, "--duration", "0.6", "--out", out),
        *("--loads", "900 kg from 0.3 s"),
    )
    assert code == 0
    ends = {line.split()[0]: float(line.split()[1]) for line in told.splitlines()[1:3]}
    assert list(ends) == ["c180_hoses", "c180"]
    assert ends["c180_hoses"] > ends["c180"] + 0.2  # deg: it sags on the oil of its chambers
    assert png_size(out / "compare.png")[0] == 1000


@pytest.mark.usefixtures("no_pictures")
def test_logs_are_carried_as_the_schedule_says_and_the_bag_and_the_summary_tell_of_it(forest_sim, tmp_path):
    out, told = tmp_path / "carried", {}
    for name, loads in (("log", ("--loads", "300 kg from 0.1 s; 0 kg from 0.3 s")), ("empty", ())):
        code, table, _ = forest_sim("simulate", "--duration", "0.4", "--out", out / name, *loads)
        assert code == 0
        told[name] = (
            json.loads((out / name / "summary.json").read_text()),
            read_bag(out / name / "trajectory"),
        )
        assert ("links: joining" in table) == (name == "log")
    carried = told["log"][1].series(topics.GROUND_TRUTH_LOAD).values[:, 0]
    assert carried.tolist() == [0.0] * 21 + [300.0] * 40 + [0.0] * 20
    assert set(told["log"][0]["links_j"]) >= {"actuators", "joining", "carried_off", "unaccounted"}
    assert "links_j" not in told["empty"][0]
    assert topics.GROUND_TRUTH_LOAD.name not in {name.lstrip("/") for name in told["empty"][1].topics}


def test_equilibrium_tells_pressures_that_hold_the_crane(forest_sim):
    code, told, _ = forest_sim("equilibrium", "--tip", "5.5", "0", "1", "--json")
    result = json.loads(told)
    assert code == 0
    boom = result["boom"]
    force = 1.824e-2 * boom["pressure_1_pa"] - 1.368e-2 * boom["pressure_2_pa"]
    assert boom["cylinder_force_n"] == pytest.approx(force)
    assert boom["joint_torque_nm"] > 4e4
    code, table, _ = forest_sim("equilibrium")
    assert f"{boom['pressure_1_pa'] / 1e6:.2f} MPa" in table


def test_modes_at_a_pose_and_as_json(forest_sim):
    code, table, _ = forest_sim("modes", "--machine", "c180_hoses", "--angles", "0", "30", "-90")
    assert code == 0
    assert [line.split()[2] for line in table.splitlines()[2:5]] == ["swing", "boom", "stick"]
    code, told, _ = forest_sim("modes", "--angles", "0", "30", "-90", "--voltages", "-5", "0", "0", "--json")
    assert code == 0
    assert all(mode["damping_ratio"] > 0.0 for mode in json.loads(told)["modes"])


def test_modes_over_the_workspace(forest_sim, tmp_path):
    """On the widest grid that is allowed, which has a single row."""
    code, told, _ = forest_sim("modes", "--map", "--spacing", "2", "--out", tmp_path / "map")
    assert code == 0
    header, *rows = (tmp_path / "map" / "modes.csv").read_text().splitlines()
    assert header.startswith("reach[m],height[m],swing_frequency[Hz],swing_damping[1]")
    assert f"{len(rows)} poses" in told
    assert png_size(tmp_path / "map" / "modes.png")[0] == 1300


def test_check_tells_components_and_figures(forest_sim):
    code, told, _ = forest_sim("check", "c180_hoses")
    assert code == 0
    for part in (
        "pressure_compensated",
        "-36.7 ..   72.0 deg",
        "reach  -0.53 .. 7.78 m",
        "one lump stands for",
    ):
        assert part in told


def test_check_warns_of_a_load_that_the_pump_cannot_hold(forest_sim, tmp_path):
    file = tmp_path / "weak.yaml"
    source = 'source: "assumed: test"'
    file.write_text(
        f"based_on: c180_thesis\npump:\n  supply_pressure: {{value: 10, unit: MPa, {source}}}\n", "utf-8"
    )
    code, told, _ = forest_sim("check", file)
    assert code == 0
    assert "boom: holding the crane still takes" in told
    assert "more than the pump's 10.0 MPa" in told


def test_check_of_an_unusable_file_says_why(forest_sim, tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text("based_on: c180_hoses\nboom:\n  stroke: {value: 36, unit: kg, source: x}\n")
    code, told, err = forest_sim("check", file)
    assert (code, told) == (1, "")
    assert err.startswith(f"forest-sim: {file}:3: boom.stroke: unit 'kg' does not fit; allowed: ")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (("simulate", "--out", "{new}", "--start-tip", "9", "0", "1"), 1, "out of reach; allowed: reach"),
        (("simulate", "--out", "{new}", "--step", "0.002"), 1, "a step of 0.002 s at 200 Hz; allowed"),
        (("simulate", "--out", "{new}", "--machine", "c190"), 1, "no machine named 'c190'"),
        (("simulate", "--out", "{old}"), 1, "exists already; choose another --out or remove it"),
        (("simulate", "--out", "{new}", "--voltages", "nothing"), 2, "allowed: step, chirp, thesis or a CSV"),
        (("simulate", "--out", "{new}", "--duration", "0"), 2, "'0'; allowed: 0.01 .. 604800 s"),
        (("simulate", "--out", "{new}", "--voltages", "chirp", "--chirp-to", "0.05"), 1, "0 < from < to"),
        (("simulate",), 2, "--out"),
        (("simulate", "--out", "{new}", "--sensor-faults", "eyes: absent"), 2, "there is no sensor 'eyes'"),
        (
            ("simulate", "--out", "{new}", "--loads", "a ton"),
            2,
            "--loads: 'a ton' is no load; allowed: MASS kg",
        ),
        (("simulate", "--out", "{new}", "--seed", "-1"), 2, "allowed: 0 .. 2147483647, whole"),
        (("pumps", "--out", "{old}"), 1, "exists already"),
        (
            ("compare", "c180_hoses", "--out", "{new}"),
            2,
            "one machine compares with nothing; allowed: two or more",
        ),
        (("equilibrium", "--tip", "1", "0", "1"), 1, "it needs the boom at"),
        (("equilibrium", "--angles", "0", "80", "-90"), 1, "boom at 80.0 deg, allowed there: -36.7 .. 72.0"),
        (("equilibrium", "--angles", "0", "x", "-90"), 2, "'x'; allowed: -720 .. 720 deg"),
        (("modes", "--voltages", "0", "11", "0"), 1, "boom's spool at 11 V; allowed: up to 10 V, its rating"),
        (("pumps", "--machine", "forwarder", "--out", "{new}"), 1, "does not run on each of the four pumps"),
        (("modes", "--map"), 2, "--map needs --out DIR"),
        (("modes", "--out", "{new}"), 2, "--out goes with --map only"),
        ((), 2, "COMMAND"),
    ],
)
def test_errors_are_one_sentence_that_says_what_is_allowed(forest_sim, tmp_path, arguments, code, complaint):
    (tmp_path / "old" / "run").mkdir(parents=True)
    places = {"new": tmp_path / "new", "old": tmp_path / "old"}
    done, _, err = forest_sim(*(argument.format(**places) for argument in arguments))
    assert done == code
    assert complaint in err.splitlines()[-1]
    assert code == 2 or len(err.splitlines()) == 1
    assert not (tmp_path / "new").exists()


def test_a_bad_voltage_file_is_told_by_line(forest_sim, tmp_path):
    (tmp_path / "v.csv").write_text("time,swing,boom,stick\n0,0,zero,0\n")
    code, _, err = forest_sim("simulate", "--voltages", tmp_path / "v.csv", "--out", tmp_path / "run")
    assert code == 1
    assert err == f"forest-sim: {tmp_path}/v.csv:2: boom is 'zero'; allowed: -100 .. 100 V\n"


def test_without_llvm_it_runs_and_says_once_how_to_be_faster(forest_sim, no_pictures, tmp_path, monkeypatch):
    for module in ("solver.compiled_plant", "cli.commands"):
        monkeypatch.setattr(f"forest_sim.{module}.can_compile", lambda: False)
    assert compiled_plant.fastest_record() is state_recording.record
    code, _, err = forest_sim("simulate", "--duration", "0.2", "--out", tmp_path / "run")
    assert code == 0
    assert err.count("pip install 'forest-crane[fast]'") == 1
    assert len(err.splitlines()) == 1


def test_a_full_disk_is_told_with_the_place(forest_sim, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("forest_sim.simulation.trajectory_files.TrajectoryFiles.write", full)
    code, _, err = forest_sim("simulate", "--duration", "0.2", "--out", tmp_path / "run")
    assert code == 1
    assert err == f"forest-sim: {tmp_path}/run: No space left on device\n"


def test_a_run_that_is_terminated_leaves_a_bag_that_opens(tmp_path):
    """`timeout` and batch systems say SIGTERM, which used to leave an MCAP without index or metadata."""
    arguments = ("--duration", "100000", "--out", str(tmp_path / "run"))
    command = [sys.executable, "-m", "forest_sim.cli.main", "simulate", *arguments]
    run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    rows = tmp_path / "run" / "trajectory.csv"
    for _ in range(6000):
        if (rows.is_file() and rows.stat().st_size > 300_000) or run.poll() is not None:
            break
        with contextlib.suppress(subprocess.TimeoutExpired):
            run.wait(0.05)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=300.0)
    assert run.returncode == 130, err
    assert "what was written until now is kept" in err
    assert len(read_bag(tmp_path / "run" / "trajectory").series(topics.JOINT_STATES).values) > 10


def test_stopping_a_run_keeps_what_was_written(forest_sim, tmp_path, monkeypatch):
    def stop(_progress, simulated):
        if simulated >= 1.0:
            raise KeyboardInterrupt

    monkeypatch.setattr(commands.Progress, "__call__", stop)
    code, _, err = forest_sim("simulate", "--out", tmp_path / "run")
    assert code == 130
    assert "what was written until now is kept" in err
    assert (tmp_path / "run" / "trajectory" / "metadata.yaml").is_file()


@pytest.mark.parametrize("command", ["simulate", "pumps", "compare", "equilibrium", "modes", "check"])
def test_every_command_has_help_with_its_units(forest_sim, command):
    code, told, _ = forest_sim(command, "--help")
    assert code == 0
    assert cli.EPILOGUE.split(".")[0].split()[0] in told
