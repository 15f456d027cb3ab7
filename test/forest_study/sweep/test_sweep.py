"""`forest-study sweep` by its real workers: killed, stopped, and gone on with."""

import json
import os
import signal

import dask
import pytest

pytest.importorskip("llvmlite")

from distributed import LocalCluster
from pyarrow import parquet

from forest_control.servo.schemes import scheme_named
from forest_description.machine import load_machine
from forest_study.cli import main
from forest_study.results import StudyError
from forest_study.sweep import sweep_command
from forest_study.sweep.design import runs
from forest_study.sweep.store import Store
from forest_study.sweep.study import read_study
from forest_study.sweep.trials import tracked
from forest_study.sweep.workers import batches, cluster, results, run_batch
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import noisy, track

TEXT = """
with: {machine: c180_hoses, path: vertical, noise: true}
vary:
  speed: [1.0, 1.5]
  plant.manipulator.head_mass: {values: [200, 300], unit: kg}
seeds: 3
"""


@pytest.fixture
def study(tmp_path):
    """Write the study's file; return it."""
    file = tmp_path / "study.yaml"
    file.write_text(TEXT, encoding="utf-8")
    return file


def test_a_runs_figures_are_those_of_track():
    machine = load_machine("c180_hoses")
    case = {"machine": "c180_hoses", "path": "vertical", "speed": 1.0}
    study = next(runs_of(case))
    (found,) = run_batch("track", case, [study])
    expected = track(
        path_named("vertical"), 1.0, scheme_named("coordinated"), machine, machine, noisy(machine, 7)
    )
    assert {key: found[key] for key in expected.total._fields} == expected.total._asdict()


def test_a_studys_step_is_that_of_the_simulated_machine():
    case = {"machine": "c180_hoses", "path": "vertical", "speed": 1.0}
    usual, same, longer = (tracked({**case, **more}, 7) for more in ({}, {"step": 0.001}, {"step": 0.005}))
    assert same == usual
    assert 0.0 < abs(longer["cross_track_rms_mm"] - usual["cross_track_rms_mm"]) < 0.1


def test_a_plant_that_the_controller_does_not_know_is_another_case_than_a_machine_that_it_knows():
    case = {"machine": "c180_hoses", "path": "vertical", "speed": 1.5, "noise": False}
    key = "valve.deadband_voltage"
    as_filed, unknown, known = (
        tracked({**case, **more}, 0)["governed_rms_mm"]
        for more in ({}, {f"plant.{key}": 1.2}, {f"machine.{key}": 1.2})
    )
    assert unknown > 1.5 * max(as_filed, known)


def runs_of(case):
    from forest_study.sweep.study import Study

    lists = {"speed": (case["speed"],)}
    return runs(Study("", "track", {}, lists, {}, "grid", 1, range(7, 8)))


def test_a_case_that_cannot_be_is_told_beside_the_others():
    case = {"machine": "c180_hoses", "path": "vertical", "speed": 1.0}
    one = next(runs_of(case))
    far = one._replace(number=1, varied={"machine.boom.elasticity.stiffness": 1.0})
    good, bad = run_batch("track", case, [one, far])
    assert good["error"] is None
    assert bad["error"] == "boom.elasticity is not there; allowed: numbers of what the machine has"


def test_a_worker_that_is_killed_loses_nothing_and_a_stopped_study_goes_on(tmp_path, study, capsys):
    out, read = tmp_path / "out", read_study(study)
    store = sweep_command.Store(out, read)
    todo = batches(list(runs(read)), 2, 25)
    with cluster(None, 1) as own:
        address = own.scheduler.address
        with cluster(address, None) as client:
            (pid,) = client.run(os.getpid).values()
            (looked_at,) = client.run(dask.config.get, "distributed.worker.profile.enabled").values()
            assert not looked_at  # its stack, a hundred times a second
            found = results(client, read.kind, read.common, todo)
            store.add(next(found))
            os.kill(pid, signal.SIGKILL)
            rows = next(found)
            store.add(rows)
        assert all(row["error"] is None for row in rows)
        done = store.done()
        del store
        assert 0 < len(done) < 12
        assert main(["sweep", str(study), "--out", str(out), "--scheduler", address]) == 0
    told = capsys.readouterr().out
    assert f"{12 - len(done)} runs of 12" in told
    table = parquet.read_table(out / "runs.parquet")
    assert table["number"].to_pylist() == list(range(12))
    assert table["error"].null_count == 12
    about = table.schema.metadata
    assert about[b"study"].decode() == TEXT
    assert "numpy" in json.loads(about[b"made_by"])["versions"]
    assert json.loads((out / "summary.json").read_text("utf-8"))["runs"] == 12
    # Whole: nothing is run, and the table told anew.
    assert main(["sweep", str(study), "--out", str(out)]) == 0
    assert "runs of" not in capsys.readouterr().out


def test_a_batch_whose_first_run_failed_keeps_the_figures_of_the_others(tmp_path, study):
    store = sweep_command.Store(tmp_path / "out", read_study(study))
    good = {"number": 1, "error": None, "figure": 2.0}
    store.add([{"number": 0, "error": "out of reach"}, good])
    assert store.finish()[1] == parquet.read_table(store.whole).to_pylist()[1] == good


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (TEXT.replace("seeds: 3", "seeds: 2"), "was begun with other study"),
        (TEXT, "was begun with other numpy"),
    ],
)
def test_another_study_or_other_versions_do_not_mix(tmp_path, study, capsys, text, told):
    out = tmp_path / "out"
    sweep_command.Store(out, read_study(study))
    begun = json.loads((out / "runs.jsonl").read_text("utf-8"))
    if text == TEXT:
        begun["versions"]["numpy"] = "1.0"
    (out / "runs.jsonl").write_text(json.dumps(begun) + "\n", encoding="utf-8")
    study.write_text(text, encoding="utf-8")
    assert main(["sweep", str(study), "--out", str(out)]) == 1
    assert told in capsys.readouterr().err


def test_a_path_that_was_drawn_anew_is_another_study(tmp_path):
    drawn, file = tmp_path / "path.csv", tmp_path / "study.yaml"
    file.write_text(f"with: {{path: {drawn}}}\n", encoding="utf-8")
    for end in ("1.3", "1.4"):
        drawn.write_text(f"x,y,z\n5.5,0,1\n5.5,0,{end}\n", encoding="utf-8")
        if end == "1.3":
            Store(tmp_path / "out", read_study(file))
    with pytest.raises(StudyError, match="was begun with other paths; allowed: another --out"):
        Store(tmp_path / "out", read_study(file))


def test_what_fails_while_a_cluster_answers_is_told_as_it_is():
    with (
        LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=None) as scheduler,
        pytest.raises(OSError, match="disk full"),
        cluster(scheduler.scheduler_address, None),
    ):
        raise OSError("disk full")


def test_a_scheduler_that_does_not_answer_is_named(tmp_path, study, capsys):
    address = "tcp://127.0.0.1:9"
    assert main(["sweep", str(study), "--out", str(tmp_path / "out"), "--scheduler", address]) == 1
    assert f"no Dask scheduler answers at {address}" in capsys.readouterr().err
