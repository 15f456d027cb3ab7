"""The benchmark's statistics, and its command."""

import json
import re
from functools import lru_cache

import numpy as np
import pytest
from expert_trial import TRIAL, expert_trial

from forest_study.cli import main
from forest_study.log_work import trial
from forest_study.logs import logs_command
from forest_study.logs import logs_report as report_page
from forest_study.logs.logs_report import answers
from forest_study.logs.statistics import difference, mean
from forest_study.logs.tables import SHOWN, groups, text
from forest_study.sweep.design import runs
from forest_study.sweep.workers import run_batch


def test_a_mode_that_does_not_help_is_told_as_such():
    """Persons differ by half of their time, the modes by nothing: the paired interval holds zero."""
    rng = np.random.default_rng(1)
    held, small = 0, 0
    for _ in range(200):
        theirs = 90.0 * np.exp(0.5 * rng.standard_normal(12))
        found = difference(theirs * np.exp(0.05 * rng.standard_normal(12)), theirs)
        held += found.low <= 0.0 <= found.high
        small += found.p < 0.05
    assert 0.9 <= held / 200 <= 0.99
    assert small == 200 - held


def test_a_mode_that_saves_a_tenth_is_told_with_its_interval():
    rng = np.random.default_rng(2)
    theirs = 90.0 * np.exp(0.5 * rng.standard_normal(12))
    found = difference(0.9 * theirs * np.exp(0.02 * rng.standard_normal(12)), theirs)
    assert found.low < 0.1 < found.high
    assert found.low > 0.05
    assert found.p < 1e-6
    assert difference(theirs, theirs)[:4] == (0.0, 0.0, 0.0, 1.0)


def test_one_person_has_no_interval():
    assert np.isnan(mean([3.0]).half)
    assert difference([9.0], [10.0]).saved == pytest.approx(0.1)
    assert np.isnan(difference([9.0], [10.0]).p)


def test_where_there_is_no_interval_none_is_shown(told):
    _, _, table, page = told
    assert "nan" not in table
    assert "± nan" not in page
    assert "(two persons or more give an interval)" in table


def run_here(study, store, *_):
    """Run a study in this process; `test_sweep` has it run by workers."""
    todo = [one for one in runs(study) if one.number not in store.done()]
    store.add(run_batch(study.kind, study.common, todo))


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Run one person in two modes: arguments, report, table, page, whose pictures are of the same trials."""
    out, given, made = tmp_path_factory.mktemp("logs") / "out", trial.work, expert_trial(tmp_path_factory)
    work = lru_cache(lambda *asked: made if asked == TRIAL else given(*asked))
    arguments = ["logs", "--machine", "forwarder", "--mode", "tip", "assisted", "--operator", "expert"]
    arguments += ["--seeds", "1", "--workers", "1", "--out", str(out)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(logs_command, "run_the_rest", run_here)
        patch.setattr(trial, "work", work)
        assert main(arguments) == 0
    assert work.cache_info().misses == 2
    texts = [(out / name).read_text("utf-8") for name in ("logs.json", "logs.md", "logs.html")]
    return arguments, json.loads(texts[0]), *texts[1:]


def test_the_command_compares_the_modes_of_the_same_person(told, capsys, monkeypatch):
    arguments, report, table, _ = told
    (group,) = report["groups"]
    times = {mode: figures["time"]["value"] for mode, figures in group["modes"].items()}
    assert group["saved"]["assisted"]["time"]["saved"] == pytest.approx(
        1.0 - times["assisted"] / times["tip"]
    )
    assert "| expert | assisted | 1 |" in table
    monkeypatch.setattr(report_page, "write", lambda *_: None)  # its pictures take trials of their own
    assert main(arguments) == 0  # whole: the table is told anew
    said = capsys.readouterr().out
    assert table in said
    assert "runs of" not in said


def test_the_page_says_what_is_shown_and_on_what_it_hangs(told):
    page = told[3]
    assert "one person shows nothing" in page
    assert page.count("data:image/png;base64,") == 3
    assert "Polowy and Rutkowski 2024" in page
    assert "forest-study logs --machine forwarder --mode tip assisted --operator expert" in page
    words = re.sub('base64,[^"]*', "", page)  # a picture may spell anything
    assert "http" not in words.replace("https://doi.org", "")  # one file: nothing is fetched


def test_the_answer_is_that_of_the_interval():
    rng = np.random.default_rng(3)

    def group(factor):
        rows = []
        for seed in range(12):
            base = 90.0 * np.exp(0.3 * rng.standard_normal())
            noise = np.exp(0.02 * rng.standard_normal())
            for mode, time in (("joint", base), ("tip", base * factor * noise)):
                figures = dict.fromkeys(SHOWN, time)
                rows.append(
                    {"operator": "expert", "trip": 0.0, "mode": mode, "seed": seed, "error": None} | figures
                )
        return groups(rows, ["joint", "tip"])

    assert ": faster;" in answers(group(0.9))[0]
    assert ": slower;" in answers(group(1.1))[0]
    assert ": no difference is shown;" in answers(group(1.0))[0]


def test_a_trial_that_was_not_ended_is_counted_and_its_pair_left_out():
    def row(mode, seed, error=None):
        figures = dict.fromkeys(SHOWN, None if error else 10.0)
        return {"operator": "expert", "trip": 0.0, "mode": mode, "seed": seed, "error": error} | figures

    rows = [row(mode, seed) for mode in ("joint", "tip") for seed in range(3)]
    rows[1] = row("joint", 1, "not done")
    (group,) = groups(rows, ["joint", "tip"])
    assert group.failed == {"joint": 1, "tip": 0}
    assert group.saved["tip"]["time"].pairs == 2
    assert "| not ended | 1 | 0 |" in text([group])
