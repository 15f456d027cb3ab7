"""The margin against tipping over: sums of moments about a line, and a vehicle let go on a slope."""

import cmath
import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import vectors
from scipy.optimize import brentq

from forest_description.config.parameter import MachineError
from forest_description.derived.tip_over import tip_over_margins
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine

MACHINE = load_machine("forwarder")
M, CHASSIS = MACHINE.manipulator, MACHINE.chassis
LEFT = (math.pi / 2, 0.0, 0.0)


def test_the_margin_is_the_sum_of_moments_about_the_wheel_line():
    out = M.base_offset + M.boom_length + M.stick_length - CHASSIS.half_width
    holding = CHASSIS.mass * CHASSIS.half_width + M.base_mass * (CHASSIS.half_width - M.base_x)
    tipping = M.head_mass * out
    tipping += M.boom_mass * (M.base_offset + M.boom_x - CHASSIS.half_width)
    tipping += M.stick_mass * (M.base_offset + M.boom_length + M.stick_x - CHASSIS.half_width)
    empty, full = (tip_over_margins(CHASSIS, M, LEFT, mass) for mass in (0.0, 200.0))
    assert empty.left == pytest.approx(1.0 - tipping / holding)
    assert full.left - empty.left == pytest.approx(-200.0 * out / holding)
    assert empty.right == 1.0


def test_the_side_to_which_the_crane_swings_counts():
    turns = (0.0, math.pi / 2, math.pi, -math.pi / 2)
    for turn, name in zip(turns, ("ahead", "left", "behind", "right"), strict=True):
        margins = tip_over_margins(CHASSIS, M, (turn, 0.2, -0.4), 400.0)
        assert min(margins) == getattr(margins, name) < 1.0


def _potential(tilt, angles, log):
    """Return the potential energy over g [kg m] of a vehicle that stands on its left line alone [rad]."""
    swing, boom, pitch = angles[0], cmath.exp(1j * angles[1]), cmath.exp(1j * (angles[1] + angles[2]))
    foot = complex(M.base_offset, CHASSIS.pivot_height)
    elbow = foot + M.boom_length * boom
    places = (
        (M.base_mass, complex(M.base_x, CHASSIS.pivot_height)),
        (M.boom_mass, foot + boom * complex(M.boom_x, M.boom_y)),
        (M.stick_mass, elbow + pitch * complex(M.stick_x, M.stick_y)),
        (M.head_mass + log, elbow + pitch * M.stick_length),
    )
    crane = [(mass, math.sin(swing) * place.real, place.imag) for mass, place in places]
    weights = [(CHASSIS.mass, 0.0, CHASSIS.centre_height), *crane]
    return sum(
        mass * (math.sin(tilt) * (y - CHASSIS.half_width) + math.cos(tilt) * z) for mass, y, z in weights
    )


@pytest.mark.parametrize("log", [0.0, 900.0])
def test_a_vehicle_without_margin_is_balanced_on_its_wheels(log):
    """There its weight is highest: to lean it further takes no work."""
    angles = 1.2, 0.3, -0.6

    def margin(tilt):
        return tip_over_margins(CHASSIS, dataclasses.replace(M, platform_tilt=tilt), angles, log).left

    balance = brentq(margin, -0.9, 0.0)
    slope = _potential(balance + 1e-5, angles, log) - _potential(balance - 1e-5, angles, log)
    steep = _potential(2e-5, angles, log) - _potential(0.0, angles, log)
    assert abs(slope) < 1e-6 * abs(steep)
    assert margin(balance - 0.01) < 0.0 < margin(balance + 0.01)


def test_a_vehicle_that_falls_over_by_itself_is_refused():
    with pytest.raises(MachineError, match=r"centre_ahead \(5 m\).*allowed: between -2.5 m and 4.5 m"):
        dataclasses.replace(CHASSIS, centre_ahead=5.0)


@given(vectors(-3.2, 3.2), st.floats(0.0, 3000.0))
def test_in_any_pose_sides_mirror_a_turn_turns_them_and_a_load_beyond_a_line_takes_from_it(angles, log):
    swing, boom, stick = angles
    margins = tip_over_margins(CHASSIS, M, angles, log)
    assert all(margin <= 1.0 for margin in margins)
    mirrored = tip_over_margins(CHASSIS, M, (-swing, boom, stick), log)
    assert (mirrored.left, mirrored.right) == pytest.approx((margins.right, margins.left), abs=1e-9)
    assert (mirrored.ahead, mirrored.behind) == pytest.approx((margins.ahead, margins.behind), abs=1e-9)
    x, y, _ = tip_position(angles, M.links)
    more = tip_over_margins(CHASSIS, M, angles, log + 100.0)
    lines = CHASSIS.ahead, CHASSIS.half_width, CHASSIS.behind, CHASSIS.half_width
    for before, after, out, line in zip(margins, more, (x, y, -x, -y), lines, strict=True):
        assert after < before if out > line + 0.01 else after >= before - 1e-12 or out > line
