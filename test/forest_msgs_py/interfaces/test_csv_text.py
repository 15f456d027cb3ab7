"""A CSV file of numbers over time is read whole, or named with the line and what is allowed there."""

import pytest

from forest_msgs_py.interfaces.csv_text import Column, read_rows

COLUMNS = (Column("time", 0.0, 10.0, "s"), Column("a", -1.0, 1.0))


class Refused(Exception):
    pass


def test_rows_come_as_numbers(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("\ufefftime, a\n0,-1\n\n2.5,1e-1\n", encoding="utf-8")
    assert read_rows(file, COLUMNS, Refused) == [[0.0, -1.0], [2.5, 0.1]]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "1: the header must be time,a, found nothing"),
        ("time,b\n0,0\n", "1: the header must be time,a, found time,b"),
        ("time,a\n", "1: no rows below the header; allowed: one or more"),
        ("time,a\n0,0,0\n", "2: 3 columns; allowed are the 2 of the header"),
        ("time,a\n0,0\n\n0,0\n", "4: time is 0 after 0; times must rise"),
        ("time,a\n11,0\n", "2: time is '11'; allowed: 0 .. 10 s"),
        ("time,a\n0,nan\n", "2: a is 'nan'; allowed: -1 .. 1"),
        ("time,a\n0,x\n", "2: a is 'x'; allowed: -1 .. 1"),
    ],
)
def test_a_line_that_does_not_fit_is_named(tmp_path, text, problem):
    file = tmp_path / "a.csv"
    file.write_text(text)
    with pytest.raises(Refused) as refused:
        read_rows(file, COLUMNS, Refused)
    assert str(refused.value) == f"{file}:{problem}"


def test_a_file_that_is_not_there_or_no_text_is_named(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe\x00")
    for name in ("a.csv", "none.csv"):
        with pytest.raises(Refused, match=rf"{name}: cannot be read as CSV: "):
            read_rows(tmp_path / name, COLUMNS, Refused)
