"""Claims about the runs that a command keeps: nothing whole is lost, nothing of another command is taken."""

import pytest

from forest_study.journal import Journal
from forest_study.results import StudyError


def test_entries_come_back_but_for_one_that_was_cut(tmp_path):
    journal = Journal(tmp_path, {"rows": ["plain"]})
    journal.add([{"error": 0.1 + 0.2}, {"error": None}])
    journal.add({"key": "é"})
    with (tmp_path / "runs.jsonl").open("a", encoding="utf-8") as file:
        file.write('{"key": "cut in mid-')
    del journal
    again = Journal(tmp_path, {"rows": ["plain"]})
    again.add("next")
    kept = [[{"error": 0.1 + 0.2}, {"error": None}], {"key": "é"}, "next"]
    assert again.entries == kept
    del again
    assert Journal(tmp_path, {"rows": ["plain"]}).entries == kept


def test_where_another_command_makes_runs_none_are_made_twice(tmp_path):
    first = Journal(tmp_path, {})
    with pytest.raises(StudyError, match="another command makes runs there; allowed: another --out"):
        Journal(tmp_path, {})
    first.add("kept")
    del first
    assert Journal(tmp_path, {}).entries == ["kept"]


def test_what_differs_is_named(tmp_path):
    Journal(tmp_path, {"rows": ["plain"], "seeds": 2})
    with pytest.raises(StudyError, match="was begun with other rows, seeds; allowed: another --out"):
        Journal(tmp_path, {"rows": ["slow"], "seeds": 3})


@pytest.mark.parametrize(
    "text", ["", "number,error\n", "[1]\n", "7\n", '{"study": 1}\n', '{"versions": 1}\n']
)
def test_a_file_that_is_no_journal_is_named(tmp_path, text):
    (tmp_path / "runs.jsonl").write_text(text, encoding="utf-8")
    with pytest.raises(StudyError, match="holds no runs"):
        Journal(tmp_path, {})
