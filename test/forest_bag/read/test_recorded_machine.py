"""A bag's own machine: found by what its nodes said it looks like, whatever else the bag holds."""

import pytest
from bag_fixtures import make_bag

pytest.importorskip("rclpy")

from std_msgs.msg import String

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.recorded_machine import recorded_machine
from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import topics

__all__ = ["make_bag"]

LONG = "name: long\nbased_on: far.yaml\nmanipulator: {boom_length: {value: 4.0, unit: m, source: drawn}}\n"
FAR = "based_on: c180\nmanipulator: {stick_length: {value: 2.4, unit: m, source: drawn}}\n"
ALONE = (  # the same, in one file
    "name: long\nbased_on: c180\nmanipulator:\n"
    "  boom_length: {value: 4.0, unit: m, source: drawn}\n"
    "  stick_length: {value: 2.4, unit: m, source: drawn}\n"
)


@pytest.fixture
def urdf(tmp_path):
    (tmp_path / "far.yaml").write_text(FAR)
    (tmp_path / "long.yaml").write_text(LONG)
    return robot_description(load_machine(tmp_path / "long.yaml"))


@pytest.fixture
def found(make_bag, urdf):
    """Return what is found in a bag that holds some files."""

    def find(*files):
        bag = make_bag({topics.ROBOT_DESCRIPTION: [(1, String(data=urdf))]}, files=files)
        with BagReader(bag) as reader:
            return recorded_machine([reader], urdf)

    return find


def test_the_machine_is_the_one_that_is_described_with_those_it_is_based_on(found):
    machine = found(
        ("machine/c180.yaml", "name: c180\n"), ("machine/long.yaml", LONG), ("machine/far.yaml", FAR)
    )
    assert machine.name == "long"
    assert (machine.manipulator.boom_length, machine.manipulator.stick_length) == (4.0, 2.4)


def test_one_file_is_enough_for_a_machine_that_is_based_on_a_shipped_one(found):
    assert found(("machine/long.yaml", ALONE)) is not None


@pytest.mark.parametrize(
    "files",
    [
        (),
        [("machine/long.yaml", LONG)],  # without what it is based on
        [("machine/far.yaml", FAR)],  # another crane
        [("machine/long.yaml", "a: b: c"), ("machine/far.yaml", "")],
        [("parameters/long.yaml", ALONE), ("machine/../long.yaml", ALONE), ("machine/a/long.yaml", ALONE)],
        [("machine/long.yaml", "based_on: long.yaml\n")],
        [
            ("machine/..", ALONE),
            ("machine/", ALONE),
            ("/machine/long.yaml", ALONE),
            ("machine/\0.yaml", ALONE),
        ],
    ],
)
def test_what_is_no_machine_or_another_is_passed_over(found, files):
    assert found(*files) is None


def test_nothing_is_written_but_into_a_folder_that_goes(found, tmp_path, monkeypatch):
    kept = tmp_path / "temporary"
    kept.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(kept))
    assert found(("machine/long.yaml", LONG), ("machine/far.yaml", FAR)) is not None
    assert not list(kept.iterdir())
