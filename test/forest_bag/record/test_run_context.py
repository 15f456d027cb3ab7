"""The bag alone can make the run again: machine, parameters, versions and seeds are in it."""

import re

import pytest
import yaml

from forest_bag.record.run_context import RunContext, versions
from forest_description.machine import load_machine


class Bag:
    def __init__(self):
        self.files, self.notes, self.complaints = {}, {}, []
        self.context = RunContext(self.attach, self.note, self.complaints.append)

    def attach(self, file):
        self.files.setdefault(file.name, file.data.decode())

    def note(self, name, values):
        self.notes[name] = values


@pytest.fixture
def bag():
    return Bag()


def test_parameters_are_a_file_as_ros_takes_it(bag):
    bag.context.node("/crane_1/simulator", {"seed": 7, "noise": True, "tip": [1.0, 2.0]}, 5)
    parameters = yaml.safe_load(bag.files["parameters/crane_1/simulator.yaml"])
    assert parameters == {
        "/crane_1/simulator": {"ros__parameters": {"seed": 7, "noise": True, "tip": [1.0, 2.0]}}
    }
    assert bag.notes["forest_seeds"] == {"/crane_1/simulator": "7"}


def test_the_machine_can_be_loaded_from_the_bag_s_files(bag, tmp_path):
    source = tmp_path / "mine.yaml"
    source.write_text("based_on: c180\ndescription: mine\n")
    bag.context.node("/simulator", {"machine": str(source)}, 5)
    bag.context.node("/controller", {"machine": str(source)}, 5)
    assert [name for name in bag.files if name.startswith("machine/")] == [
        "machine/mine.yaml",
        "machine/c180.yaml",
        "machine/c180_hoses.yaml",
        "machine/c180_thesis.yaml",
    ]
    copy = tmp_path / "from_bag" / "mine.yaml"
    copy.parent.mkdir()
    copy.write_text(bag.files["machine/mine.yaml"])
    assert load_machine(copy) == load_machine(source)


def test_a_machine_that_is_not_here_is_told_and_nothing_more(bag):
    bag.context.node("/simulator", {"machine": "/nowhere/mine.yaml"}, 5)
    (complaint,) = bag.complaints
    assert re.match("the machine file is not in the bag: /nowhere/mine.yaml", complaint)
    assert list(bag.files) == ["parameters/simulator.yaml"]


def test_versions_name_python_and_what_computes():
    assert {"python", "platform", "numpy", "mcap"} <= versions().keys()
