"""Rigid-body dynamics: structure that M, V and G must have whatever the numbers."""

import dataclasses
import math

import numpy as np
import pytest
from energies import kinetic_energy, potential_energy

from forest_description.config.parameter import replace_unchecked
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.mechanics.load import Log
from forest_sim.mechanics.manipulator import dynamics, fold_head, tip_load_torques

MANIPULATOR, THESIS = load_machine("c180_hoses").manipulator, load_machine("c180_thesis").manipulator
BODY = fold_head(MANIPULATOR)
GENERAL = fold_head(
    dataclasses.replace(
        MANIPULATOR, platform_tilt=0.2, boom_xy=-90.0, stick_xy=140.0, log=Log(mass=900.0, x=0.4, y=-0.3)
    )
)
BODIES = pytest.mark.parametrize(
    "body", [BODY, fold_head(THESIS), GENERAL], ids=["c180_hoses", "thesis", "tilted, log, products"]
)
H = 1e-6


def poses(count, seed):
    return np.random.default_rng(seed).uniform((-3.0, -0.6, -2.1), (3.0, 1.2, -0.9), (count, 3))


def mass_matrix(q, body=BODY):
    d = dynamics(tuple(q), (0.0, 0.0, 0.0), body)
    return np.array([[d.m_11, 0.0, 0.0], [0.0, d.m_22, d.m_23], [0.0, d.m_23, d.m_33]])


def gravity(q, body=BODY):
    return np.array(dynamics(tuple(q), (0.0, 0.0, 0.0), body).bias)


def test_mass_matrix_is_positive_definite_everywhere():
    assert min(np.linalg.eigvalsh(mass_matrix(q)).min() for q in poses(200, 1)) > 0.0


def coriolis_matrix(q, u, body):
    """Return C(q, q') from the Christoffel symbols of M, and M' along q'."""
    dm = [(mass_matrix(q + H * e, body) - mass_matrix(q - H * e, body)) / (2 * H) for e in np.eye(3)]
    by = np.moveaxis(np.array(dm), 0, 2)  # [i, j, k]: dM_ij/dq_k
    symbols = 0.5 * (by + np.swapaxes(by, 1, 2) - np.moveaxis(by, 2, 0))
    return symbols @ u, by @ u


@BODIES
def test_gravity_is_the_gradient_of_the_potential(body):
    for q in poses(50, 2):
        ends = [(potential_energy(q + H * e, body), potential_energy(q - H * e, body)) for e in np.eye(3)]
        gradient = [(ahead - behind) / (2 * H) for ahead, behind in ends]
        np.testing.assert_allclose(gravity(q, body), gradient, rtol=1e-6, atol=0.05)


@BODIES
def test_m_dot_less_twice_c_is_skew_and_c_gives_the_coriolis_terms(body):
    rng = np.random.default_rng(3)
    for q in poses(50, 3):
        u, any_vector = rng.normal(0.0, 1.0, 3), rng.normal(0.0, 1.0, 3)
        c, m_dot = coriolis_matrix(q, u, body)
        scale = np.linalg.norm(m_dot)
        skew = m_dot - 2.0 * c
        np.testing.assert_allclose(skew, -skew.T, atol=1e-9 * scale)
        assert abs(any_vector @ skew @ any_vector) < 1e-8 * scale
        v = np.array(dynamics(tuple(q), tuple(u), body).bias) - gravity(q, body)
        np.testing.assert_allclose(v, c @ u, rtol=1e-5, atol=0.5)


@BODIES
def test_coriolis_terms_do_the_work_that_m_dot_tells(body):
    """q'V = 1/2 q'M'q', so that kinetic energy changes by the torques' work alone."""
    rng = np.random.default_rng(4)
    for q in poses(50, 4):
        u = rng.normal(0.0, 1.0, 3)
        v = np.array(dynamics(tuple(q), tuple(u), body).bias) - gravity(q, body)
        ahead, behind = mass_matrix(q + H * u, body), mass_matrix(q - H * u, body)
        half_m_dot = 0.5 * u @ ((ahead - behind) / (2 * H)) @ u
        assert u @ v == pytest.approx(half_m_dot, rel=1e-6, abs=0.5)


@BODIES
def test_left_and_right_are_alike(body):
    """Swing and its rate mirrored, with the tilt mirrored too: boom and stick feel no difference."""
    mirrored_body = body._replace(gravity_across=-body.gravity_across)
    rng = np.random.default_rng(5)
    for q in poses(20, 5).tolist():
        u = rng.normal(0.0, 1.0, 3).tolist()
        left = dynamics(tuple(q), tuple(u), body)
        right = dynamics((-q[0], q[1], q[2]), (-u[0], u[1], u[2]), mirrored_body)
        assert right[:4] == left[:4]
        assert right.bias == (-left.bias[0], *left.bias[1:])


def test_on_a_level_platform_the_swing_angle_does_not_matter():
    for q in poses(20, 6).tolist():
        u = (0.3, -0.5, 0.4)
        assert dynamics(tuple(q), u, BODY) == dynamics((0.0, q[1], q[2]), u, BODY)


def point_energies(q, u, m):
    """Return T and U [J] summed over bodies as moving points with extent, not from M, V, G."""
    log = m.log or Log(0.0, 0.0, 0.0)
    base = m.base_zz + m.base_mass * m.base_x**2
    bodies = (
        (m.boom_mass, m.boom_x, m.boom_y, m.boom_xx, m.boom_yy, m.boom_zz, m.boom_xy, 0.0, 1),
        (m.stick_mass, m.stick_x, m.stick_y, m.stick_xx, m.stick_yy, m.stick_zz, m.stick_xy, 1.0, 2),
        (m.head_mass, m.stick_length, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2),
        (log.mass, m.stick_length + log.x, log.y, 0.0, 0.0, 0.0, 0.0, 1.0, 2),
    )
    moving = 0.5 * base * u[0] ** 2
    standing = m.gravity * math.sin(m.platform_tilt) * m.base_mass * m.base_x * math.sin(q[0])
    for mass, x, y, xx, yy, zz, xy, carried, joints in bodies:
        angle, turn = sum(q[1 : 1 + joints]), sum(u[1 : 1 + joints])
        s, c, length = math.sin(angle), math.cos(angle), carried * m.boom_length
        r = m.base_offset + length * math.cos(q[1]) + x * c - y * s
        h = length * math.sin(q[1]) + x * s + y * c
        v_r = -length * math.sin(q[1]) * u[1] - (x * s + y * c) * turn
        v_h = length * math.cos(q[1]) * u[1] + (x * c - y * s) * turn
        spin = np.array([s * u[0], c * u[0], turn])  # in the body's frame: the vertical is (s, c, 0) there
        inertia = np.array([[xx, -xy, 0.0], [-xy, yy, 0.0], [0.0, 0.0, zz]])
        moving += 0.5 * mass * (v_r**2 + v_h**2 + (r * u[0]) ** 2) + 0.5 * spin @ inertia @ spin
        across = math.sin(m.platform_tilt) * r * math.sin(q[0])
        standing += mass * m.gravity * (across + math.cos(m.platform_tilt) * h)
    return moving, standing


@pytest.mark.parametrize("log", [None, Log(mass=900.0, x=0.4, y=-0.3)], ids=["empty", "log"])
def test_energies_are_those_of_the_single_bodies(log):
    m = dataclasses.replace(MANIPULATOR, log=log, platform_tilt=0.2, boom_xy=-90.0, stick_xy=140.0)
    assert m.head_folding == "full"
    body, rng = fold_head(m), np.random.default_rng(7)
    for q in poses(50, 7).tolist():
        u = rng.normal(0.0, 1.0, 3).tolist()
        ours = (kinetic_energy(tuple(q), tuple(u), body), potential_energy(tuple(q), body))
        assert ours == pytest.approx(point_energies(q, u, m), rel=1e-12)


def test_folding_the_head_keeps_mass_and_centre_of_mass():
    m = MANIPULATOR
    assert m.stick_mass + m.head_mass == BODY.stick_mass
    moment = m.stick_mass * m.stick_x + m.head_mass * m.stick_length
    assert BODY.stick_mass * BODY.stick_x == pytest.approx(moment)
    about_pivot = BODY.stick_zz + BODY.stick_mass * (BODY.stick_x**2 + BODY.stick_y**2)
    apart = m.stick_zz + m.stick_mass * (m.stick_x**2 + m.stick_y**2) + m.head_mass * m.stick_length**2
    assert about_pivot == pytest.approx(apart)


def test_thesis_folding_takes_up_to_three_per_cent_off_the_swings_inertia():
    full, thesis = (fold_head(replace_unchecked(THESIS, head_folding=how)) for how in ("full", "thesis"))

    def share(q):
        both = [dynamics(q, (0.0, 0.0, 0.0), body).m_11 for body in (full, thesis)]
        return both[0] / both[1] - 1.0

    assert abs(share((0.0, 0.0, -0.9))) < 0.004
    assert share((0.0, -0.64, -1.8)) == pytest.approx(0.028, abs=0.001)


def test_a_log_at_the_tip_weighs_as_a_heavier_head():
    log = dataclasses.replace(MANIPULATOR, log=Log(mass=400.0, x=0.0, y=0.0))
    heavier = dataclasses.replace(MANIPULATOR, head_mass=MANIPULATOR.head_mass + 400.0)
    assert fold_head(log) == pytest.approx(fold_head(heavier), rel=1e-12)


def test_tip_load_does_the_work_of_its_force_along_the_tips_path():
    """J^T F, with J from finite differences of the tip's position."""
    rng, links = np.random.default_rng(8), MANIPULATOR.links
    for q in poses(50, 8):
        force = rng.normal(0.0, 1e4, 3)
        tips = [
            (tip_position(tuple(q + H * e), links), tip_position(tuple(q - H * e), links)) for e in np.eye(3)
        ]
        j_transposed = np.array([np.subtract(ahead, behind) / (2 * H) for ahead, behind in tips])
        torques = tip_load_torques(tuple(q), tuple(force), BODY)
        np.testing.assert_allclose(torques, j_transposed @ force, rtol=1e-6, atol=1e-3)


def test_weight_at_the_tip_is_what_a_log_there_adds_to_gravity():
    body = fold_head(dataclasses.replace(MANIPULATOR, log=Log(mass=400.0, x=0.0, y=0.0)))
    for q in poses(20, 9):
        hung = tip_load_torques(tuple(q), (0.0, 0.0, -400.0 * MANIPULATOR.gravity), BODY)
        np.testing.assert_allclose(gravity(q, body) - gravity(q), np.negative(hung), rtol=1e-9, atol=1e-6)


def test_laws_compile_and_agree_with_themselves_in_python():
    numba = pytest.importorskip("numba")
    q, u = (0.3, 0.5, -1.4), (0.2, -0.3, 0.4)
    force = (1e3, -2e3, 3e3)
    compiled = numba.njit(dynamics)(q, u, GENERAL)
    np.testing.assert_allclose(compiled[:4], dynamics(q, u, GENERAL)[:4], rtol=1e-14)
    np.testing.assert_allclose(compiled.bias, dynamics(q, u, GENERAL).bias, rtol=1e-12)
    for function, arguments in ((tip_load_torques, (q, force, GENERAL)), (potential_energy, (q, GENERAL))):
        np.testing.assert_allclose(numba.njit(function)(*arguments), function(*arguments), rtol=1e-12)
