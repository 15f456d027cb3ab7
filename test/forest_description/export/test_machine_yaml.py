import dataclasses

import pytest

from forest_description.export.machine_yaml import machine_text
from forest_description.machine import load_machine


@pytest.mark.parametrize("name", ["c180_hoses", "c180", "c180_thesis", "forwarder", "loader"])
def test_a_machine_that_was_written_is_read_back_to_the_last_bit(name, tmp_path):
    machine, file = load_machine(name), tmp_path / "again.yaml"
    file.write_text(machine_text(machine, 'a test: "quoted"'), encoding="utf-8")
    assert load_machine(file) == dataclasses.replace(machine, name="again")
