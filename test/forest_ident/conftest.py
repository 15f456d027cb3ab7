"""Machines that nobody told."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.parameter_path import value_of, with_values

LONGEST = {"motor_internal": 60.0, "motor_external": 40.0, "validation": 25.0, "damping_swing": 40.0}  # [s]
DRAWN = {
    "valve.deadband_voltage": 1.3,
    "valve.minimum_resistance": 1.25,
    "hose.turbulent_resistance": 0.7,
    "hose.inertance": 0.75,
    "hose.capacitance": 1.3,
    "swing.internal_leakage_resistance": 0.65,
    "swing.external_leakage_resistance": 1.35,
    "swing.damping": 1.4,
}


@pytest.fixture(scope="session")
def unknown_machine():
    """The shipped crane with some parameters that the estimators are not told."""
    machine = load_machine("c180_hoses")
    drawn = with_values(machine, {key: share * value_of(machine, key) for key, share in DRAWN.items()})
    return dataclasses.replace(drawn, name="unknown")


@pytest.fixture(scope="session")
def sessions(unknown_machine):
    """Experiments with the sensors of Table 4.2, made once for all tests that only look at them."""
    kept = {}

    def get(name, exact=False):
        if (name, exact) not in kept:
            longest = LONGEST.get(name, math.inf)
            kept[name, exact] = experiment(name, unknown_machine, 7, exact, longest)
        return kept[name, exact]

    return get


@pytest.fixture
def start_node(start_process: Callable[..., Any]) -> Callable[..., Any]:
    """Starts a node of forest_ident by its module's name; further arguments are ``--ros-args``."""

    def start(module: str, *ros_args: str) -> Any:
        return start_process(["-m", f"forest_ident.{module}", "--ros-args", *ros_args])

    return start
