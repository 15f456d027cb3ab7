"""YAML of strangers: what it says is returned, and whatever is wrong with it is a `yaml.YAMLError`."""

import os

import pytest
import yaml

from forest_msgs_py.interfaces.yaml_text import LARGEST, MOST_VALUES, parsed, read_yaml


@pytest.mark.parametrize(
    "text",
    ["", "a", "{a: 1, b: [x, 2.5, null]}", "a: &one [1, 2]\nb: *one\nc: {<<: {d: 1}, e: 2}", "- 2026-11-24"],
)
def test_it_is_read_as_the_library_reads_it(text):
    assert parsed(text) == yaml.safe_load(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: [", "expected"),
        ("[" * 1000, "nested too deeply"),
        ("2026-99-99", "month must be"),
        ("&a [*a]", "or for themselves"),
        ("a: &a {b: *a}", "or for themselves"),
        ("a: 1\n---\nb: 2", "expected a single document"),
        ("!!python/object/apply:os.getcwd []", "could not determine a constructor"),
    ],
)
def test_what_is_wrong_is_told(text, said):
    with pytest.raises(yaml.YAMLError, match=said):
        parsed(text)


def test_aliases_may_stand_for_a_million_values_and_no_more():
    row = "a: &a [" + ", ".join(["x"] * 998) + "]\nb: ["
    fits = row + ", ".join(["*a"] * 900) + "]"
    assert len(parsed(fits)["b"]) == 900
    with pytest.raises(yaml.YAMLError, match=f"more than {MOST_VALUES} values"):
        parsed(row + ", ".join(["*a"] * 1100) + "]")


def test_a_text_has_at_most_so_many_characters():
    assert parsed("#" + " " * (LARGEST - 1)) is None
    with pytest.raises(yaml.YAMLError, match=f"more than the {LARGEST} characters"):
        parsed("#" + " " * LARGEST)


def test_of_a_file_without_an_end_no_more_is_read_than_may_stand_there(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_text("\ufeffa: 1")
    assert read_yaml(file) == {"a": 1}
    os.truncate(file, 1 << 30)  # a file of holes takes no place on the disk
    with pytest.raises(yaml.YAMLError, match=f"more than the {LARGEST} bytes"):
        read_yaml(file)


def test_a_key_that_stands_twice_is_refused():
    with pytest.raises(yaml.YAMLError, match="line 3: 'a' stands there twice"):
        parsed("b:\n  a: 1\n  a: 2\n")
    assert parsed("b: {a: 1}\na: 2\n") == {"b": {"a": 1}, "a": 2}
    assert parsed("{1: a, '1': b}") == {1: "a", "1": "b"}
