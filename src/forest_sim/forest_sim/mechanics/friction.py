"""Dry friction of a cylinder's seals, with the Stribeck effect, made smooth through standstill.

| symbol | name | unit |
|---|---|---|
| u | piston speed | m/s |
| F_c, F_s | friction at speed, at breakaway | N |
| u_s, u_0 | Stribeck speed; speed under which the sign is smoothed | m/s |
| P_1, P_2 | pressures in the chambers, zero in the tank | Pa |
| k | coulomb friction per pressure | N/Pa |

    F = (F_c + (F_s - F_c) exp(-(u/u_s)^2)) u/sqrt(u^2 + u_0^2)

Pressure presses lips against rod and bore: F_c grows by k (P_1 + P_2), F_s in proportion. That is
the friction of Simscape's cylinders (Cylinder Friction (IL)), whose ratio F_s/F_c is constant, too.
Under tank pressure a lip keeps its preload.

The thesis takes viscous friction alone (section 3.2.4). Smoothing keeps the law a function: at rest
under a load the piston creeps at a small share of u_0 instead of sticking.
"""

import math
from typing import NamedTuple

from forest_description.mechanics import drives


class Friction(NamedTuple):
    """Constants of the law; `coulomb` and `breakaway` of 0 leave it out."""

    coulomb: float  # F_c [N]
    breakaway: float  # F_s [N]
    stribeck_speed: float  # u_s [m/s]
    smoothing_speed: float  # u_0 [m/s]
    pressure_share: float = 0.0  # k/F_c [1/Pa]


FRICTIONLESS = Friction(0.0, 0.0, 1.0, 1.0)


def friction(given: drives.Friction | None) -> Friction:
    """Return the kernel's constants of a cylinder's friction."""
    if given is None:
        return FRICTIONLESS
    share = 0.0 if given.pressure_coefficient is None else given.pressure_coefficient / given.coulomb_force
    return Friction(
        given.coulomb_force, given.breakaway_force, given.stribeck_speed, given.smoothing_speed, share
    )


def pressed(f: Friction, pressure_1: float, pressure_2: float) -> Friction:
    """Return the friction of seals under the chambers' pressures [Pa], which these add nothing to."""
    if f.pressure_share == 0.0:
        return f
    grown = 1.0 + f.pressure_share * (max(0.0, pressure_1) + max(0.0, pressure_2))
    return Friction(grown * f.coulomb, grown * f.breakaway, f.stribeck_speed, f.smoothing_speed)


class Rubbing(NamedTuple):
    """What friction does at a speed."""

    force: float  # F [N], with the speed's sign: it opposes the motion
    slope: float  # dF/du [N s/m]; negative where the Stribeck effect falls faster than the sign rises


def rubbing(speed: float, f: Friction, pressure_1: float = 0.0, pressure_2: float = 0.0) -> Rubbing:
    """Return the friction at a speed, and its slope.

    Args:
        speed: u [m/s].
        f: its constants.
        pressure_1: in the chamber of port 1 [Pa].
        pressure_2: of port 2 [Pa].
    """
    if f.breakaway == 0.0:
        return Rubbing(0.0, 0.0)
    f = pressed(f, pressure_1, pressure_2)
    root = math.sqrt(speed * speed + f.smoothing_speed * f.smoothing_speed)
    ratio = speed / f.stribeck_speed
    over = (f.breakaway - f.coulomb) * math.exp(-ratio * ratio)
    magnitude, falling = f.coulomb + over, over * 2.0 * ratio / f.stribeck_speed
    sign_slope = f.smoothing_speed * f.smoothing_speed / (root * root * root)
    return Rubbing(magnitude * speed / root, magnitude * sign_slope - falling * speed / root)


def friction_force(speed: float, f: Friction, pressure_1: float = 0.0, pressure_2: float = 0.0) -> float:
    """Return the friction [N] alone; arguments as `rubbing`."""
    return rubbing(speed, f, pressure_1, pressure_2).force
