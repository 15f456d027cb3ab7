"""Claims about the crane as it would be built, `c180`: what each law of driver and servo is worth.

Each is tried against a controller and driver that believe a machine without the effect.
"""

import dataclasses
from functools import lru_cache

import pytest

from forest_control.servo.schemes import Scheme
from forest_description.machine import load_machine
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import noisy, track

REAL = load_machine("c180")


def plain(drive):
    """A drive without the oil of its chambers, and without the valves that hold it."""
    return dataclasses.replace(drive, chambers=None, holding_1=None, holding_2=None)


WITHOUT = {
    "hysteresis": dataclasses.replace(REAL, valve=dataclasses.replace(REAL.valve, hysteresis=None)),
    "chambers": dataclasses.replace(REAL, boom=plain(REAL.boom), stick=plain(REAL.stick)),
    "dead time": dataclasses.replace(REAL, valve=dataclasses.replace(REAL.valve, dead_time=None)),
    "tank line": dataclasses.replace(REAL, tank_line=None),
}


@lru_cache
def score(path, unknown=""):
    """How close the tip stays to its reference at 0.5 m/s, with noise [mm]."""
    model = WITHOUT[unknown] if unknown else REAL
    return track(path_named(path), 0.5, Scheme.COORDINATED, REAL, model, noisy(REAL, 0)).total


@pytest.mark.parametrize(("path", "most"), [("vertical", 1.3), ("sweep", 6.6)])
def test_hysteresis_is_compensated(path, most):
    assert score(path).governed_rms_mm < most
    assert score(path, "hysteresis").governed_rms_mm > 3.0 * most


@pytest.mark.parametrize("unknown", ["chambers", "tank line"])
def test_oil_that_must_be_pressed_first_and_the_tank_line_are_allowed_for(unknown):
    assert score("radial").governed_rms_mm < 1.3
    assert score("radial", unknown).governed_rms_mm > 1.4


def test_the_lead_makes_up_for_a_dead_time():
    assert score("radial").governed_rms_mm < 1.3
    assert score("radial", "dead time").governed_rms_mm > 1.4


def test_the_oil_that_a_growing_load_takes_up_is_fed_forward():
    assert score("vertical").governed_max_mm < 3.6
    assert score("vertical", "chambers").governed_max_mm > 4.0
