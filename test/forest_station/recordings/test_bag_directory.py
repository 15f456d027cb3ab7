"""Whoever names a bag gets a bag of the directory, and nothing else; nothing is overwritten."""

import os
import shutil
from pathlib import Path

import pytest

from forest_bag.storage.bag_files import BagError
from forest_station.recordings.bag_directory import BagDirectory

REFERENCE = Path("bags/coordinated")


@pytest.fixture
def bags(tmp_path):
    """A directory with bags below it, and one outside of it."""
    inside = tmp_path / "bags"
    for name in ("coordinated", "demo/bag", "a/b/c", "a/b/c/too_deep"):
        shutil.copytree(REFERENCE, inside / name, dirs_exist_ok=True)
    (inside / "demo/log").mkdir()
    (inside / "demo/notes.txt").write_text("no bag")
    shutil.copy(REFERENCE / "coordinated_0.mcap", inside / "single.mcap")
    shutil.copytree(REFERENCE, tmp_path / "secret")
    (inside / "link").symlink_to(tmp_path / "secret")
    return BagDirectory(inside)


def test_bags_are_listed_with_size_and_length_the_newest_first(bags):
    os.utime(bags.path / "single.mcap", (2e9, 2e9))
    entries = {entry.name: entry for entry in bags.entries()}
    assert next(iter(entries)) == "single.mcap"
    assert set(entries) == {"coordinated", "demo/bag", "a/b/c", "single.mcap"}
    size = sum(file.stat().st_size for file in REFERENCE.iterdir())
    assert entries["demo/bag"].bytes == size
    assert entries["demo/bag"].seconds == pytest.approx(5.3)
    assert entries["single.mcap"].seconds is None


def test_a_directory_that_is_not_there_holds_no_bags(tmp_path):
    assert BagDirectory(tmp_path / "none").entries() == []


@pytest.mark.parametrize("name", ["coordinated", "demo/bag", "a/b/c", "single.mcap"])
def test_a_listed_bag_is_found(bags, name):
    assert bags.existing(name) == bags.path / name


@pytest.mark.parametrize(
    "name",
    [
        *("", ".", "..", "../secret", "demo/../../secret", "demo/..", "/etc", "//", "link", "\0", "a\0b"),
        *("none", "demo", "demo/notes.txt", "coordinated/metadata.yaml", "a/b/c/too_deep"),
        *("\ud800", "x" * 10_000),
    ],
    ids=lambda name: ascii(name)[:20],
)
def test_what_is_no_bag_of_the_directory_is_refused_by_its_name(bags, name):
    with pytest.raises(BagError, match=r"there is no bag .*; allowed: a name of the list"):
        bags.existing(name)


def test_a_bag_without_a_name_has_date_and_time_and_no_two_are_the_same(tmp_path):
    bags = BagDirectory(tmp_path)
    names = set()
    for _ in range(3):
        path = bags.new(None)
        assert path.parent == tmp_path
        path.mkdir()
        names.add(path.name)
    assert len(names) == 3


@pytest.mark.parametrize("name", ["monday", "2026-11-22_shift.2", "a" * 64])
def test_a_new_bag_lies_in_the_directory(bags, name):
    assert bags.new(name) == bags.path / name


@pytest.mark.parametrize("name", ["..", ".hidden", "-o", "a/b", "../x", "a" * 65, "a b", "ä", "x\n", "x\0"])
def test_a_name_that_may_lead_elsewhere_is_refused(bags, name):
    with pytest.raises(BagError, match="cannot be named"):
        bags.new(name)


def test_a_name_that_is_taken_is_refused_also_by_a_broken_link(bags):
    (bags.path / "broken").symlink_to("nowhere")
    for name in ("coordinated", "demo", "broken"):
        with pytest.raises(BagError, match="no bag is overwritten"):
            bags.new(name)


def test_however_many_bags_there_are_none_is_left_out(tmp_path):
    for number in range(600):
        (tmp_path / f"{number}.mcap").touch()
    assert len(BagDirectory(tmp_path).entries()) == 600
