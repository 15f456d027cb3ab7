"""Potential energy U of crane and hanging head; the bias at rest is its gradient."""

import math

from forest_description.types import Vec3
from forest_sim.mechanics.manipulator import Body, Pair
from forest_sim.mechanics.pendulum import HangingHead


def potential_energy(q: Vec3, body: Body) -> float:
    """Return the crane's U(q) [J]; zero is a mass at the boom's pivot. q [rad]."""
    b = body
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    r_b = b.base_offset + b.boom_x * c_2 - b.boom_y * s_2
    r_s = b.base_offset + b.boom_length * c_2 + b.stick_x * c_23 - b.stick_y * s_23
    h_b = b.boom_x * s_2 + b.boom_y * c_2
    h_s = b.boom_length * s_2 + b.stick_x * s_23 + b.stick_y * c_23
    left = (b.stick_mass * r_s + b.boom_mass * r_b + b.base_moment) * math.sin(q[0])
    return b.gravity_across * left + b.gravity_down * (b.stick_mass * h_s + b.boom_mass * h_b)


def pendulum_potential_energy(q: Vec3, angles: Pair, head: HangingHead, body: Body) -> float:
    """Return the head's U [J]; zero is a mass at the boom's pivot. Arguments as `pendulum_dynamics`."""
    b = body
    radius = b.base_offset + b.boom_length * math.cos(q[1]) + b.stick_length * math.cos(q[1] + q[2])
    height = b.boom_length * math.sin(q[1]) + b.stick_length * math.sin(q[1] + q[2])
    out = radius + head.length * math.sin(angles[0]) * math.cos(angles[1])
    left = head.length * math.sin(angles[1])
    up = height - head.length * math.cos(angles[0]) * math.cos(angles[1])
    across = math.sin(q[0]) * out + math.cos(q[0]) * left
    return head.mass * (b.gravity_across * across + b.gravity_down * up)
