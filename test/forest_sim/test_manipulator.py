"""Rigid-body dynamics: structure that M, V and G must have whatever the numbers."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_sim.manipulator import dynamics, fold_head

MANIPULATOR = load_machine("c180").manipulator
BODY = fold_head(MANIPULATOR)
TILTED = BODY._replace(gravity_across=9.81 * np.sin(0.2), gravity_down=9.81 * np.cos(0.2))
H = 1e-6


def poses(count, seed):
    return np.random.default_rng(seed).uniform((-3.0, -0.6, -2.1), (3.0, 1.2, -0.9), (count, 3))


def mass_matrix(q, body=BODY):
    d = dynamics(tuple(q), (0.0, 0.0, 0.0), body)
    return np.array([[d.m_11, 0.0, 0.0], [0.0, d.m_22, d.m_23], [0.0, d.m_23, d.m_33]])


def gravity(q, body=BODY):
    return np.array(dynamics(tuple(q), (0.0, 0.0, 0.0), body).bias)


def potential(q, body):
    """Return the potential energy [J] of the three centres of mass on a platform tilted about its x axis."""
    b, (q1, q2, q3) = body, q
    stick_angle = q2 + q3
    boom = (
        b.base_offset + b.boom_x * np.cos(q2) - b.boom_y * np.sin(q2),
        b.boom_x * np.sin(q2) + b.boom_y * np.cos(q2),
    )
    stick = (
        b.base_offset
        + b.boom_length * np.cos(q2)
        + b.stick_x * np.cos(stick_angle)
        - b.stick_y * np.sin(stick_angle),
        b.boom_length * np.sin(q2) + b.stick_x * np.sin(stick_angle) + b.stick_y * np.cos(stick_angle),
    )
    across = (b.boom_mass * boom[0] + b.stick_mass * stick[0] + b.base_moment) * np.sin(q1)
    up = b.boom_mass * boom[1] + b.stick_mass * stick[1]
    return b.gravity_across * across + b.gravity_down * up


def test_mass_matrix_is_positive_definite_everywhere():
    assert min(np.linalg.eigvalsh(mass_matrix(q)).min() for q in poses(200, 1)) > 0.0


@pytest.mark.parametrize("body", [BODY, TILTED], ids=["level", "tilted"])
def test_gravity_is_the_gradient_of_the_potential(body):
    for q in poses(50, 2):
        gradient = [(potential(q + H * e, body) - potential(q - H * e, body)) / (2 * H) for e in np.eye(3)]
        np.testing.assert_allclose(gravity(q, body), gradient, rtol=1e-6, atol=0.05)


def test_coriolis_terms_follow_from_the_mass_matrix():
    """V = M' q' - 1/2 d(q'M q')/dq: then M' - 2C is skew and V does no work of its own."""
    rng = np.random.default_rng(3)
    for q in poses(50, 3):
        u = rng.normal(0.0, 1.0, 3)
        dm = np.array([(mass_matrix(q + H * e) - mass_matrix(q - H * e)) / (2 * H) for e in np.eye(3)])
        expected = np.einsum("kij,k,j->i", dm, u, u) - 0.5 * np.einsum("ijk,j,k->i", dm, u, u)
        v = np.array(dynamics(tuple(q), tuple(u), BODY).bias) - gravity(q)
        np.testing.assert_allclose(v, expected, rtol=1e-5, atol=0.5)


def test_folding_the_head_keeps_mass_and_centre_of_mass():
    m = MANIPULATOR
    assert m.stick_mass + m.head_mass == BODY.stick_mass
    moment = m.stick_mass * m.stick_x + m.head_mass * m.stick_length
    assert BODY.stick_mass * BODY.stick_x == pytest.approx(moment)
    about_pivot = BODY.stick_zz + BODY.stick_mass * (BODY.stick_x**2 + BODY.stick_y**2)
    apart = m.stick_zz + m.stick_mass * (m.stick_x**2 + m.stick_y**2) + m.head_mass * m.stick_length**2
    assert about_pivot == pytest.approx(apart)
