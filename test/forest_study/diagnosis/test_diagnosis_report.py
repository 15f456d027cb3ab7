import json

import pytest

from forest_study import cli
from forest_study.diagnosis.detection_figures import TOLD
from forest_study.diagnosis.diagnosis_report import per_hour, report, rows_of, share, table

parquet = pytest.importorskip("pyarrow.parquet")
import pyarrow


def row(case="healthy", **changes):
    found = {
        "case": case,
        "error": None,
        "healthy_h": 0.1,
        "false_alarms": 0.0,
        "healthy_score": 0.4,
        "faulty_h": 0.0 if case == "healthy" else 0.1,
        "faulty_score": None if case == "healthy" else 2.0,
        "detected": None if case == "healthy" else 1.0,
        "time_to_detect_s": None if case == "healthy" else 20.0,
        "named": None if case == "healthy" else 1.0,
        "alone": None if case == "healthy" else 1.0,
        **{f"told {cause}": 0.0 for cause in TOLD},
    }
    return found | changes


def test_no_alarm_in_a_time_bounds_the_rate_by_three_over_it():
    assert per_hour(0.0, 10.0) == pytest.approx((0.0, 0.0, 0.29957), abs=1e-4)
    assert per_hour(4.0, 2.0) == pytest.approx((2.0, 0.5449, 5.1208), abs=1e-3)


def test_a_share_has_its_exact_interval():
    assert share(5.0, 5) == pytest.approx((1.0, 0.4782, 1.0), abs=1e-3)


def test_hours_before_a_fault_count_as_healthy_ones():
    rows = [
        row(),
        row("worn pump, mild", false_alarms=1.0),
        row("worn pump, mild", detected=0.0, time_to_detect_s=None),
    ]
    found = report(rows)
    assert found["healthy_h"] == pytest.approx(0.3)
    assert found["faulty_h"] == pytest.approx(0.2)
    assert found["false_alarms_per_h"]["value"] == pytest.approx(1.0 / 0.3)
    pump = found["cases"]["worn pump, mild"]
    assert (pump["runs"], pump["time_to_detect_s"]) == (2, 20.0)
    assert pump["detected"]["value"] == 0.5
    assert "| worn pump | 0.1 of its flow | 2 | 50 % | 20 |" in table(found)


@pytest.mark.parametrize(
    ("common", "case"), [("case: worn pump, mild", "worn pump, mild"), ("minutes: 9", "healthy")]
)
def test_a_case_that_all_runs_have_in_common_is_the_studys(tmp_path, common, case):
    (tmp_path / "sweep").mkdir()
    runs = [{name: value for name, value in row(case).items() if name != "case"}]
    study = {"study": f"kind: diagnosis\nwith:\n  {common}\n"}
    whole = pyarrow.Table.from_pylist(runs).replace_schema_metadata(study)
    parquet.write_table(whole, tmp_path / "sweep" / "runs.parquet")
    assert [one["case"] for one in rows_of([tmp_path / "sweep"])] == [case]


def test_sweeps_become_a_table_and_a_picture(tmp_path, capsys):
    (tmp_path / "sweep").mkdir()
    rows = [row(), row("worn pump, mild", **{"told pump": 1.0})]
    parquet.write_table(pyarrow.Table.from_pylist(rows), tmp_path / "sweep" / "runs.parquet")
    assert cli.main(["diagnosis", str(tmp_path / "sweep"), "--out", str(tmp_path / "out")]) == 0
    assert "100 % | pump 100 |" in capsys.readouterr().out
    assert (tmp_path / "out" / "roc.png").stat().st_size > 1000
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text())["healthy_runs"] == 2


def test_a_sweep_that_has_not_ended_is_refused(tmp_path, capsys):
    assert cli.main(["diagnosis", str(tmp_path / "none"), "--out", str(tmp_path / "out")]) == 1
    assert "runs.parquet is not there; allowed:" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
