"""The README's tables are the code's: what is generated elsewhere must stand there unchanged."""

from pathlib import Path

from forest_description.export.machine_numbers import assumptions
from forest_msgs_py.interfaces.topic_reference import overview

README = (Path(__file__).resolve().parents[1] / "README.md").read_text("utf-8")


def test_topic_table_is_that_of_the_code():
    assert overview() in README


def test_every_assumed_number_is_told():
    assert assumptions() in README
