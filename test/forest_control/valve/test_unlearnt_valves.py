"""A driver that cannot learn a valve says why."""

import dataclasses

import pytest

from forest_control.valve.unlearnt_valves import told, unlearnt_valves
from forest_description.machine import load_machine

C180 = load_machine("c180_hoses")


def without(sensor):
    return dataclasses.replace(C180, sensors=dataclasses.replace(C180.sensors, **{sensor: None}))


def test_a_crane_that_measures_all_has_nothing_to_say():
    assert told(C180) == ""


def test_a_loader_without_transducers_on_its_cylinders_learns_its_swing_alone():
    lack = "no sensor of its actuator's position"
    assert unlearnt_valves(load_machine("loader")) == {"boom": lack, "stick": lack}


def test_valves_behind_compensators_are_learnt():
    assert told(load_machine("forwarder")) == ""


@pytest.mark.parametrize(
    ("sensor", "axes"), [("pressure", ("swing", "boom", "stick")), ("resolver", ("swing",))]
)
def test_a_missing_sensor_is_named_where_it_counts(sensor, axes):
    found = unlearnt_valves(without(sensor))
    assert tuple(found) == axes


def test_a_valve_without_overlap_is_named():
    valve = dataclasses.replace(C180.valve, deadband_voltage=-0.1, backward=None)
    assert told(dataclasses.replace(C180, valve=valve)).startswith("swing: open at the centre")
