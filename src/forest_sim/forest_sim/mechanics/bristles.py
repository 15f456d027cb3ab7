"""Dry friction that sticks: bristles that bend, and yield before they slide (elasto-plastic LuGre).

| symbol | name | unit |
|---|---|---|
| u, z | speed; deflection of the bristles | rad/s, rad |
| F_c, F_s, u_s | friction at speed, at breakaway; Stribeck speed | N m, rad/s |
| k, c | stiffness and damping of the bristles | N m/rad, N m s/rad |
| z_e | deflection up to which they only bend, a share of F_c/k | rad |
| z_s | deflection at which they slide, (F_c + (F_s - F_c)/(1 + (u/u_s)^2))/k | rad |

    dz/dt = u (1 - s),   s = max(0, (abs(z) - z_e)/(z_s - z_e)) where u bends them further, else 0
    F = k z + c dz/dt/(1 + (c u/F_c)^2)

Dupont, Hayward, Armstrong and Altpeter, Single state elastoplastic friction models, IEEE Trans.
Automatic Control 47, 2002. LuGre's s is abs(z)/z_s: a load that trembles far below breakaway drifts
away under it. Here s is zero up to z_e, and nothing drifts that only bends. s is straight in
between, and an implicit step has a closed form. The damping falls with the speed, so that its force
is at most F_c/2 where bristles slip back: friction gives energy at no state.

Stribeck's curve is that of Hess and Soom, Friction at a lubricated line contact operating at
oscillating sliding velocities, J. Tribology 112, 1990.

A cylinder needs none of this: its oil holds it (`friction`). A swing's motor leaks, and only its
bearing holds a crane on a slope.
"""

from typing import NamedTuple

from forest_description.mechanics import drives


class Bristles(NamedTuple):
    """Constants of the law; a `stiffness` of 0 leaves it out."""

    coulomb: float  # F_c [N m]
    breakaway: float  # F_s [N m]
    stribeck_speed: float  # u_s [rad/s]
    stiffness: float  # k [N m/rad]
    damping: float  # c [N m s/rad]
    elastic: float  # z_e [rad]


NO_BRISTLES = Bristles(0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


class Rubbing(NamedTuple):
    """What bristles do at a state."""

    force: float  # F, opposes the motion [N m]
    rate: float  # dz/dt [rad/s]


class Stuck(NamedTuple):
    """What bristles do at the end of an implicit step."""

    deflection: float  # z [rad]
    force: float  # F [N m]
    resistance: float  # dF/du [N m s/rad]


def bristles(given: drives.BearingFriction | None) -> Bristles:
    """Return the kernel's constants of a bearing's friction."""
    if given is None:
        return NO_BRISTLES
    return Bristles(
        given.coulomb_torque,
        given.breakaway_torque,
        given.stribeck_speed,
        given.stiffness,
        given.damping,
        given.elastic_share * given.coulomb_torque / given.stiffness,
    )


def sliding_friction(speed: float, b: Bristles) -> float:
    """Return k z_s [N m], the size of the friction in steady sliding at a speed [rad/s]."""
    ratio = speed / b.stribeck_speed
    return b.coulomb + (b.breakaway - b.coulomb) / (1.0 + ratio * ratio)


def rubbing(deflection: float, speed: float, b: Bristles) -> Rubbing:
    """Return force and rate of the bristles at a deflection [rad] and a speed [rad/s]."""
    if b.stiffness == 0.0:
        return Rubbing(0.0, 0.0)
    rate = speed
    if deflection * speed > 0.0 and abs(deflection) > b.elastic:
        yielding = sliding_friction(speed, b) / b.stiffness - b.elastic
        rate = speed * (1.0 - (abs(deflection) - b.elastic) / yielding)
    return Rubbing(b.stiffness * deflection + _damping(speed, b) * rate, rate)


def stuck_after(deflection: float, speed: float, step: float, b: Bristles) -> Stuck:
    """Return z = deflection + step dz/dt(z, u), its force and that force's slope by the speed.

    Args:
        deflection: the step's known part [rad].
        speed: u at its end [rad/s].
        step: [s].
        b: the bristles.
    """
    if b.stiffness == 0.0:
        return Stuck(0.0, 0.0, 0.0)
    bent = deflection + step * speed
    sign = 1.0 if speed > 0.0 else -1.0
    past, z, slope = sign * bent - b.elastic, bent, step
    if past > 0.0:
        ratio = speed / b.stribeck_speed
        fallen = 1.0 / (1.0 + ratio * ratio)
        falling = (b.breakaway - b.coulomb) * fallen / b.stiffness
        yielding = b.coulomb / b.stiffness + falling - b.elastic
        softening = 2.0 * ratio * sign * falling * fallen / b.stribeck_speed  # -d(yielding)/d(abs(u))
        way = step * abs(speed) / yielding
        kept = 1.0 / (1.0 + way)
        z = sign * (b.elastic + past * kept)
        slope = kept * (step - past * kept * (step + way * softening) / yielding)
    rate, damping = (z - deflection) / step, _damping(speed, b)
    fading = -2.0 * damping * damping * speed * (b.damping / (b.coulomb * b.coulomb))
    return Stuck(
        deflection=z,
        force=b.stiffness * z + damping * rate,
        resistance=(b.stiffness + damping / step) * slope + fading * rate,
    )


def _damping(speed: float, b: Bristles) -> float:
    ratio = b.damping * speed / b.coulomb
    return b.damping / (1.0 + ratio * ratio)
