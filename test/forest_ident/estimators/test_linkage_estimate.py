"""Records that have a cylinder's length and its joint's angle tell where the cylinder's pivots are."""

import dataclasses

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.linkage_estimate import pivots
from forest_ident.measurements.readings import length_and_arm
from forest_ident.measurements.session import Session
from forest_ident.refinement.identification import identify

TOLD = load_machine("c180_hoses")
TAPE = 0.004  # [m]
TRUE = dataclasses.replace(
    TOLD,
    boom=dataclasses.replace(TOLD.boom, pivot_to_base=TOLD.boom.pivot_to_base + TAPE),
    stick=dataclasses.replace(TOLD.stick, pivot_to_rod=TOLD.stick.pivot_to_rod - TAPE),
)
KEYS = [f"{axis}.{pivot}" for axis in ("boom", "stick") for pivot in ("pivot_to_base", "pivot_to_rod")]


def swept(seed=0, bias=0.002):
    """Return a slow sweep of boom and stick, read by sensors of Table 4.2, the resolvers off by a bias."""
    time, random = np.arange(8000) * 0.005, np.random.default_rng(seed)
    readings = {"swing_resolver": np.zeros(len(time))}
    for axis in ("boom", "stick"):
        drive = getattr(TRUE, axis)
        low, high = drive.angles
        q = 0.5 * (low + high) + 0.4 * (high - low) * np.sin(2.0 * np.pi * time / 40.0)
        length = length_and_arm(q, drive.linkage)[0] + random.normal(0.0, 0.00018, len(q))
        readings[f"{axis}_resolver"] = q + bias + random.normal(0.0, 0.0002, len(q))
        readings[f"{axis}_transducer"] = 0.0004 * np.round(length / 0.0004)
    return Session("deadband_boom", time, np.zeros((len(time), 3)), readings)


def truth(key):
    axis, pivot = key.split(".")
    return getattr(getattr(TRUE, axis), pivot)


def test_pivots_are_found_to_a_third_of_a_millimetre_whatever_the_resolvers_are_off():
    found = {e.key: e for e in pivots(TOLD, [swept()])}
    assert list(found) == KEYS
    for key, e in found.items():
        assert e.value == pytest.approx(truth(key), abs=3e-4)
        assert e.standard_error < 3e-4


def test_which_pivot_is_the_greater_is_told_by_the_start_and_changes_no_error():
    def turned(drive):
        return dataclasses.replace(drive, pivot_to_base=drive.pivot_to_rod, pivot_to_rod=drive.pivot_to_base)

    other = dataclasses.replace(TOLD, boom=turned(TOLD.boom), stick=turned(TOLD.stick))
    one, two, three, four = pivots(TOLD, [swept()])
    found = [(e.value, e.standard_error) for e in pivots(other, [swept()])]
    expected = [(e.value, e.standard_error) for e in (two, one, four, three)]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_their_intervals_hold():
    away = [
        (e.value - truth(e.key)) / e.standard_error for seed in range(40) for e in pivots(TOLD, [swept(seed)])
    ]
    assert np.mean(np.abs(away) < 1.96) == pytest.approx(0.95, abs=0.04)


def test_a_fit_takes_them_with_their_errors_in_place_of_what_was_told():
    found = identify(TOLD, [swept()], refine=False)
    assert found.machine.boom.pivot_to_base == pytest.approx(TRUE.boom.pivot_to_base, abs=3e-4)
    assert set(KEYS) <= set(found.estimates)
    assert found.stated["boom.pivot_to_base"] < 3e-4


def test_a_person_who_told_them_more_closely_is_believed():
    stated = dict.fromkeys(KEYS, 1e-6)
    assert identify(TOLD, [swept()], refine=False, stated=stated).machine.boom == TOLD.boom


def test_what_hardly_moves_tells_no_linkage():
    assert pivots(TOLD, [swept().part(0, 200)]) == []
