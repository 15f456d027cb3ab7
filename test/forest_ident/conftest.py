"""Machines that nobody told."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.everyday import numbers
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.refinement import stated_numbers

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


FEW = (
    "pump.supply_pressure",
    "swing.valve.deadband_voltage",
    "swing.damping",
    "boom.valve.deadband_voltage",
    "boom.valve.backward.deadband_voltage",
    "boom.valve.backward.minimum_resistance",
    "stick.damping",
)


@pytest.fixture(scope="session")
def drifted_file(tmp_path_factory):
    """The machine file of a crane that has drifted."""
    from everyday_work import DRIFTED  # takes the closed loop along

    file = tmp_path_factory.mktemp("drifted") / "drifted.yaml"
    file.write_text(DRIFTED)
    return file


@pytest.fixture(scope="session")
def drifted(drifted_file):
    """The machine of that file."""
    return load_machine(drifted_file)


@pytest.fixture
def few_numbers(monkeypatch):
    """Ask everyday work for `FEW`, and take all that is told as exact: a fit of seconds."""
    monkeypatch.setattr(numbers, "wanted", lambda _machine: FEW)
    monkeypatch.setattr(stated_numbers, "errors", lambda _machine, _stated: {})
    return FEW
