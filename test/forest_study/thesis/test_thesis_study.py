"""`forest-study thesis`: the numbers that the thesis quotes, what it shows, and its files."""

import json

import pytest

from forest_study.cli import main
from forest_study.thesis import thesis_study
from forest_study.thesis.thesis_study import Case, largest_position_error

PICTURES = [f"figure_5_{n}.png" for n in range(4, 10)]
QUOTED = [
    ("5.4", "c", "velocity_error_y", 0.20, 0.194),
    ("5.4", "d", "velocity_error_y", 0.40, 0.429),
    ("5.5", "c", "position_error_y", 0.025, 0.0263),
    ("5.5", "d", "position_error_y", 0.065, 0.0633),
    ("5.6", "c", "velocity_error_y", 0.25, 0.256),
    ("5.6", "d", "velocity_error_y", 0.50, 0.485),
    ("5.7", "c", "position_error_y", 0.035, 0.0350),
    ("5.7", "d", "position_error_y", 0.075, 0.0764),
]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The command's directory and the study in it."""
    out = tmp_path_factory.mktemp("study") / "thesis"
    assert main(["thesis", "--out", str(out)]) == 0
    return out, json.loads((out / "study.json").read_text("utf-8"))


@pytest.fixture(scope="module")
def result(made):
    return made[1]


@pytest.mark.parametrize(("figure", "scheme", "quantity", "thesis", "here"), QUOTED)
def test_each_quoted_number_is_met(figure, scheme, quantity, thesis, here, result):
    found = result["figures"][figure][scheme][quantity]
    assert found == pytest.approx(here, rel=4e-3)
    assert found == pytest.approx(thesis, rel=0.075)


def test_worst_deviation_is_that_of_the_worst_number(result):
    deviations = [result["figures"][f][s][q] / thesis - 1.0 for f, s, q, thesis, _ in QUOTED]
    assert [row["deviation"] for row in result["quoted"]] == pytest.approx(deviations)
    assert result["worst_deviation"] == pytest.approx(max(map(abs, deviations)))
    assert result["worst_deviation"] <= 0.075


@pytest.mark.parametrize("case", ["-20%", "+20%"])
@pytest.mark.parametrize("axis", "xz")
def test_velocity_servo_drifts_when_the_plant_is_not_the_one_it_was_made_for(case, axis, result):
    drift = result["figures"]["5.9"]["cases"][case]["c"][f"drift_{axis}"]
    assert 0.09 < abs(drift) < 0.15
    assert (drift > 0.0) == (case == "-20%")  # a slower plant has more gain: k is fixed


@pytest.mark.parametrize("case", ["-20%", "+20%"])
def test_position_servo_does_not_care(case, result):
    nominal, wrong = result["figures"]["5.5"]["d"], result["figures"]["5.9"]["cases"][case]["d"]
    for axis in "xyz":
        assert wrong[f"drift_{axis}"] == pytest.approx(nominal[f"drift_{axis}"], abs=1e-3)
        assert wrong[f"position_error_{axis}"] < 0.08
        assert wrong[f"position_error_{axis}"] == pytest.approx(nominal[f"position_error_{axis}"], rel=0.06)
    assert result["robustness"]["d"]["ratio"] < 1.1
    assert result["robustness"]["c"]["ratio"] > 5.0


def test_velocity_servo_is_the_better_one_on_the_plant_it_was_made_for(result):
    for figure in ("5.4", "5.5", "5.6", "5.7"):
        c, d = (result["figures"][figure][name] for name in "cd")
        for quantity in ("velocity_error_y", *(f"position_error_{axis}" for axis in "xyz")):
            assert c[quantity] < d[quantity]


def test_with_several_cases_a_figure_tells_the_worst(result):
    figure = result["figures"]["5.8"]
    both = [figure["cases"][case]["c"]["velocity_error_y"] for case in ("-20%", "+20%")]
    assert figure["c"]["velocity_error_y"] == max(both)


def test_servos_break_even_near_eight_percent(result):
    found = result["break_even_mismatch"]
    assert found["any_axis"] == pytest.approx([-0.111, 0.083], abs=2e-3)
    assert found["z"] == pytest.approx([-0.080, 0.070], abs=2e-3)
    for mismatch in found["any_axis"]:
        errors = [largest_position_error(name, Case(2.0, mismatch)) for name in "cd"]
        assert errors[0] == pytest.approx(errors[1], rel=0.01)


def test_sweep_goes_from_half_to_one_and_a_half_with_all_schemes(result):
    rows = result["mismatch_sweep"]
    assert [row["mismatch"] for row in rows] == pytest.approx([0.1 * k - 0.5 for k in range(11)])
    for velocity_servo in "ac":
        drifts = [row[velocity_servo]["drift_x"] for row in rows]
        assert drifts == sorted(drifts, reverse=True)
        assert drifts[0] > 0.4
    ours = [row["coordinated"] for row in rows]
    assert max(abs(row["drift_x"]) for row in ours) < 0.002
    for row in rows[1:]:  # at -50 %, twice the gain, its feed-forward is twice too much
        assert row["coordinated"]["position_error"] < min(row[name]["position_error"] for name in "abcd")
    for position_servo in "bd":
        assert max(abs(row[position_servo]["drift_x"]) for row in rows) < 0.03
        assert max(row[position_servo]["position_error_y"] for row in rows) < 0.07


def test_pre_loop_gain_matters(result):
    assert result["without_pre_loop_gain"]["c"]["position_error_x"] > 0.6
    assert result["schemes"]["2 Hz"]["c"]["position_error_x"] < 0.03


def test_json_has_gains_poles_and_what_was_run(result):
    assert set(result["figures"]) == {"5.4", "5.5", "5.6", "5.7", "5.8", "5.9"}
    assert result["servos"]["2 Hz"]["pre_loop_gain"] == pytest.approx(4.195, rel=1e-3)
    assert result["servos"]["0.2 Hz"]["poles"]["+0%"]["velocity"] == pytest.approx([-11.5])
    assert result["machine"] == "c180_thesis"
    assert result["start_tip"] == [5.5, 0.0, 1.0]
    assert set(result["schemes"]["0.2 Hz"]) == {*"abcd", "coordinated"}


def test_six_pictures_lie_beside_the_numbers(made):
    out, _ = made
    assert sorted(path.name for path in out.iterdir()) == sorted([*PICTURES, "study.json"])
    for name in PICTURES:
        data = (out / name).read_bytes()
        assert data.startswith(b"\x89PNG")
        assert int.from_bytes(data[16:20], "big") >= 1000


@pytest.fixture
def quick(monkeypatch):
    """The command without its study, which the tests above have made."""
    monkeypatch.setattr("forest_study.thesis.thesis_report.report", lambda out: 0)


def test_table_tells_thesis_and_here(made, capsys):
    from forest_study.thesis.thesis_report import table

    text = table(made[1])
    assert "0.400   0.429      +7.2%" in text
    assert "worst deviation 7.2%" in text
    assert ["2", "Hz", "-50%", "505", "60", "521", "67", "82"] in [line.split() for line in text.splitlines()]
    assert "break even at a mismatch of -11.1%, +8.3%" in text


def test_results_are_never_overwritten(made, capsys):
    out, _ = made
    assert main(["thesis", "--out", str(out)]) == 1
    error = capsys.readouterr().err
    assert error == f"forest-study: {out} is not empty; choose another --out or remove it\n"


def test_an_empty_directory_is_taken(quick, tmp_path):
    assert main(["thesis", "--out", str(tmp_path)]) == 0


def test_a_file_in_the_way_is_one_sentence(quick, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["thesis", "--out", str(tmp_path / "file")]) == 1
    error = capsys.readouterr().err
    assert error.startswith("forest-study: ")
    assert error.count("\n") == 1


@pytest.mark.parametrize("arguments", [[], ["thesis"], ["thesis", "--out"], ["nonsense"]])
def test_wrong_arguments_exit_with_two(arguments, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert "usage: forest-study" in capsys.readouterr().err


def test_every_quoted_number_is_asserted_here():
    assert [tuple(q) for q in thesis_study.QUOTED] == [row[:4] for row in QUOTED]
