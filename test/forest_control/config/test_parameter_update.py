"""Parameters that are set faster than a change fades: the newest counts, later."""

import pytest

from forest_control.config.parameter_update import SETTLED, Retuning

PERIOD = 0.005  # [s]


def test_a_change_counts_at_once_and_of_those_after_it_the_newest_when_it_has_faded():
    tuning = Retuning("a")
    tuning.want("b")
    assert tuning.changes(False, PERIOD)
    waited = 0.0
    for name in ("c", "d"):
        tuning.want(name)
        assert not tuning.changes(False, PERIOD)
    while not tuning.changes(False, PERIOD):
        waited += PERIOD
        assert tuning.core == "b"
    assert waited == pytest.approx(SETTLED, abs=4 * PERIOD)
    assert tuning.core == "d"


def test_while_nothing_moves_every_change_counts_at_once():
    tuning = Retuning("a")
    for name in ("b", "c", "d"):
        tuning.want(name)
        assert tuning.changes(True, PERIOD)
        assert tuning.core == name
    assert not tuning.changes(True, PERIOD)
