"""Kinetic and potential energy of crane and hanging head: oracles for their equations of motion."""

import math

from forest_description.types import Vec3
from forest_sim.mechanics.manipulator import Body, Pair, dynamics
from forest_sim.mechanics.pendulum import HangingHead, _dot, _sum, _tip


def kinetic_energy(q: Vec3, rates: Vec3, body: Body) -> float:
    """Return T = 1/2 q'^T M(q) q' [J]; q [rad], rates [rad/s]."""
    d = dynamics(q, (0.0, 0.0, 0.0), body)
    u_1, u_2, u_3 = rates
    return 0.5 * (d.m_11 * u_1**2 + d.m_22 * u_2**2 + d.m_33 * u_3**2) + d.m_23 * u_2 * u_3


def potential_energy(q: Vec3, body: Body) -> float:
    """Return U(q) [J], of which G is the gradient; zero is a mass at the boom's pivot. q [rad]."""
    b = body
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    r_b = b.base_offset + b.boom_x * c_2 - b.boom_y * s_2
    r_s = b.base_offset + b.boom_length * c_2 + b.stick_x * c_23 - b.stick_y * s_23
    h_b = b.boom_x * s_2 + b.boom_y * c_2
    h_s = b.boom_length * s_2 + b.stick_x * s_23 + b.stick_y * c_23
    left = (b.stick_mass * r_s + b.boom_mass * r_b + b.base_moment) * math.sin(q[0])
    return b.gravity_across * left + b.gravity_down * (b.stick_mass * h_s + b.boom_mass * h_b)


def pendulum_kinetic_energy(
    q: Vec3, rates: Vec3, angles: Pair, angle_rates: Pair, head: HangingHead, body: Body
) -> float:
    """Return the head's T = 1/2 m |p'|^2 + 1/2 I_t |d'|^2 [J]; arguments as `pendulum_dynamics`."""
    radius, (x_2, z_2), (x_3, z_3) = _tip(q, body)
    u_1, u_2, u_3 = rates
    s_a, c_a = math.sin(angles[0]), math.cos(angles[0])
    s_b, c_b = math.sin(angles[1]), math.cos(angles[1])
    turning = (
        c_a * c_b * angle_rates[0] - s_a * s_b * angle_rates[1] - u_1 * s_b,
        c_b * angle_rates[1] + u_1 * s_a * c_b,
        s_a * c_b * angle_rates[0] + c_a * s_b * angle_rates[1],
    )
    tip = (-z_2 * u_2 - z_3 * u_3, radius * u_1, x_2 * u_2 + x_3 * u_3)
    centre = _sum(1.0, tip, head.length, turning)
    return 0.5 * head.mass * _dot(centre, centre) + 0.5 * head.inertia * _dot(turning, turning)


def pendulum_potential_energy(q: Vec3, angles: Pair, head: HangingHead, body: Body) -> float:
    """Return the head's U [J]; zero is a mass at the boom's pivot. Arguments as `pendulum_dynamics`."""
    radius, (_, z_2), _ = _tip(q, body)
    out = radius + head.length * math.sin(angles[0]) * math.cos(angles[1])
    left = head.length * math.sin(angles[1])
    up = z_2 - head.length * math.cos(angles[0]) * math.cos(angles[1])
    across = math.sin(q[0]) * out + math.cos(q[0]) * left
    return head.mass * (body.gravity_across * across + body.gravity_down * up)
