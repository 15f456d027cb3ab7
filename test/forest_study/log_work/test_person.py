"""Operators: practice changes what is learnt, files are checked, persons repeat."""

import math

import pytest

from forest_study.log_work.person import Person, drawn, read_person
from forest_study.results import StudyError

ENTRY = "hand: {value: 0.2, unit: s, source: measured}\n"


def test_practice_leads_from_the_value_to_what_is_learnt():
    novice, expert = read_person("novice"), read_person("expert")
    assert (novice.axes, novice.foresight) == (1.2, 0.0)
    assert expert.axes == pytest.approx(1.8)
    after = read_person("novice", {"practice": 3.0})
    assert after.axes == pytest.approx(1.8 - 0.6 / math.e)
    assert after.delay == novice.delay


def test_a_file_may_change_numbers_of_a_shipped_one(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(f"based_on: expert\n{ENTRY}", "utf-8")
    assert read_person(str(file)) == read_person("expert")._replace(hand=0.2)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("hand: 0.2\n", "allowed: {value: NUMBER, unit: s, source: TEXT}"),
        (ENTRY.replace("unit: s", "unit: ms"), "unit: s, source"),
        (ENTRY.replace("measured", "''"), "source: TEXT"),
        (ENTRY.replace("0.2", "7"), "allowed: 0.02 .. 1 s"),
        (ENTRY.replace("hand", "foot"), "foot: not known; allowed: based_on, practice"),
        ("based_on: me\n", "allowed: expert, novice"),
        ("- 1\n", "no mapping"),
        ("{", "not YAML"),
    ],
)
def test_what_a_file_may_not_say_is_told_in_a_sentence(tmp_path, text, told):
    file = tmp_path / "mine.yaml"
    file.write_text(text, "utf-8")
    with pytest.raises(StudyError) as error:
        read_person(str(file))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_an_operator_that_is_not_there_is_told_with_those_that_are():
    with pytest.raises(StudyError, match="allowed: expert, novice, or a file"):
        read_person("nobody")


def test_persons_repeat_and_stay_within_what_is_allowed():
    wide = Person(persons=1.0)
    assert drawn(wide, 3) == drawn(wide, 3) != drawn(wide, 4)
    assert all(1.0 <= drawn(wide, seed).axes <= 3.0 for seed in range(20))
    assert drawn(wide._replace(persons=0.0), 3) == wide._replace(persons=0.0)
