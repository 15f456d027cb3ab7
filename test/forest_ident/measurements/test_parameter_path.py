"""Numbers of a machine by their dotted path."""

import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_ident.measurements.parameter_path import value_of, with_directions, with_values

C180 = with_directions(load_machine("c180_hoses"), "valve")


def test_numbers_that_only_together_make_a_machine_are_set_together():
    areas = {"boom.rod_area": 0.02, "boom.head_area": 0.03}
    with pytest.raises(MachineError, match="head_area"):
        with_values(C180, {"boom.rod_area": 0.02})  # more than the head's
    for order in (areas, dict(reversed(areas.items()))):
        assert {key: value_of(with_values(C180, order), key) for key in areas} == areas


def test_a_section_and_one_within_it_are_both_set():
    wanted = {"valve.backward.deadband_voltage": 0.7, "valve.deadband_voltage": 0.9, "swing.damping": 3e4}
    machine = with_values(C180, wanted)
    assert {key: value_of(machine, key) for key in wanted} == wanted


def test_what_a_machine_does_not_have_is_refused_by_name():
    with pytest.raises(MachineError, match=r"no number valve\.colour"):
        with_values(C180, {"valve.colour": 1.0})
