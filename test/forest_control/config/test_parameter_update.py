"""Parameters that are set faster than a change fades: the newest counts, later."""

import pytest

from forest_control.config.parameter_update import ParameterUpdate

PERIOD = 0.005  # [s]


def test_what_nobody_has_changed_stays():
    tuning = ParameterUpdate("a")
    assert not tuning.apply_if_due(True, PERIOD)
    assert tuning.core == "a"


def test_a_change_counts_at_once_and_of_those_after_it_the_newest_when_it_has_faded():
    tuning = ParameterUpdate("a")
    tuning.request("b")
    assert tuning.apply_if_due(False, PERIOD)
    waited = 0.0
    for name in ("c", "d"):
        tuning.request(name)
        assert not tuning.apply_if_due(False, PERIOD)
    while not tuning.apply_if_due(False, PERIOD):
        waited += PERIOD
        assert tuning.core == "b"
    assert waited == pytest.approx(1.0, abs=4 * PERIOD)  # [s]
    assert tuning.core == "d"


def test_while_nothing_moves_every_change_counts_at_once():
    tuning = ParameterUpdate("a")
    for name in ("b", "c", "d"):
        tuning.request(name)
        assert tuning.apply_if_due(True, PERIOD)
        assert tuning.core == name
    assert not tuning.apply_if_due(True, PERIOD)
