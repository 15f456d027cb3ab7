"""Claims about the crane as it would be built, `c180_real`: what each law of driver and servo is worth.

Each is tried against a controller and driver that believe a machine without the effect.
"""

import dataclasses
from functools import lru_cache

import pytest

from forest_control.servo.schemes import Scheme
from forest_description.machine import load_machine
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import noisy, track

REAL = load_machine("c180_real")
WITHOUT = {
    "hysteresis": dataclasses.replace(REAL, valve=dataclasses.replace(REAL.valve, hysteresis=None)),
}


@lru_cache
def score(path, unknown=""):
    """How close the tip stays to its reference at 0.5 m/s, with noise [mm]."""
    model = WITHOUT[unknown] if unknown else REAL
    return track(path_named(path), 0.5, Scheme.COORDINATED, REAL, model, noisy(REAL, 0)).total


@pytest.mark.parametrize(("path", "most"), [("vertical", 2.2), ("sweep", 6.0)])
def test_hysteresis_is_compensated(path, most):
    assert score(path).rms_mm < most
    assert score(path, "hysteresis").rms_mm > 3.0 * most
