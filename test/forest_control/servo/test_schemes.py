"""Claims about the servos of schemes (c) and (d), around the plant of thesis section 5.2.

The thesis' plant is v' = -w_n v + W_0 u' with W_0 = 2 pi 2 Hz whatever w_n is; here u asks for a rate and the
plant is v' = w_n (u - v). Both agree with u = u' W_0 / w_n, which scales K_v, K_p and K_d alike.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

from forest_control.servo.schemes import (
    LABELS,
    Gains,
    Scheme,
    Signals,
    closes_on_position,
    joint,
    position_servo,
    scheme_named,
    servo,
    velocity_servo,
)

W_0 = 2.0 * math.pi * 2.0
DAMPING_RATIO = 1.64


class Design(NamedTuple):
    """A column of gains of section 5.2, and the pole that it is made for [rad/s]."""

    bandwidth: float  # of the plant, Hz
    pole: float
    k_v: float
    k_star: float
    k_p: float
    k_d: float

    @property
    def w_n(self):
        return 2.0 * math.pi * self.bandwidth

    @property
    def scale(self):
        return W_0 / self.w_n


DESIGNS = [Design(2.0, 16.5, 0.313, 4.195, 21.66, 3.307), Design(0.2, 11.5, 0.815, 1.123, 10.52, 2.902)]


def jacobian_velocity(a, v, k_v):
    return velocity_servo(Signals(a, 0.0, 0.0, 0.0, v, 0.0), Gains(k_v, 0.0, 0.0, 0.0, 0.0))


def jacobian_position(r, s, v, k_p, k_d):
    return position_servo(Signals(0.0, 0.0, r, s, v, 0.0), Gains(0.0, k_p, k_d, 0.0, 0.0))


each_design = pytest.mark.parametrize("design", DESIGNS, ids=["2 Hz", "0.2 Hz"])


def velocity_loop(d):
    """(pole, gain from wished to actual rate at rest) of scheme (c) around the plant."""

    def rate_change(a, v):
        return d.w_n * (jacobian_velocity(a, v, d.scale * d.k_v) - v)

    pole, drive = -rate_change(0.0, 1.0), rate_change(1.0, 0.0)
    return pole, drive / pole


def position_loop(d):
    """System matrix and input column of scheme (d) around the plant, state (angle, rate)."""

    def rate_change(r, s, v):
        return d.w_n * (jacobian_position(r, s, v, d.scale * d.k_p, d.scale * d.k_d) - v)

    system = np.array([[0.0, 1.0], [rate_change(0.0, 1.0, 0.0), rate_change(0.0, 0.0, 1.0)]])
    return system, np.array([0.0, rate_change(1.0, 0.0, 0.0)])


@each_design
def test_velocity_servo_has_the_closed_loop_pole_of_the_thesis(design):
    assert velocity_loop(design)[0] == pytest.approx(design.pole, rel=1e-3)


@each_design
def test_pre_loop_gain_makes_the_velocity_servo_exact_at_rest(design):
    assert velocity_loop(design)[1] == pytest.approx(1.0, rel=1e-12)


@each_design
def test_pre_loop_gain_is_that_of_the_thesis(design):
    scaled = design.scale * design.k_v
    assert jacobian_velocity(1.0, 0.0, scaled) / scaled == pytest.approx(design.k_star, rel=1e-3)


@each_design
def test_position_servo_has_the_natural_frequency_and_damping_of_the_thesis(design):
    system, _ = position_loop(design)
    frequency = math.sqrt(np.linalg.det(system))
    assert frequency == pytest.approx(design.pole, rel=1e-3)
    assert -np.trace(system) / (2.0 * frequency) == pytest.approx(DAMPING_RATIO, rel=1e-3)
    assert all(np.linalg.eigvals(system).real < 0.0)


@each_design
def test_position_servo_ends_on_its_reference(design):
    system, drive = position_loop(design)
    assert -np.linalg.solve(system, drive) == pytest.approx([1.0, 0.0], abs=1e-12)


def test_position_servo_wishes_nothing_at_its_reference_and_brakes_motion():
    assert jacobian_position(0.7, 0.7, 0.0, 6.0, 0.5) == 0.0
    assert jacobian_position(0.7, 0.7, 0.2, 6.0, 0.5) == pytest.approx(-0.1)


def test_velocity_servo_passes_a_wish_that_is_met():
    assert jacobian_velocity(0.3, 0.3, 0.313) == pytest.approx(0.3, rel=1e-12)


def test_joint_scheme_passes_the_wish_open_loop():
    assert joint(Signals(0.3, 0.1, 1.0, 0.9, 0.2, 0.1), Gains(0.3, 5.0, 1.0, 5.0, 0.1)) == 0.3


MOVING = Signals(a=0.3, b=0.1, r=1.0, s=0.9, v=0.2, w=0.1)
GAINS = Gains(velocity=0.3, position=5.0, damping=1.0, feedback=5.0, lead_time=0.1)


@pytest.mark.parametrize("scheme", list(Scheme)[1:])
def test_no_scheme_runs_the_open_loop_for_want_of_a_law(scheme):
    assert servo(scheme, MOVING, GAINS) != joint(MOVING, GAINS)


@pytest.mark.parametrize("scheme", Scheme)
def test_a_scheme_closes_on_position_exactly_if_its_law_hears_the_reference(scheme):
    further = MOVING._replace(r=MOVING.r + 0.1)
    assert closes_on_position(scheme) == (servo(scheme, further, GAINS) != servo(scheme, MOVING, GAINS))


def test_schemes_have_the_names_that_users_type():
    names = "joint", "ik_velocity", "ik_position", "jacobian_velocity", "jacobian_position", "coordinated"
    assert names == LABELS
    assert [scheme_named(name) for name in names] == list(Scheme)
