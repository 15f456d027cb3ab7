"""A machine as an FMU: FMPy runs it as another tool would, and it goes as our own simulation does."""

import json
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_msgs_py.interfaces.topics import ACTUATOR_STATES, HEAD_JOINTS, JOINT_STATES, columns
from forest_sim.cli.main import main
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.open_loop import start_angles
from forest_sim.simulation.sensor_log import SIMULATED_TOPICS, further_topics, topic_values
from forest_sim.simulation.simulated_machine import SimulatedMachine

MACHINE, DURATION, PERIOD = "c180", 2.0, 0.005
# Only what the venv's folder holds: no .pth is read, and so our packages come from the FMU alone.
TOOL = """
import json, sys
sys.path.append(sys.argv[1])
import numpy as np
from fmpy import simulate_fmu
for asked in json.loads(sys.argv[3]):
    given = None
    if asked["voltages"]:
        names = ["time", "voltage.swing", "voltage.boom", "voltage.stick"]
        given = np.rec.fromarrays(np.loadtxt(asked["voltages"], delimiter=",", skiprows=1).T, names=names)
    try:
        rows = simulate_fmu(
            sys.argv[2], stop_time=asked["duration"], step_size=asked["step"], output_interval=asked["step"],
            input=given, start_values=asked["start_values"], debug_logging=True,
            logger=lambda environment, name, status, category, text: print(text.decode()),
        )
        np.save(asked["out"], rows)
    except Exception as error:  # FMPy raises no narrower one
        print(error)
    print("---")
print(sys.modules["forest_sim"].__file__)
"""

TWICE = """
import sys
sys.path.append(sys.argv[1])
from fmpy import simulate_fmu
for fmu in sys.argv[2:]:
    rows = simulate_fmu(fmu, stop_time=0.005, step_size=0.005, output_interval=0.005)
    print(rows[0]["ground_truth.joint_states.boom.position"])
"""


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """The FMU of a machine, from the command line."""
    path = tmp_path_factory.mktemp("fmu") / "crane.fmu"
    assert main(["export", "--fmu", MACHINE, "--out", str(path)]) == 0
    return path


@pytest.fixture
def run(fmu, tmp_path):
    """Run the FMU in a process, once for each set of start values; return the rows, and what it said.

    Of what cannot be there are none.
    """

    def simulate(duration, *starts, steps=(PERIOD,) * 9, voltages=None):
        every = {"voltages": voltages and str(voltages), "duration": duration}
        asked = [
            {**every, "step": step, "start_values": start, "out": str(tmp_path / f"rows_{number}.npy")}
            for number, (start, step) in enumerate(zip(starts, steps, strict=False))
        ]
        folder = sysconfig.get_paths()["platlib"]
        command = [sys.executable, "-S", "-c", TOOL, folder, str(fmu), json.dumps(asked)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        rows = [np.load(one["out"]) if Path(one["out"]).exists() else None for one in asked]
        return rows, done.stdout

    return simulate


@pytest.fixture(scope="module")
def voltages(tmp_path_factory):
    """Voltages that hold for a period each; FMPy interpolates between rows."""
    time = np.arange(0.0, DURATION + PERIOD, PERIOD)
    rows = np.column_stack(
        [time, 3.0 * np.sin(2.0 * time), 5.0 * np.sin(4.0 * time), 4.0 * np.cos(3.0 * time)]
    )
    path = tmp_path_factory.mktemp("voltages") / "voltages.csv"
    np.savetxt(path, rows, delimiter=",", header="time," + ",".join(AXES), comments="", fmt="%.17g")
    return path


def test_in_another_tool_it_goes_as_the_simulator_does_without_our_packages(run, voltages):
    (rows,), said = run(DURATION, {}, voltages=voltages)
    assert rows is not None, said
    assert "/resources/forest_sim/" in said
    machine, given = load_machine(MACHINE), np.loadtxt(voltages, delimiter=",", skiprows=1)
    simulator = SimulatedMachine(machine, start_angles(machine), sensor_suite(machine), PERIOD)
    further = further_topics(machine, has_loads=True)

    def told(report):
        own = {topic: of_machine(simulator) for topic, of_machine in further.items()}
        return topic_values(report, simulator.events) | own

    ours = [told(simulator.at_rest)]
    ours += [told(simulator.step(tuple(row[1:]))) for row in given[:-1]]
    compared = 0
    for topic in (*SIMULATED_TOPICS, *further):
        for place, column in enumerate(columns(topic)):
            name = f"{topic.name.replace('/', '.')}.{column}"
            estimated = topic in (JOINT_STATES, ACTUATOR_STATES) and column.endswith("velocity")
            if name in rows.dtype.names and not estimated:
                np.testing.assert_array_equal(rows[name], [values[topic][place] for values in ours], name)
                compared += 1
    assert compared > 50
    assert np.ptp(rows["joint_states.boom.position"]) > 0.1
    assert np.ptp(rows[f"ground_truth.head.{HEAD_JOINTS[0]}.position"]) > 0.01
    assert np.all(rows["ground_truth.load.mass"] == 0.0)


def test_a_tool_sets_start_noise_and_force(run):
    start = {"start.swing": 0.2, "start.boom": 0.5, "start.stick": -1.5}
    noise = [{"sensor_noise": True, "seed": seed} for seed in (1, 1, 2)]
    more = {}, *noise, {"tip_force.z": -5000.0}, {"load.mass": 500.0}
    (still, *noisy, pushed, loaded), _ = run(0.1, *(start | one for one in more))
    assert [still[0][f"ground_truth.joint_states.{axis}.position"] for axis in AXES] == [0.2, 0.5, -1.5]
    pressures = [rows["hydraulics.pressures.boom_1_valve"] for rows in noisy]
    assert np.array_equal(pressures[0], pressures[1])
    assert not np.array_equal(pressures[0], pressures[2])
    for pulled in (pushed, loaded):
        assert pulled[-1]["ground_truth.tip.pose.z"] < still[-1]["ground_truth.tip.pose.z"] - 1e-4


def test_what_cannot_be_is_told_in_the_tools_log(run):
    steps, starts, reasons = zip(
        (0.0005, {}, "a step of 0.0005 s; allowed: multiples of 0.001 s"),
        (0.005, {"start.boom": 3.0}, "boom at 171.9 deg, allowed there: "),
        (0.005, {"load.mass": -1.0}, "a log of -1 kg"),
        (0.005, {"tip_force.x": 1e9}, "'tip_force' is [1000000000.0, 0.0, 0.0]"),
        strict=True,
    )
    rows, said = run(0.01, *starts, steps=steps)
    assert rows == [None] * 4
    *told, _ = said.split("---\n")
    assert [reason in text for reason, text in zip(reasons, told, strict=True)] == [True] * 4


def test_a_process_runs_units_of_other_machines_after_the_first(fmu, tmp_path):
    other = tmp_path / "other.fmu"
    assert main(["export", "--fmu", "loader", "--out", str(other)]) == 0
    folder = sysconfig.get_paths()["platlib"]
    command = [sys.executable, "-S", "-c", TWICE, folder, str(fmu), str(other), str(fmu)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, second, third = (float(line) for line in done.stdout.splitlines())
    assert first == third == start_angles(load_machine(MACHINE))[1]
    assert second == start_angles(load_machine("loader"))[1] != first


def test_fmpys_validator_finds_nothing(fmu):
    assert validate_fmu(str(fmu)) == []


def test_a_file_that_is_there_is_left_alone(fmu, capsys):
    before = fmu.read_bytes()
    assert main(["export", "--fmu", MACHINE, "--out", str(fmu)]) == 1
    assert "exists already" in capsys.readouterr().err
    assert fmu.read_bytes() == before
