import os
import subprocess
import sys

import numpy as np
import pytest
from processes import ForkedNode

pytest.importorskip("rclpy")

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import SessionError
from forest_study.experiments.forest_ident_main import main

TRIAL = 6.0  # [s] of a rig's experiment
SHORT = 3.0  # [s] of the crane's


@pytest.fixture(scope="module")
def bags(tmp_path_factory, session_domain_id):
    """A rig's experiment as the graph makes it, with the sensors of Table 4.2."""
    out = tmp_path_factory.mktemp("ident")
    asked = ["experiment", "spool_lag", "--trial", str(TRIAL), "--seed", "2", "--out", str(out / "bags")]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(session_domain_id)}
    command = ForkedNode("forest_study.experiments.forest_ident_main", asked, out / "log", environment)
    assert command.ended() == 0, command.text()
    return out / "bags"


def same(one, other):
    """Whether two sessions are the same, but for the last digit of what is derived of the states."""
    assert set(one.readings) == set(other.readings)
    assert np.array_equal(one.voltages, other.voltages)
    for channel, column in one.readings.items():
        exact = channel.endswith(("resolver", "spool", "flow", "temperature"))
        scale = 0.0 if exact else 1e-14 * np.abs(column).max()
        assert np.abs(other.readings[channel] - column).max() <= scale, channel


def test_a_graph_in_lockstep_records_what_the_laws_say_without_one(domain_id, tmp_path, start_process):
    out = tmp_path / "bags"
    asked = ("experiment", "validation", "--exact", "--trial", str(SHORT), "--out", str(out))
    command = start_process(["-m", "forest_study.experiments.forest_ident_main", *asked])
    assert command.ended() == 0, command.text()
    alone = experiment("validation", load_machine("c180_hoses"), exact=True, longest=SHORT)
    session = session_bag.read(out / "validation")
    assert (session.name, session.metadata) == ("validation", {"exact_sensors": 1.0})
    assert np.abs(session.voltages).max(axis=0).min() > 1.0
    same(alone, session)
    assert "by hand: Crane without load" in command.text()


def test_without_a_graph_the_bag_gives_the_session_back(tmp_path):
    out = tmp_path / "bags"
    asked = ("experiment", "spool_lag", "--direct", "--trial", str(TRIAL), "--seed", "2", "--out", str(out))
    assert main(asked) == 0
    session, again = (
        experiment("spool_lag", load_machine("c180_hoses"), seed=2, longest=TRIAL),
        session_bag.read(out / "spool_lag"),
    )
    assert (again.name, again.metadata) == (session.name, session.metadata)
    assert np.array_equal(again.voltages, session.voltages)
    assert set(again.readings) == set(session.readings)
    for channel, column in session.readings.items():
        assert np.array_equal(again.readings[channel], column), channel


def test_a_rig_in_the_graph_is_driven_as_without_it_and_has_its_second_meter_behind_the_hose(bags):
    session = session_bag.read(bags / "spool_lag")
    alone = experiment("spool_lag", load_machine("c180_hoses"), seed=2, longest=TRIAL)
    assert np.array_equal(session.voltages, alone.voltages)
    for meter in ("swing_flow", "stick_flow"):
        assert np.abs(session.column(meter) - alone.column(meter)).max() < 1.5e-5  # [m^3/s], ten deviations
    assert np.abs(session.column("stick_flow")).max() > 1e-3


def test_a_fit_writes_a_machine_that_loads_and_a_report_that_stands_alone(bags, tmp_path, capsys):
    out, report = tmp_path / "found.yaml", tmp_path / "report"
    assert main(["fit", str(bags), "--out", str(out), "--report", str(report)]) == 0
    assert load_machine(out).valve.spool_bandwidth == pytest.approx(12.0, rel=0.01)
    page = (report / "report.html").read_text("utf-8")
    assert "spool_bandwidth" in page.replace("<wbr>", "")
    assert 'src="data:' in page
    assert "http" not in page
    assert "spool_bandwidth" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["experiment", "flying", "--out", "x"], "no experiment 'flying'"),
        (["experiment", "valve"], "--out DIR is missing"),
        (["fit", "nowhere", "--out", "x.yaml"], "no bag there"),
        (["fit", "nowhere", "--out", "x.txt"], "ends in .yaml"),
        (["validate", "nowhere", "--model", "c180_hoses"], "nowhere"),
    ],
)
def test_bad_input_gets_one_sentence(arguments, sentence, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert len(said.strip().splitlines()) == 1


def test_the_program_computes_in_one_thread():
    """On a computer of one core it always does."""
    code = (
        "import os, forest_study.experiments.forest_ident_main\n"
        "import numpy as np\n"
        "np.ones((500, 500)) @ np.ones((500, 500))\n"
        "print(len(os.listdir('/proc/self/task')))"
    )
    environment = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    said = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True)
    assert said.stdout.split() == [b"1"], said.stderr


def test_the_list_tells_what_a_person_does_by_hand(capsys):
    assert main(["experiment", "list"]) == 0
    said = capsys.readouterr().out
    for name in ("valve", "hose_laminar", "motor_internal", "deadband_boom", "validation"):
        assert f"\n{name}:" in said
    assert "vessel" in said


def test_an_unusable_experiment_file_is_named(bags, tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    for file in (bags / "spool_lag").iterdir():
        (bag / file.name).write_bytes(file.read_bytes())
    (bag / "experiment.yaml").write_text("experiment: valve\nfacts: {a: 3}\n", encoding="utf-8")
    with pytest.raises(SessionError, match=r"experiment\.yaml: not usable"):
        session_bag.read(bag)
