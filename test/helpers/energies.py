"""Kinetic and potential energy of crane and hanging head: oracles for their equations of motion."""

import math

from forest_description.types import Vec3
from forest_sim.mechanics.manipulator import Body, Pair, dynamics
from forest_sim.mechanics.pendulum import HangingHead, _dot, _sum, _tip
from forest_sim.mechanics.potential_energy import pendulum_potential_energy, potential_energy

__all__ = ["kinetic_energy", "pendulum_kinetic_energy", "pendulum_potential_energy", "potential_energy"]


def kinetic_energy(q: Vec3, rates: Vec3, body: Body) -> float:
    """Return T = 1/2 q'^T M(q) q' [J]; q [rad], rates [rad/s]."""
    d = dynamics(q, (0.0, 0.0, 0.0), body)
    u_1, u_2, u_3 = rates
    return 0.5 * (d.m_11 * u_1**2 + d.m_22 * u_2**2 + d.m_33 * u_3**2) + d.m_23 * u_2 * u_3


def pendulum_kinetic_energy(
    q: Vec3, rates: Vec3, angles: Pair, angle_rates: Pair, head: HangingHead, body: Body
) -> float:
    """Return 1/2 (m |p'|^2 + I_t |d'|^2 + I_l |e'|^2) [J]; arguments as `pendulum_dynamics`."""
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
    log = (-s_a * angle_rates[0], u_1 * c_a, c_a * angle_rates[0])
    moving = head.mass * _dot(centre, centre) + head.inertia * _dot(turning, turning)
    return 0.5 * (moving + head.log_inertia * _dot(log, log))
