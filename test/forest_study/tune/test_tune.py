"""Gains that are searched for: robust ones only, no run made twice, and judged on plants not searched on."""

import json
import math
from types import SimpleNamespace

import pytest

pytest.importorskip("llvmlite")

from forest_control.config.controller_settings import Settings, with_rules
from forest_control.config.profile_file import with_gains_of
from forest_description.machine import load_machine
from forest_study.cli import main
from forest_study.matrix.figures import Figures
from forest_study.matrix.matrix_rows import matrix_rows
from forest_study.results import StudyError
from forest_study.tune import bench as benches
from forest_study.tune import robustness, search, tune_report
from forest_study.tune.bench import Bench
from forest_study.tune.gains import point_of, profile, settings_of

MACHINE = load_machine("c180_hoses")
RULE = settings_of(point_of(MACHINE))
PLAIN = [matrix_rows()["plain"]]
SEEDS = range(2)


@pytest.fixture(scope="module")
def plants():
    return robustness.opened(MACHINE, [])


def figures(error):
    return Figures(**(dict.fromkeys(Figures._fields, 1.0) | dict.fromkeys(search.ERRORS, error)))


@pytest.fixture
def counted(monkeypatch):
    """Plants whose error falls with the boom's K_p; the gains that were run."""
    made = []

    def run_row(row, machine, seeds, rival):
        made.append((rival.control.feedback_gain, rival.control.lead_time, rival.control.rate_gain))
        error = 10.0 + (rival.control.feedback_gain[1] - 30.0) ** 2
        return [SimpleNamespace(seed=k, overloaded=k == 1, figures=figures(error + k % 7)) for k in seeds]

    monkeypatch.setattr(benches, "run_row", run_row)
    return made


def test_the_rules_gains_are_a_point_of_the_search():
    told = with_rules(MACHINE, Settings())
    assert RULE.feedback_gain == told.feedback_gain
    assert RULE.integral_gain == pytest.approx(told.integral_gain, rel=1e-3)
    assert (RULE.rate_gain, RULE.lead_time) == (told.rate_gain, told.lead_time)


def test_a_profile_gives_the_controller_the_very_gains(tmp_path):
    tuned = settings_of([1.234567, 2.0, 1.5, 0.7, 0.3, 0.2, 0.0])
    file = tmp_path / "tuned.yaml"
    file.write_text(profile(tuned, ["of a test"]))
    assert with_gains_of(Settings(), str(file)) == tuned
    assert with_gains_of(tuned, "exact") == Settings()  # a profile without gains: by the rule


def test_the_search_goes_down_but_stays_robust(tmp_path, counted, plants):
    found = search.search(Bench(tmp_path, "c180_hoses", PLAIN), plants, SEEDS, 40, lambda *_: None)
    limit = robustness.allowed(plants, RULE)
    best = search.best(found, limit)
    assert found[0].cost == 0.0
    assert best.cost < -0.1
    assert RULE.feedback_gain[1] < best.settings.feedback_gain[1] < 12.0
    assert limit - 0.1 < best.sensitivity <= limit


def test_a_search_that_was_stopped_makes_no_run_twice_and_ends_the_same(tmp_path, counted, plants):
    whole = search.search(Bench(tmp_path / "a", "c180_hoses", PLAIN), plants, SEEDS, 20, lambda *_: None)
    runs = list(counted)
    counted.clear()

    def stops(count, _):
        if count == 9:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search.search(Bench(tmp_path / "b", "c180_hoses", PLAIN), plants, SEEDS, 20, stops)
    with (tmp_path / "b" / "runs.jsonl").open("a") as file:
        file.write('{"key": "cut in mid-')  # the computer went down
    again = search.search(Bench(tmp_path / "b", "c180_hoses", PLAIN), plants, SEEDS, 20, lambda *_: None)
    assert again == whole
    assert counted == runs


def test_another_search_is_not_mixed_in(tmp_path, counted):
    Bench(tmp_path, "c180_hoses", PLAIN)
    with pytest.raises(StudyError, match="was begun with other rows; allowed: another --out"):
        Bench(tmp_path, "c180_hoses", [matrix_rows()["slow"]])
    with pytest.raises(StudyError, match="was begun with other machine"):
        Bench(tmp_path, "c180", PLAIN)


def test_loads_beyond_the_capacity_do_not_count(tmp_path, counted):
    assert [one["seed"] for one in Bench(tmp_path, "c180_hoses", PLAIN).run(RULE, range(3))] == [0, 2]


def plants_of(errors, row="plain"):
    return [{"row": row, "figures": error and figures(error)._asdict()} for error in errors]


def test_gains_are_judged_by_the_hardest_quarter_of_each_rows_plants():
    rule = plants_of([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 9.0])
    ours = plants_of([9.0, 2.0, 0.1, 3.0, 0.1, 0.1, 0.1, 7.0])  # others are the hardest now
    assert search.cost(ours, rule) == pytest.approx(0.0)
    slow, slower = plants_of([100.0] * 4, "slow"), plants_of([100.0, 100.0, 100.0, 200.0], "slow")
    assert search.cost([*ours, *slower], [*rule, *slow]) == pytest.approx(0.5 * math.log(2.0))


def test_a_less_steady_tip_costs_as_much_as_a_less_exact_one():
    (rule,) = plants_of([1.0])
    shaken = rule | {"figures": rule["figures"] | {"velocity_rms": 8.0}}
    assert search.cost([shaken], [rule]) == pytest.approx(math.log(2.0))


def test_a_run_that_does_not_end_is_as_bad_as_ten_times_the_error():
    ours, rule = plants_of([None, 3.0, None]), plants_of([2.0, 3.0, None])
    assert search.cost(ours, rule) == pytest.approx(math.log(20.0 / 3.0))


def test_a_loop_without_margins_is_never_robust(plants):
    assert 1.0 < robustness.sensitivity(plants, RULE) < 2.0
    wild = RULE._replace(feedback_gain=(4.0, 60.0, 5.0))
    assert robustness.sensitivity(plants, wild) == math.inf


def test_an_interval_that_holds_zero_is_told_as_no_difference():
    rule = [{"row": "plain", "figures": figures(x)._asdict()} for x in (1.0, 2.0, 4.0)]
    less = [{"row": "plain", "figures": figures(x)._asdict()} for x in (0.5, 1.0, 2.1)]
    either = [{"row": "plain", "figures": figures(x)._asdict()} for x in (0.5, 2.2, 5.0)]
    assert "cross-track RMS: less; -49" in tune_report.answer(tune_report.compared(less, rule))[0]
    assert "no difference is shown" in tune_report.answer(tune_report.compared(either, rule))[0]


def test_the_command_leaves_a_profile_that_bode_takes(tmp_path, counted, capsys):
    out = tmp_path / "tuned"
    given = ["--machine", "c180_hoses", "--seeds", "2", "--unseen", "3", "--trials", "17", "--out", str(out)]
    assert main(["tune", *given]) == 0
    said = capsys.readouterr().out
    assert "17 of 17 trials" in said
    assert "on 3 unseen plants" in said
    tuned = json.loads((out / "tune.json").read_text())["gains"]["tuned"]
    bode = ["bode", "--machine", "c180_hoses", "--profile", str(out / "profile.yaml")]
    assert main([*bode, "--out", str(tmp_path / "bode")]) == 0
    loops = json.loads((tmp_path / "bode" / "bode.json").read_text())["loops"]
    assert [one["gains"][0] for one in loops] == tuned["feedback_gain"]


def test_track_takes_a_profiles_gains(tmp_path):
    file = tmp_path / "weak.yaml"
    file.write_text("feedback_gain: [1, 1, 1]\nexpo: 0.9\n")
    track = ["track", "--path", "radial", "--machine", "c180_hoses"]
    assert main([*track, "--profile", str(file), "--out", str(tmp_path / "weak")]) == 0
    assert main([*track, "--out", str(tmp_path / "ours")]) == 0
    weak, ours = (
        json.loads((tmp_path / name / "track.json").read_text())["runs"][0] for name in ("weak", "ours")
    )
    assert weak["cross_track_rms_mm"] > 1.1 * ours["cross_track_rms_mm"]


def test_a_wrong_profile_is_one_sentence(tmp_path, capsys):
    file = tmp_path / "wrong.yaml"
    file.write_text("feedback_gain: [99, 1, 1]\n")
    with pytest.raises(SystemExit):
        main(["track", "--path", "radial", "--profile", str(file), "--out", str(tmp_path / "out")])
    assert (
        "feedback_gain is [99, 1, 1]; allowed: one number for all levers or three" in capsys.readouterr().err
    )
