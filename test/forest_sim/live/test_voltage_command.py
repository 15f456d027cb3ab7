"""Claims about the valves' input: a bad, late or overtaken command centres the valves."""

from forest_description.types import ZERO
from forest_sim.live.voltage_command import VoltageInput

TIMEOUT = 0.2
VOLTS = (4.0, -4.0, 2.0)


def test_nothing_was_ever_commanded():
    assert VoltageInput(TIMEOUT).at(0.0) == ZERO
    assert VoltageInput(TIMEOUT).is_missed(0.0)


def test_a_command_holds_until_the_timeout():
    valves = VoltageInput(TIMEOUT)
    assert valves.take(VOLTS, 1, 10.0) == ""
    assert valves.at(10.0 + 0.99 * TIMEOUT) == VOLTS
    assert valves.at(10.0 + 1.01 * TIMEOUT) == ZERO
    assert valves.is_missed(10.0 + 1.01 * TIMEOUT)


def test_a_bad_message_centres_the_valves():
    valves = VoltageInput(TIMEOUT)
    valves.take(VOLTS, 1, 10.0)
    assert valves.take((), 0, 10.01, "valve_voltages: 2 values") == "valve_voltages: 2 values"
    assert valves.at(10.01) == ZERO
    assert not valves.is_missed(10.01)


def test_a_command_that_was_overtaken_centres_the_valves():
    valves = VoltageInput(TIMEOUT)
    valves.take(VOLTS, 2_000_000, 10.0)
    assert "the stamp goes back" in valves.take(VOLTS, 1_000_000, 10.01)
    assert valves.at(10.01) == ZERO


def test_zero_is_obeyed_in_any_order():
    valves = VoltageInput(TIMEOUT)
    valves.take(VOLTS, 2_000_000, 10.0)
    assert valves.take(ZERO, 1_000_000, 10.01) == ""
    assert valves.at(10.01) == ZERO
    assert valves.take(VOLTS, 3_000_000, 10.02) == ""
