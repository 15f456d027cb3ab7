"""`forest-ident fit --from-driving` with what people give it."""

import dataclasses
import re
from datetime import date

import pytest
from everyday_work import everyday_work

from forest_description.machine import load_machine
from forest_ident.cli.verbs import main
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.everyday import numbers
from forest_ident.measurements import session_bag

C180 = load_machine("c180_hoses")


@pytest.fixture(scope="module")
def work(drifted):
    """A minute and a half of work with the crane that has drifted."""
    return everyday_work(drifted, C180, seed=1, seconds=90.0)


def fit(capsys, folder, *more, start="c180_hoses"):
    """Give exit code, what was printed, and what was said of errors."""
    out = folder / "found.yaml"
    code = main(["fit", "--from-driving", *map(str, more), "--start", str(start), "--out", str(out)])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_a_bag_of_work_updates_the_machine_file_and_tells_the_drift(
    work, drifted_file, few_numbers, tmp_path, capsys
):
    session_bag.write(work, tmp_path / "monday")
    (tmp_path / "monday" / session_bag.FILE).unlink()  # the recorder writes none
    code, told, _ = fit(capsys, tmp_path, tmp_path / "monday", "--truth", drifted_file)
    assert code == 0
    first, second, *_ = told.splitlines()
    assert first == "verdict: trusted"
    assert re.fullmatch(
        r"  drifted: pump\.supply_pressure -1[12]\.\d\d %, swing\.damping \+(19|20)\.\d\d %, "
        r"boom\.valve\.deadband_voltage \+1[45]\.\d\d %, "
        r"boom\.valve\.backward\.deadband_voltage \+1[45]\.\d\d %",
        second,
    )
    assert re.search(r"stick\.damping +1\.0303e\+05 .* \.\. .* N\*s/m$", told, re.MULTILINE)
    assert re.search(r"left out: \d+ of \d+ s: pauses", told)
    assert re.search(r"of 7 95 % intervals hold the truth", told)
    found = load_machine(tmp_path / "found.yaml")
    assert found.boom.valve.deadband_voltage == pytest.approx(1.15, abs=0.01)
    assert found.stick.valve is None
    text = (tmp_path / "found.yaml").read_text()
    assert f"segments of monday, {date.today()}, 95 % interval" in text


def test_a_fit_that_misses_what_it_has_not_seen_is_not_trusted_and_its_file_says_so(
    work, few_numbers, monkeypatch, tmp_path, capsys
):
    asked = tuple(key for key in few_numbers if key != "boom.valve.backward.deadband_voltage")
    monkeypatch.setattr(numbers, "wanted", lambda _machine: asked)
    session_bag.write(work, tmp_path / "bag")
    code, told, _ = fit(capsys, tmp_path, tmp_path / "bag")
    assert code == 4
    assert told.startswith("verdict: not trusted\n  held-out segments: boom angle is")
    assert "  drifted, if it could be trusted: pump" in told
    text = (tmp_path / "found.yaml").read_text()
    assert text.count("; not trusted: held-out segments: boom angle is") >= 4


@pytest.mark.parametrize("more", [["--linear"], ["--allow", "friction"], ["--report", "report"]])
def test_options_of_experiments_are_refused_at_once(more, tmp_path, capsys):
    code, _, said = fit(capsys, tmp_path, tmp_path / "no_bag", *more)
    assert code == 1
    assert f"--from-driving {more[0]}: allowed: --from-driving with --start, --out and --truth" in said


def without(session, *names):
    """Give a session without some channels."""
    return dataclasses.replace(
        session, readings={name: y for name, y in session.readings.items() if name not in names}
    )


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda work: without(work, "boom_pressure_1_actuator"), "without the pressures at the actuators"),
        (lambda work: without(work, "swing_resolver"), "without swing's angle; allowed: bags with voltages"),
        (lambda work: work.part(0, 6000), r"\d motions that begin at rest .*; allowed: 6 or more"),
        (lambda work: work.part(400, 1500), "no motion begins at rest"),
        (lambda _: experiment("damping_boom", C180, longest=3.0), "the experiment damping_boom; allowed"),
    ],
)
def test_a_bag_that_holds_no_such_work_is_refused_by_a_sentence(change, sentence, work, tmp_path, capsys):
    session_bag.write(change(work), tmp_path / "bag")
    code, _, said = fit(capsys, tmp_path, tmp_path / "bag")
    assert (code, len(said.strip().splitlines())) == (1, 1)
    assert re.search(sentence, said), said
    assert not (tmp_path / "found.yaml").exists()


def test_another_machines_work_is_named(work, tmp_path, capsys):
    session_bag.write(work, tmp_path / "bag")
    code, _, said = fit(capsys, tmp_path, tmp_path / "bag", start="loader")
    assert code == 1
    assert re.search(r"bag: .*: is it another machine's record", said), said


def test_work_that_no_crane_like_the_start_does_is_named(work, few_numbers, tmp_path, capsys):
    crossed = dataclasses.replace(work, voltages=work.voltages[:, [0, 2, 1]].copy(order="C"))
    session_bag.write(crossed, tmp_path / "bag")
    code, _, said = fit(capsys, tmp_path, tmp_path / "bag")
    assert code == 1
    assert re.search(r"bag: after the fit the \w+'s [\w ]+ is still \d+ % off", said), said
    assert not (tmp_path / "found.yaml").exists()
