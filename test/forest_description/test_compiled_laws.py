"""Claims that the pure laws are in the subset that Numba compiles, with the same results."""

import dataclasses
import functools
import types

import pytest

from forest_description.derived import actuator_kinematics
from forest_description.geometry import kinematics, linkage
from forest_description.hydraulics import valve_characteristic
from forest_description.hydraulics.valve_parameters import PolynomialCurve, TableCurve
from forest_description.machine import load_machine

numba = pytest.importorskip("numba")

MACHINE = load_machine("c180_hoses")
LINKS = MACHINE.manipulator.links
TABLE = dataclasses.replace(
    MACHINE.valve, curve=TableCurve((2.0, 5.0, 10.0), (5e13, 1e13, 1e12)), leakage_conductance=1e-13
).law
POLYNOMIAL = dataclasses.replace(MACHINE.valve, curve=PolynomialCurve((101.0, -20.0, 1.0))).law
Q, RATES = (0.3, 0.5, -1.4), (0.2, -0.3, 0.4)


@functools.cache
def compiled(function):
    """Compile a function of ours and all of ours that it calls."""
    scope = dict(function.__globals__)
    for name in function.__code__.co_names:
        inner = scope.get(name)
        if isinstance(inner, types.FunctionType) and inner.__module__.startswith("forest_description"):
            scope[name] = compiled(inner)
    return numba.njit(types.FunctionType(function.__code__, scope, function.__name__))


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (kinematics.tip_position, (Q, LINKS)),
        (kinematics.jacobian, (Q, LINKS)),
        (kinematics.jacobian_determinant, (Q, LINKS)),
        (kinematics.is_singular, (Q, LINKS)),
        (kinematics.tip_velocity, (Q, RATES, LINKS)),
        (kinematics.joint_rates, (Q, RATES, LINKS)),
        (kinematics.nearest_pose, ((5.0, 1.0, 0.5), Q, LINKS)),
        (linkage.cylinder_length, (0.5, MACHINE.boom.linkage)),
        (linkage.lever_arm, (0.5, MACHINE.boom.linkage)),
        (valve_characteristic.stroke, (3.0, MACHINE.valve.law.forward)),
        (valve_characteristic.opening_at, (0.3, MACHINE.valve.law.curve)),
        (valve_characteristic.opening_at, (0.3, TABLE.curve)),
        (valve_characteristic.opening_at, (0.3, POLYNOMIAL.curve)),
        (valve_characteristic.resistance_at, (0.3, 1e12)),
        (valve_characteristic.edges, (3.0, MACHINE.valve.law)),
        (valve_characteristic.edges, (-3.0, TABLE)),
        (valve_characteristic.edges, (3.0, POLYNOMIAL)),
        (valve_characteristic.voltage_for_opening, (-0.3, MACHINE.valve.law)),
        (valve_characteristic.voltage_for_opening, (-0.3, TABLE)),
        (actuator_kinematics.joint_rates_to_actuator_speeds, (Q, RATES, MACHINE.linkages)),
        (actuator_kinematics.actuator_speeds_to_joint_rates, (Q, RATES, MACHINE.linkages)),
    ],
    ids=lambda item: getattr(item, "__name__", ""),
)
def test_law_compiles_and_agrees_with_itself_in_python(function, arguments):
    expected, result = function(*arguments), compiled(function)(*arguments)
    for ours, theirs in zip(flat(expected), flat(result), strict=True):
        assert theirs == pytest.approx(ours, rel=1e-14, abs=1e-15)


def flat(value):
    return [number for item in value for number in flat(item)] if isinstance(value, tuple) else [value]
