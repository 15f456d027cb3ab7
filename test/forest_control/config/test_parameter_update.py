"""Parameters that are set faster than a change fades: the newest counts, later."""

import pytest

from forest_control.config import controller_settings
from forest_control.config.controller_settings import Settings
from forest_control.config.parameter_update import ParameterUpdate
from forest_control.servo.schemes import Scheme
from forest_description.machine import load_machine

PERIOD = 0.005  # [s]
A = controller_settings.parameters(load_machine("c180"), Settings())
B, C, D = (A._replace(following_error_limit=0.1 * k) for k in (3, 4, 5))


def of(scheme):
    return A._replace(scheme=int(scheme))


def test_what_nobody_has_changed_stays():
    tuning = ParameterUpdate(A)
    assert not tuning.apply_if_due(True, PERIOD)
    assert tuning.core == A


def test_a_change_counts_at_once_and_of_those_after_it_the_newest_when_it_has_faded():
    tuning = ParameterUpdate(A)
    tuning.request(B)
    assert tuning.apply_if_due(False, PERIOD)
    waited = 0.0
    for name in (C, D):
        tuning.request(name)
        assert not tuning.apply_if_due(False, PERIOD)
    while not tuning.apply_if_due(False, PERIOD):
        waited += PERIOD
        assert tuning.core == B
    assert waited == pytest.approx(1.0, abs=4 * PERIOD)  # [s]
    assert tuning.core == D


def test_while_nothing_moves_every_change_counts_at_once():
    tuning = ParameterUpdate(A)
    for name in (B, C, D):
        tuning.request(name)
        assert tuning.apply_if_due(True, PERIOD)
        assert tuning.core == name
    assert not tuning.apply_if_due(True, PERIOD)


@pytest.mark.parametrize("tip_scheme", [scheme for scheme in Scheme if scheme != Scheme.JOINT])
@pytest.mark.parametrize("to_joint", [True, False])
def test_what_a_lever_moves_changes_only_while_nothing_moves(tip_scheme, to_joint):
    old, new = (of(tip_scheme), of(Scheme.JOINT)) if to_joint else (of(Scheme.JOINT), of(tip_scheme))
    tuning = ParameterUpdate(old)
    tuning.request(new)
    assert not any(tuning.apply_if_due(False, PERIOD) for _ in range(2000))
    assert tuning.core == old
    assert tuning.apply_if_due(True, PERIOD)
    assert tuning.core == new


def test_a_scheme_of_the_tip_takes_over_from_another_in_mid_motion():
    tuning = ParameterUpdate(of(Scheme.COORDINATED))
    tuning.request(of(Scheme.IK_POSITION))
    assert tuning.apply_if_due(False, PERIOD)
