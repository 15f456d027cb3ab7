"""What links that give way do to an implicit stage.

The rate w of a link's root is one more unknown of Newton's, which its own equation eliminates, as
that of a motor behind its teeth (`drive_stage`). The spring is linear: nothing is left of it.

    J (w - base) + h (T - torque(w)) = 0,   D = J + h (R + K),   K = c + h k

A root is light: dry friction turns it round within a stage. That friction is therefore taken as it
is, and only the oil's part of the torque along its slope; the root of what is left, which has one
unknown, is found within a bracket.
"""

from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.elastic_links import NO_ROOT, ElasticLaws, Roots, RootState
from forest_sim.equations.plant import PlantState, at_joints
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.mechanics.elasticity import ElasticLink, elastic_torque
from forest_sim.mechanics.friction import FRICTIONLESS, Friction, rubbing
from forest_sim.mechanics.manipulator import Pair
from forest_sim.stage.drive_stage import DriveSolution
from forest_sim.stage.supply_stage import SupplyError


class ElasticSolution(NamedTuple):
    """The roots of a stage at guessed rates."""

    swing: DriveSolution
    boom: DriveSolution
    stick: DriveSolution
    gains: Vec3  # h d(an actuator's draw)/d(its root's rate) [m^3 s]


class Rub(NamedTuple):
    """Dry friction at a root."""

    friction: Friction  # under the chambers' pressures
    arm: float  # d(actuator position)/d(angle)
    torque: float  # that it takes at the root's guessed rate [N m]
    resistance: float  # d(torque)/d(rate) there [N m s]


SMOOTH = Rub(FRICTIONLESS, 1.0, 0.0, 0.0)
LEAST_GIVE = 0.1  # a root that the Stribeck effect lets go yields at most ten times as much
RUB_ITERATIONS, RUB_TOLERANCE = 40, 1e-9  # [rad/s]
STIFF = DriveSolution(torque=0.0, resistance=0.0, share=1.0, excess=0.0, give=0.0)
ALL_STIFF = ElasticSolution(STIFF, STIFF, STIFF, (0.0, 0.0, 0.0))


def first_root_rates(base: PlantState, rates: Vec3, p: PlantParameters) -> Vec3:
    """Return the roots' rates [rad/s] that follow those guessed of the links."""
    joints = at_joints(base, p)
    return (
        joints.swing.rate + (rates[0] - base.swing.rate),
        joints.boom.rate + (rates[1] - base.boom.rate),
        joints.stick.rate + (rates[2] - base.stick.rate),
    )


def root_angles(base: PlantState, root_rates: Vec3, h: float, p: PlantParameters) -> Vec3:
    """Return the roots' angles [rad] at a stage's end."""
    joints = at_joints(base, p)
    return (
        joints.swing.angle + h * root_rates[0],
        joints.boom.angle + h * root_rates[1],
        joints.stick.angle + h * root_rates[2],
    )


def solve_links(
    base: PlantState,
    rates: Vec3,
    root_rates: Vec3,
    torques: Vec3,
    resistances: Vec3,
    rubs: tuple[Rub, Rub],
    gains: Vec3,
    h: float,
    laws: ElasticLaws,
) -> ElasticSolution:
    """Return what elastic links make of their actuators' solutions.

    Args:
        base: the stage's known part.
        rates: of the links [rad/s].
        root_rates: of their roots [rad/s].
        torques: of the actuators at the roots' rates [N m].
        resistances: their -d(torque)/d(rate) [N m s].
        rubs: dry friction of boom and stick, which torques and resistances have in them.
        gains: h d(an actuator's draw)/d(its rate) [m^3 s].
        h: the stage's implicit step [s].
        laws: the constants.
    """
    roots, s, b, t = base.roots, base.swing, base.boom, base.stick
    bends = s.angle + h * rates[0], b.angle + h * rates[1], t.angle + h * rates[2]
    w, r = root_rates, resistances
    return ElasticSolution(
        _solve_link(roots.swing, bends[0], rates[0], w[0], torques[0], r[0], SMOOTH, h, laws.swing),
        _solve_link(roots.boom, bends[1], rates[1], w[1], torques[1], r[1], rubs[0], h, laws.boom),
        _solve_link(roots.stick, bends[2], rates[2], w[2], torques[2], r[2], rubs[1], h, laws.stick),
        gains,
    )


def _solve_link(
    base: RootState,
    angle: float,
    rate: float,
    root_rate: float,
    torque: float,
    resistance: float,
    rub: Rub,
    h: float,
    link: ElasticLink,
) -> DriveSolution:
    if link.inertia == 0.0:
        return DriveSolution(torque, resistance, share=1.0, excess=0.0, give=0.0)
    passed = elastic_torque(base.angle + h * root_rate - angle, root_rate - rate, link)
    stiff = link.damping + h * link.stiffness
    if rub.friction.breakaway > 0.0:
        torque += rub.torque
        resistance -= rub.resistance
    give = 1.0 / (link.inertia + h * (resistance + stiff))
    excess = give * (link.inertia * (root_rate - base.rate) + h * (passed - torque))
    if rub.friction.breakaway > 0.0:
        turning = rubbing_rate(root_rate - excess, root_rate, give * h, rub)
        give /= max(LEAST_GIVE, 1.0 + give * h * rubbed(turning, rub)[1])
        excess = root_rate - turning
    share = give * h * stiff
    return DriveSolution(
        torque=passed - stiff * excess,
        resistance=stiff * (1.0 - share),
        share=share,
        excess=excess,
        give=give,
    )


def rubbed(rate: float, rub: Rub) -> Pair:
    """Return what friction takes from the torque on a root [N m] at its rate [rad/s], and its slope there."""
    at = rubbing(rub.arm * rate, rub.friction)
    return rub.arm * at.force, rub.arm * rub.arm * at.slope


def rubbing_rate(free: float, guess: float, give: float, rub: Rub) -> float:
    """Return the rate [rad/s] of a root with friction, w + give friction(w) = free.

    Friction brings the root towards rest and not past it: the rate lies between zero and the free
    one.

    Args:
        free: rate without friction [rad/s].
        guess: rate near the one sought, that of `rub` [rad/s].
        give: change of the rate by a torque [1/(N m s)].
        rub: the friction.
    """
    low, high = min(0.0, free), max(0.0, free)
    rate, torque, resistance = guess, rub.torque, rub.resistance
    if not low <= guess <= high:
        rate = min(high, max(low, guess))
        torque, resistance = rubbed(rate, rub)
    for _ in range(RUB_ITERATIONS):
        off = rate + give * torque - free
        if off > 0.0:
            high = rate
        else:
            low = rate
        slope = 1.0 + give * resistance
        newton = off / slope if slope > 0.0 else high - low
        if abs(newton) <= RUB_TOLERANCE:
            rate -= newton
            break
        rate = rate - newton if low < rate - newton < high else 0.5 * (low + high)
        torque, resistance = rubbed(rate, rub)
    return rate


def through_links(e: SupplyError, s: ElasticSolution) -> SupplyError:
    """Return the manifold's equation after the roots' rates are eliminated from it."""
    d, g = e.by_rate, s.gains
    return SupplyError(
        residual=e.residual - (d[0] * s.swing.excess + d[1] * s.boom.excess + d[2] * s.stick.excess),
        slope=e.slope + (d[0] * g[0] * s.swing.give + d[1] * g[1] * s.boom.give + d[2] * g[2] * s.stick.give),
        by_rate=(d[0] * s.swing.share, d[1] * s.boom.share, d[2] * s.stick.share),
        on_rates=(g[0] * s.swing.share, g[1] * s.boom.share, g[2] * s.stick.share),
        feeds=e.feeds,
        state=e.state,
        control=e.control,
    )


def root_corrections(c: Vec3, pressure: float, s: ElasticSolution) -> Vec3:
    """Return Newton's corrections of the roots' rates [rad/s].

    Args:
        c: those of the links' [rad/s].
        pressure: that of P_s [Pa].
        s: the roots.
    """
    g = s.gains
    return (
        s.swing.share * c[0] + s.swing.excess + s.swing.give * g[0] * pressure,
        s.boom.share * c[1] + s.boom.excess + s.boom.give * g[1] * pressure,
        s.stick.share * c[2] + s.stick.excess + s.stick.give * g[2] * pressure,
    )


def roots_after(base: PlantState, root_rates: Vec3, h: float, laws: ElasticLaws) -> Roots:
    """Return the roots at a stage's end, at their rates there [rad/s]."""
    roots = base.roots
    return Roots(
        _root_after(roots.swing, root_rates[0], h, laws.swing),
        _root_after(roots.boom, root_rates[1], h, laws.boom),
        _root_after(roots.stick, root_rates[2], h, laws.stick),
    )


def _root_after(base: RootState, rate: float, h: float, link: ElasticLink) -> RootState:
    return NO_ROOT if link.inertia == 0.0 else RootState(base.angle + h * rate, rate)
