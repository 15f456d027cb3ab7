"""Claims about CSV files that people write: rows of numbers over time, or a sentence with file and line."""

import re

import pytest

from forest_bag.convert.csv_rows import CsvColumn, read_rows

COLUMNS = (CsvColumn("time", 0.0, 60.0, "s"), CsvColumn("lever", -1.0, 1.0))


class RowError(ValueError):
    pass


@pytest.fixture
def read(tmp_path):
    def read(content):
        path = tmp_path / "rows.csv"
        path.write_bytes(content)
        return read_rows(path, COLUMNS, RowError)

    return read


def test_rows_come_as_numbers_and_blank_lines_and_a_byte_order_mark_do_not_count(read):
    assert read("\ufefftime, lever\n\n0,-1\n1.5, 0.25 \n".encode()) == [[0.0, -1.0], [1.5, 0.25]]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", ":1: the header must be time,lever, found nothing"),
        (b"\ntime,stick\n0,0\n", ":2: the header must be time,lever, found time,stick"),
        (b"time,lever\n", ":1: no rows below the header; allowed: one or more"),
        (b"time,lever\n0,0,0\n", ":2: 3 columns; allowed are the 2 of the header"),
        (b"time,lever\n0,0\n1,up\n", ":3: lever is 'up'; allowed: -1 .. 1"),
        (b"time,lever\n0,nan\n", ":2: lever is 'nan'; allowed: -1 .. 1"),
        (b"time,lever\n-1,0\n", ":2: time is '-1'; allowed: 0 .. 60 s"),
        (b"time,lever\n61,0\n", ":2: time is '61'; allowed: 0 .. 60 s"),
        (b"time,lever\n1,0\n\n1,0\n", ":4: time is 1 after 1; times must rise"),
        (b"time,lever\n0,\xff\n", "cannot be read as CSV"),
    ],
)
def test_a_wrong_file_is_named_with_its_line_and_what_is_allowed(read, content, said):
    with pytest.raises(RowError, match=re.escape(said)) as error:
        read(content)
    assert "rows.csv" in str(error.value)


def test_a_file_that_is_not_there_is_the_readers_own_error(tmp_path):
    with pytest.raises(RowError, match="cannot be read as CSV"):
        read_rows(tmp_path / "none.csv", COLUMNS, RowError)
