import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident import session_bag
from forest_ident.ident_cli import main
from forest_ident.ident_experiment import experiment
from forest_ident.session import SessionError


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    out = tmp_path_factory.mktemp("ident") / "bags"
    assert main(["experiment", "spool_lag", "--seed", "2", "--out", str(out)]) == 0
    return out


def test_a_bag_gives_the_session_back(bags):
    session, again = (
        experiment("spool_lag", load_machine("c180"), seed=2),
        session_bag.read(bags / "spool_lag"),
    )
    assert (again.name, again.facts) == (session.name, session.facts)
    assert np.array_equal(again.voltages, session.voltages)
    assert set(again.readings) == set(session.readings)
    for channel, column in session.readings.items():
        assert np.array_equal(again.readings[channel], column), channel


def test_a_fit_writes_a_machine_that_loads_and_a_report_that_stands_alone(bags, tmp_path, capsys):
    out, report = tmp_path / "found.yaml", tmp_path / "report"
    assert main(["fit", str(bags), "--out", str(out), "--report", str(report)]) == 0
    assert load_machine(out).valve.spool_bandwidth == pytest.approx(12.0, rel=0.01)
    page = (report / "report.html").read_text("utf-8")
    assert "spool_bandwidth" in page
    assert "src='data:" in page
    assert "http" not in page
    assert "spool_bandwidth" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["experiment", "flying", "--out", "x"], "no experiment 'flying'"),
        (["experiment", "valve"], "--out DIR is missing"),
        (["fit", "nowhere", "--out", "x.yaml"], "no bag there"),
        (["fit", "nowhere", "--out", "x.txt"], "ends in .yaml"),
        (["validate", "nowhere", "--model", "c180"], "nowhere"),
    ],
)
def test_bad_input_gets_one_sentence(arguments, sentence, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert len(said.strip().splitlines()) == 1


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
