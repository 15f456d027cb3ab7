"""Claims that the pure laws are in the subset that Numba compiles, with the same results."""

import types

import pytest

from forest_description import actuation, kinematics, linkage, valve
from forest_description.machine import load_machine

numba = pytest.importorskip("numba")

MACHINE = load_machine()
LINKS = MACHINE.manipulator.links
Q, RATES = (0.3, 0.5, -1.4), (0.2, -0.3, 0.4)


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
        (linkage.cylinder_length, (0.5, MACHINE.boom.linkage)),
        (linkage.lever_arm, (0.5, MACHINE.boom.linkage)),
        (valve.orifice_opening, (-3.0, MACHINE.valve.law)),
        (valve.orifice_resistance, (3.0, MACHINE.valve.law)),
        (valve.voltage_for_opening, (-0.3, MACHINE.valve.law)),
        (actuation.joint_rates_to_actuator_speeds, (Q, RATES, MACHINE.linkages)),
        (actuation.actuator_speeds_to_joint_rates, (Q, RATES, MACHINE.linkages)),
    ],
    ids=lambda item: getattr(item, "__name__", ""),
)
def test_law_compiles_and_agrees_with_itself_in_python(function, arguments):
    expected, result = function(*arguments), compiled(function)(*arguments)
    for ours, theirs in zip(flat(expected), flat(result), strict=True):
        assert theirs == pytest.approx(ours, rel=1e-14, abs=1e-15)


def flat(value):
    return [number for item in value for number in flat(item)] if isinstance(value, tuple) else [value]
