"""Claims about the hanging head: energy, rest, small swings, limits and structure of its equations."""

import dataclasses
import math

import numpy as np
import pytest
from energies import kinetic_energy, pendulum_kinetic_energy, pendulum_potential_energy, potential_energy
from scipy.integrate import solve_ivp

from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, Pendulum
from forest_sim.mechanics import pendulum
from forest_sim.mechanics.manipulator import dynamics, fold_head
from forest_sim.mechanics.pendulum import (
    HangingHead,
    hanging_angles,
    hanging_head,
    pendulum_damping,
    pendulum_dynamics,
)

C180 = load_machine("c180_hoses").manipulator
HANGING = dataclasses.replace(
    C180,
    platform_tilt=0.15,
    pendulum=Pendulum(length=0.9, inertia=60.0, damping=250.0),
    log=Log(mass=500.0, x=1.4, y=0.0, length=4.0),
)
BODY, HEAD = fold_head(HANGING), hanging_head(HANGING)
G = 9.81


def states(count, seed):
    """Return rows of five angles and five rates over more than the crane's range."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform((-3.0, -0.6, -2.1, -1.5, -1.2), (3.0, 1.2, -0.9, 1.5, 1.2), (count, 5))
    return np.hstack([angles, rng.normal(0.0, 0.8, (count, 5))])


def split(x):
    """Return q, rates, angles, angle rates of a row of ten."""
    x = [float(value) for value in x]
    return tuple(x[0:3]), tuple(x[5:8]), tuple(x[3:5]), tuple(x[8:10])


def assembled(x, head=HEAD, body=BODY):
    """Return the 5x5 mass matrix and the bias of crane and head together."""
    q, rates, angles, angle_rates = split(x)
    d = dynamics(q, rates, body)
    p = pendulum_dynamics(q, rates, angles, angle_rates, head, body)
    crane = [
        [d.m_11 + p.m_11, p.m_12, p.m_13],
        [p.m_12, d.m_22 + p.m_22, d.m_23 + p.m_23],
        [p.m_13, d.m_23 + p.m_23, d.m_33 + p.m_33],
    ]
    coupling = np.array(p.coupling)
    mass = np.block([[np.array(crane), coupling], [coupling.T, np.diag([p.m_alpha, p.m_beta])]])
    return mass, np.array([*np.add(d.bias, p.crane_bias), *p.head_bias])


def energy(x, head=HEAD, body=BODY):
    q, rates, angles, angle_rates = split(x)
    moving = kinetic_energy(q, rates, body)
    moving += pendulum_kinetic_energy(q, rates, angles, angle_rates, head, body)
    return moving + potential_energy(q, body) + pendulum_potential_energy(q, angles, head, body)


def derivative(x, damped=False):
    mass, bias = assembled(x)
    _, rates, _, angle_rates = split(x)
    damping = pendulum_damping(rates, angle_rates, HEAD)
    torques = np.array([*damping.crane, *damping.head]) if damped else np.zeros(5)
    return np.concatenate([x[5:], np.linalg.solve(mass, torques - bias)])


def test_energy_is_conserved_without_damping_while_all_five_joints_move():
    start = np.array([0.4, 0.7, -1.6, 0.5, -0.4, 0.3, 0.1, -0.2, -0.5, 0.6])
    run = solve_ivp(lambda _, x: derivative(x), (0.0, 1.0), start, "RK45", rtol=1e-11, atol=1e-11)
    energies = [energy(x) for x in run.y.T]
    scale = kinetic_energy(*split(run.y[:, -1])[:2], BODY)  # what potential energy has become by then
    assert scale > 1e4
    assert max(abs(np.subtract(energies, energies[0]))) < 1e-9 * scale


def test_damping_takes_energy_out_at_the_rate_of_the_relative_motion():
    for x in states(20, 1):
        _, rates, _, angle_rates = split(x)
        torques = pendulum_damping(rates, angle_rates, HEAD)
        power = np.dot([*torques.crane, *torques.head], x[5:])
        relative = angle_rates[0] - rates[1] - rates[2]
        assert power == pytest.approx(-HEAD.damping * (relative**2 + angle_rates[1] ** 2), rel=1e-12)


def test_derivative_of_the_damping_is_the_one_told():
    n, e = np.array([0.0, -1.0, -1.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 1.0])
    for x in states(5, 2):
        _, rates, _, angle_rates = split(x)
        torques = pendulum_damping(rates, angle_rates, HEAD)
        expected = -HEAD.damping * (np.outer(n, n) + np.outer(e, e)) @ x[5:]
        np.testing.assert_allclose([*torques.crane, *torques.head], expected, rtol=1e-12, atol=1e-9)


def test_potential_energy_has_the_bias_at_rest_as_its_gradient():
    h = 1e-6
    for x in states(30, 3):
        x[5:] = 0.0
        steps = h * np.eye(10)[:5]
        gradient = [(energy(x + step) - energy(x - step)) / (2 * h) for step in steps]
        np.testing.assert_allclose(assembled(x)[1], gradient, rtol=1e-6, atol=0.05)


def test_kinetic_energy_is_half_the_rates_through_the_mass_matrix():
    for x in states(30, 4):
        q, rates, angles, angle_rates = split(x)
        both = kinetic_energy(q, rates, BODY)
        both += pendulum_kinetic_energy(q, rates, angles, angle_rates, HEAD, BODY)
        assert both == pytest.approx(0.5 * x[5:] @ assembled(x)[0] @ x[5:], rel=1e-12)


def test_coriolis_terms_follow_from_the_mass_matrix():
    """V = M' q' - 1/2 d(q'M q')/dq: then M' - 2C is skew for crane and head together."""
    h = 1e-6
    for x in states(30, 5):
        u, still = x[5:], np.concatenate([x[:5], np.zeros(5)])
        dm = [(assembled(still + h * e)[0] - assembled(still - h * e)[0]) / (2 * h) for e in np.eye(10)[:5]]
        expected = np.einsum("kij,k,j->i", dm, u, u) - 0.5 * np.einsum("ijk,j,k->i", dm, u, u)
        np.testing.assert_allclose(assembled(x)[1] - assembled(still)[1], expected, rtol=1e-5, atol=0.5)


def test_mass_matrix_is_symmetric_and_positive_definite():
    for x in states(200, 6):
        mass = assembled(x)[0]
        np.testing.assert_array_equal(mass, mass.T)
        assert np.linalg.eigvalsh(mass).min() > 0.0


@pytest.mark.parametrize("tilt", [0.0, 0.15, -0.3])
@pytest.mark.parametrize("swing", [-2.0, 0.0, 0.5, math.pi / 2])
def test_hangs_still_at_rest_along_gravity(tilt, swing):
    body = fold_head(dataclasses.replace(HANGING, platform_tilt=tilt))
    angles = hanging_angles(swing, body)
    at_rest = pendulum_dynamics((swing, 0.4, -1.2), (0.0, 0.0, 0.0), angles, (0.0, 0.0), HEAD, body)
    np.testing.assert_allclose(at_rest.head_bias, 0.0, atol=1e-9)
    alpha, beta = angles
    d = (math.sin(alpha) * math.cos(beta), math.sin(beta), -math.cos(alpha) * math.cos(beta))
    left = math.sin(swing) * d[0] + math.cos(swing) * d[1]  # along the platform's y
    assert (left, d[2]) == pytest.approx((-math.sin(tilt), -math.cos(tilt)))


@pytest.mark.parametrize("axis", [0, 1])
def test_small_swings_have_the_frequency_of_a_compound_pendulum(axis):
    """sqrt(m g L / I), I about the joint; a log of 4 m turns in the crane's plane and rolls out of it."""
    h = 1e-5
    body = fold_head(dataclasses.replace(HANGING, platform_tilt=0.0))

    def at(angle):
        angles = (angle, 0.0) if axis == 0 else (0.0, angle)
        return pendulum_dynamics((0.3, 0.4, -1.2), (0.0, 0.0, 0.0), angles, (0.0, 0.0), HEAD, body)

    stiffness = (at(h).head_bias[axis] - at(-h).head_bias[axis]) / (2 * h)
    inertia = (at(0.0).m_alpha, at(0.0).m_beta)[axis]
    moment = 700.0 * 0.9 + 500.0 * 1.4
    about_joint = 60.0 + 700.0 * 0.9**2 + 500.0 * 1.4**2 + (500.0 * 4.0**2 / 12.0 if axis == 0 else 0.0)
    expected = math.sqrt(G * moment / about_joint)
    assert math.sqrt(stiffness / inertia) == pytest.approx(expected, rel=1e-8)


def test_head_without_length_or_inertia_is_the_point_mass_folded_into_the_stick():
    point = HangingHead(HANGING.head_mass, 1e-9, 0.0, 0.0, 0.0)
    folded = fold_head(dataclasses.replace(HANGING, pendulum=None, log=None))
    assert C180.head_folding == "full"
    for x in states(50, 7):
        q, rates, angles, angle_rates = split(x)
        bare, whole = dynamics(q, rates, BODY), dynamics(q, rates, folded)
        p = pendulum_dynamics(q, rates, angles, angle_rates, point, BODY)
        ours = (bare.m_11 + p.m_11, bare.m_22 + p.m_22, bare.m_23 + p.m_23, bare.m_33 + p.m_33)
        assert ours == pytest.approx(whole[:4], rel=1e-8)
        assert (p.m_12, p.m_13) == pytest.approx((0.0, 0.0), abs=1e-5)
        np.testing.assert_allclose(np.add(bare.bias, p.crane_bias), whole.bias, rtol=1e-8, atol=1e-4)


def test_head_does_not_weigh_twice():
    assert BODY.stick_mass == HANGING.stick_mass
    assert HEAD.mass == HANGING.head_mass + 500.0
    assert hanging_head(C180).mass == 0.0
    assert fold_head(C180).stick_mass == C180.stick_mass + C180.head_mass


def test_laws_compile_and_agree_with_themselves_in_python():
    numba = pytest.importorskip("numba")
    helpers = {name: numba.njit(getattr(pendulum, name)) for name in ("_dot", "_sum")}
    for name in ("_tip", "_accelerations", "pendulum_dynamics", "pendulum_damping", "hanging_angles"):
        function = getattr(pendulum, name)
        scope = {**function.__globals__, **helpers}
        helpers[name] = numba.njit(type(function)(function.__code__, scope, name))
    q, rates, angles, angle_rates = split(states(1, 8)[0])
    for name, arguments in (
        ("pendulum_dynamics", (q, rates, angles, angle_rates, HEAD, BODY)),
        ("pendulum_damping", (rates, angle_rates, HEAD)),
        ("hanging_angles", (0.3, BODY)),
    ):
        ours, theirs = getattr(pendulum, name)(*arguments), helpers[name](*arguments)
        for one, other in zip(ours, theirs, strict=True):
            np.testing.assert_allclose(other, one, rtol=1e-12)
