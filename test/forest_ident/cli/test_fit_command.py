"""`forest-ident fit` with what people give it: one sentence, before any work is lost; nothing overwritten."""

import dataclasses
import re

import numpy as np
import pytest
import yaml

from forest_description.machine import load_machine
from forest_ident.cli.fit_command import found as bags_at
from forest_ident.cli.fit_tables import against
from forest_ident.cli.verbs import main
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.experiments import experiment_metadata
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import Session
from forest_ident.output_error.fit_problem import Channel, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.refinement import data_quality, identification
from forest_ident.refinement.result import Result

C180 = load_machine("c180_hoses")


@pytest.fixture(scope="module")
def sessions():
    """Records by name, all but the calibration too short for more than a refusal."""
    length = {"valve": 10.0, "hose": 6.0, "motor_external": 4.0, "calibration": 40.0, "damping_boom": 2.5}
    return {name: experiment(name, C180, seed=1, longest=seconds) for name, seconds in length.items()}


@pytest.fixture(scope="module")
def bags(sessions, tmp_path_factory):
    """Those records as bags, and what may go wrong with one."""
    folder, valve = tmp_path_factory.mktemp("records"), sessions["valve"]
    warm = {
        name: y + 40.0 if "temperature" in name else y for name, y in sessions["calibration"].readings.items()
    }
    odd = {
        "forward_only": valve.part(0, 2000),
        "hardly_any": valve.part(0, 3),
        "another_machines": dataclasses.replace(valve, name="valve_boom"),
        "without_facts": dataclasses.replace(sessions["hose"], metadata={}),
        "another_piece": dataclasses.replace(
            sessions["hose"], metadata={**sessions["hose"].metadata, "hose_length": 2.0}
        ),
        "standing": sessions["damping_boom"].part(0, 150),
        "no_ice": dataclasses.replace(sessions["calibration"], readings=warm),
        "held_out": dataclasses.replace(valve.part(0, 200), name="motion"),
    }
    for name, session in {**sessions, **odd}.items():
        session_bag.write(session, folder / name)
    return folder


def fit(bags, tmp_path, capsys, *names, start="c180_hoses"):
    """Give exit code, what was printed, and what was said of errors."""
    paths = [str(bags / name) for name in names]
    code = main(["fit", *paths, "--start", start, "--linear", "--out", str(tmp_path / "found.yaml")])
    said = capsys.readouterr()
    return code, said.out, said.err


@pytest.mark.parametrize(
    ("record", "sentence"),
    [
        ("forward_only", r"valve: the record holds \d steady openings forward and 0 backward"),
        (
            "hardly_any",
            "0 backward with flow above the meter's floor; it takes 4",
        ),
        (
            "another_machines",
            "c180_hoses has no experiment 'valve_boom'; allowed: calibration, valve, spool_lag",
        ),
        ("without_facts", "no fact hose_axis, laminar; it takes hose_axis"),
        ("another_piece", r"a piece of 2 m; it takes the 4 m of hose\.length"),
        ("hose", "hose: the record holds 3 steady flows; it takes 4 or more"),
        ("motor_external", "motor_external: the record holds 4 s; it takes 20 s or more"),
        (
            "standing",
            r"damping_boom: the record holds a motion over 0\.00\d rad; it takes more",
        ),
        ("no_ice", r"motor_temperature reads 313\.\d K in ice; allowed: 273\.15 K within 25 K"),
        ("held_out", "nothing for a machine file from motion"),
    ],
)
def test_a_record_that_does_not_hold_its_experiment_is_refused_by_name(
    record, sentence, bags, tmp_path, capsys
):
    code, _, said = fit(bags, tmp_path, capsys, record)
    assert code == 1
    assert len(said.strip().splitlines()) == 1
    assert re.search(sentence, said), said
    assert not (tmp_path / "found.yaml").exists()


def test_a_calibration_alone_makes_a_machine_file(bags, tmp_path, capsys):
    code, told, _ = fit(bags, tmp_path, capsys, "calibration")
    assert code == 0
    assert "sensors.calibration.tank_temperature" in told
    found = load_machine(tmp_path / "found.yaml").sensors.calibration
    assert found.tank_temperature.offset != 0.0
    assert found.stick_pressure_2_valve.offset != 0.0


def test_the_same_record_twice_is_no_second_witness(bags, tmp_path, capsys):
    code, _, said = fit(bags, tmp_path, capsys, "calibration", f"../{bags.name}/calibration")
    assert code == 1
    assert "hold the same record of calibration; allowed: each once" in said


def test_a_bag_that_is_not_used_is_told(bags, tmp_path, capsys):
    code, told, _ = fit(bags, tmp_path, capsys, "calibration", "held_out")
    assert code == 0
    assert f"held out, not used: {bags / 'held_out'} (motion)" in told


def test_what_cannot_be_written_is_said_before_the_fit_and_nothing_is_overwritten(
    bags, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(identification, "identify", lambda *_args, **_options: pytest.fail("too late"))
    mine = tmp_path / "found.yaml"
    mine.write_text("based_on: c180_hoses\n")
    code, _, said = fit(bags, tmp_path, capsys, "valve", start=str(mine))
    assert (code, mine.read_text()) == (1, "based_on: c180_hoses\n")
    assert "found.yaml exists already; choose another --out or remove it" in said
    for option, path in (("--out", "found.yaml/x.yaml"), ("--report", "found.yaml/report")):
        asked = ["fit", str(bags / "valve"), "--out", str(tmp_path / "new.yaml")]
        assert main([*asked, option, str(tmp_path / path)]) == 1
        assert f"{option} {tmp_path / path}: cannot be written" in capsys.readouterr().err


def test_a_choice_without_a_record_that_decides_is_refused_before_the_fit(
    bags, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(identification, "identify", lambda *_args, **_options: pytest.fail("too late"))
    asked = ["fit", str(bags / "valve"), "--allow", "friction", "--out", str(tmp_path / "found.yaml")]
    assert main(asked) == 1
    assert "--allow friction: no record is held out to decide by" in capsys.readouterr().err


@pytest.mark.parametrize("file", ["bag_0.mcap", "bag_0.db3", "bag_0.mcap.zstd", "bag_0.db3.zstd"])
def test_a_record_of_rosbag2s_is_a_bag_in_each_of_its_kinds(file, tmp_path):
    bag = tmp_path / "records" / "valve"
    bag.mkdir(parents=True)
    (bag / file).touch()
    (tmp_path / "records" / "log").mkdir()
    assert bags_at([tmp_path / "records"]) == bags_at([bag]) == [bag]
    assert bags_at([bag / file]) == [bag / file]


def test_a_bag_that_was_cut_off_is_used_and_said_to_be(bags, sessions, tmp_path):
    cut = tmp_path / "cut"
    session_bag.write(sessions["calibration"], cut)
    file = next(cut.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: int(0.9 * file.stat().st_size)])
    session = session_bag.read(cut)
    assert not session.whole
    assert session_bag.read(bags / "calibration").whole
    result = identification.identify(C180, [session], refine=False)
    assert data_quality.cut_off(session) in result.remarks


@pytest.mark.parametrize(
    ("name", "told", "sentence"),
    [
        ("case_drain_volme", {"value": 1.0, "unit": "m3"}, "no fact 'case_drain_volme'; allowed: case_drain"),
        ("case_drain_volume", {"value": 0.7, "unit": "kg"}, "unit 'kg'; allowed: m3, L"),
        ("case_drain_volume", {"value": -0.7, "unit": "L"}, r"-0\.7; allowed: 0 \.\. 1000"),
        ("hose_axis", {"value": 3, "unit": 1}, r"3; allowed: whole numbers 0 \.\. 2"),
        ("hose_axis", {"value": 0.5, "unit": 1}, "whole numbers"),
        ("ice_until", {"value": "late", "unit": "s"}, "'late'; allowed"),
        ("ice_until", 20.0, r"20\.0; allowed: \{value: 1\.0, unit: s\}"),
    ],
)
def test_a_fact_that_cannot_be_is_refused_with_what_is_allowed(name, told, sentence):
    with pytest.raises(ValueError, match=sentence):
        experiment_metadata.value(name, told)


def test_a_fact_may_be_told_in_any_unit_of_its_quantity(bags, sessions, tmp_path):
    bag = tmp_path / "bag"
    session_bag.write(sessions["damping_boom"], bag)
    told = {"experiment": "hose", "facts": {"case_drain_volume": {"value": 0.71, "unit": "L"}}}
    (bag / "experiment.yaml").write_text(yaml.safe_dump(told))
    assert session_bag.read(bag).metadata == {"case_drain_volume": pytest.approx(0.71e-3)}


def test_what_no_row_tells_is_not_taken_for_certain():
    y = np.ones(400)
    problem = Problem(
        {"a": y}, [Channel("a", 0.1)], [Unknown("told", 1.0), Unknown("untold", 1.0)], 20, EMPTY
    )
    derivatives = {"a": np.array([np.ones(400), np.zeros(400)])}
    normal = problem.normal(problem.mean, {"a": y}, derivatives)
    errors = np.sqrt(np.diag(problem.covariance(problem.mean, {"a": y}, derivatives, normal)))
    assert errors[0] == pytest.approx(0.1 / 20.0)
    assert errors[1] > 100.0


def test_both_ends_of_a_narrow_interval_can_be_told_apart():
    narrow = Estimate("pump.supply_pressure", 20684100.0, 100.0, "Pa", 1.0, "output error")
    assert narrow.formatted() == ("2.06841e+07", "2.06839e+07", "2.06843e+07")
    wide = Estimate("valve.deadband_voltage", 1.0, 0.1, "V", 1.0, "C_R(V)", positive=False)
    assert wide.formatted() == ("1", "0.804", "1.196")


def test_a_fit_of_a_simulated_machine_is_told_beside_the_truth():
    method = "output error"
    found = {
        "hose.inertance": Estimate("hose.inertance", 3.1e7, 1e4, "Pa*s2/m3", 1.0, method),
        "valve.deadband_voltage": Estimate("valve.deadband_voltage", 1.01, 0.01, "V", 1.0, method, False),
    }
    said = against(Result(C180, C180, found), C180).splitlines()
    assert re.search(r"valve\.deadband_voltage +truth 1 +off by \+0\.0100000 V$", said[0])
    assert re.search(r"hose\.inertance +truth 3\.062e\+07 +off by \+1\.24102 %, interval misses$", said[1])
    assert said[2] == "  1 of 2 95 % intervals hold the truth"


def test_a_second_run_needs_no_new_name_and_a_file_of_ones_own_stays(bags, tmp_path, capsys):
    assert fit(bags, tmp_path, capsys, "calibration")[0] == 0
    first = (tmp_path / "found.yaml").read_text()
    assert fit(bags, tmp_path, capsys, "calibration")[0] == 0
    assert (tmp_path / "found.yaml").read_text() == first
    assert [path.name for path in tmp_path.iterdir()] == ["found.yaml"]


def test_the_start_is_not_written_over(bags, tmp_path, capsys):
    assert fit(bags, tmp_path, capsys, "calibration")[0] == 0
    first = (tmp_path / "found.yaml").read_text()
    code, _, said = fit(bags, tmp_path, capsys, "calibration", start=str(tmp_path / "found.yaml"))
    assert code == 1
    assert "found.yaml: it is the start, and is based on it; allowed: another file" in said
    assert (tmp_path / "found.yaml").read_text() == first


def test_a_hole_in_a_bag_is_told_as_one(sessions, tmp_path, capsys):
    whole = sessions["calibration"]
    late = np.where(np.arange(len(whole.time)) < len(whole.time) // 2, whole.time, whole.time + 3.0)
    session_bag.write(dataclasses.replace(whole, time=late), tmp_path / "holed")
    code, _, said = fit(tmp_path, tmp_path, capsys, "holed")
    assert code == 1
    assert re.search(r"holed: a hole from 20\.00 to 23\.00 s, without a sample of", said), said


@pytest.mark.parametrize(("first", "last", "until"), [(200, 350, "1.75"), (300, 500, "2.50")])
def test_a_hole_of_one_topic_is_no_straight_line(first, last, until, sessions, tmp_path, capsys, monkeypatch):
    whole = sessions["damping_boom"]
    silent = {name: column.copy() for name, column in whole.readings.items() if name.endswith("flow")}
    for column in silent.values():
        column[first:last] = np.nan
    with monkeypatch.context() as writing:  # rows without a sample become no messages
        writing.setattr(Session, "has", lambda self, *names: all(name in self.readings for name in names))
        session_bag.write(
            dataclasses.replace(whole, readings={**whole.readings, **silent}), tmp_path / "holed"
        )
    code, _, said = fit(tmp_path, tmp_path, capsys, "holed")
    assert code == 1
    assert re.search(
        rf"a hole from 1\.\d\d to {until} s, without a sample of hydraulics/flows swing_1", said
    ), said


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("experiment: [damping_boom\nfacts: {\n", "while parsing a flow sequence"),
        ("", "it names no experiment"),
        ("- damping_boom\n", "it names no experiment"),
        ("facts: {}\n", "it names no experiment"),
    ],
)
def test_a_broken_experiment_yaml_is_one_sentence(text, why, sessions, tmp_path, capsys):
    session_bag.write(sessions["damping_boom"], tmp_path / "broken")
    (tmp_path / "broken" / "experiment.yaml").write_text(text)
    code, _, said = fit(tmp_path, tmp_path, capsys, "broken")
    assert (code, len(said.strip().splitlines())) == (1, 1)
    assert f"experiment.yaml: not usable ({why}" in said


def test_a_laminar_hoses_record_under_the_other_name_is_refused(tmp_path, capsys):
    laminar = experiment("hose_laminar", C180, seed=1, longest=12.0)
    wrong = dataclasses.replace(laminar, name="hose", metadata={**laminar.metadata, "laminar": 0.0})
    session_bag.write(wrong, tmp_path / "hose")
    code, _, said = fit(tmp_path, tmp_path, capsys, "hose")
    assert code == 1
    assert "hose: the record holds a drop that goes with the flow, as the laminar hose's does" in said
    assert not (tmp_path / "found.yaml").exists()
