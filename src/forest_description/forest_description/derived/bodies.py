"""Rigid bodies of boom and stick with what the stick carries: one source for the dynamics and for the URDF.

Every body is symmetric about the crane's plane. Frames as in Appendix B: x along the link from its
joint, y across, upwards when the link points forward, z the joint axis.

| symbol | name | unit |
|---|---|---|
| m | mass | kg |
| x, y | centre of mass | m |
| I_xx, I_yy, I_zz | moments of inertia about the centre of mass | kg m^2 |
| I_xy | product of inertia about it, the integral of x y dm (the inertia tensor holds -I_xy) | kg m^2 |
"""

import dataclasses
from typing import NamedTuple

from forest_description.mechanics.load import Log, RotatorAndGrapple
from forest_description.mechanics.manipulator_parameters import Manipulator


class PlanarBody(NamedTuple):
    """Mass properties of a body that is symmetric about the crane's plane."""

    mass: float
    x: float
    y: float
    xx: float
    yy: float
    zz: float
    xy: float


class HangingBody(NamedTuple):
    """Mass properties of a body of revolution under its joint, the spin about its own axis left out."""

    mass: float
    length: float  # joint to centre of mass [m]
    inertia: float  # about the centre of mass, across the axis [kg m^2]
    log_inertia: float  # what a log in the crane's plane adds about the level axis across that [kg m^2]


def point_mass(mass: float, x: float, y: float) -> PlanarBody:
    """Return a body without extent."""
    return PlanarBody(mass=mass, x=x, y=y, xx=0.0, yy=0.0, zz=0.0, xy=0.0)


def combined(a: PlanarBody, b: PlanarBody) -> PlanarBody:
    """Return two bodies, described in one frame, as one: parallel axes to the common centre of mass."""
    mass = a.mass + b.mass
    if mass == 0.0:
        return a
    x, y = (a.mass * a.x + b.mass * b.x) / mass, (a.mass * a.y + b.mass * b.y) / mass
    along = a.mass * (x - a.x) ** 2 + b.mass * (x - b.x) ** 2
    across = a.mass * (y - a.y) ** 2 + b.mass * (y - b.y) ** 2
    product = a.mass * (x - a.x) * (y - a.y) + b.mass * (x - b.x) * (y - b.y)
    return PlanarBody(
        mass=mass,
        x=x,
        y=y,
        xx=a.xx + b.xx + across,
        yy=a.yy + b.yy + along,
        zz=a.zz + b.zz + along + across,
        xy=a.xy + b.xy + product,
    )


def boom_body(m: Manipulator) -> PlanarBody:
    """Return the boom. Thesis App. B."""
    return PlanarBody(
        mass=m.boom_mass, x=m.boom_x, y=m.boom_y, xx=m.boom_xx, yy=m.boom_yy, zz=m.boom_zz, xy=m.boom_xy
    )


def stick_body(m: Manipulator) -> PlanarBody:
    """Return the stick with all that is rigidly part of it: head and log, unless they hang. Thesis App. B.

    Differs: Appendix B leaves I_xx and I_xy at zero when it folds the head's point mass into the
    stick (`head_folding: thesis`); `full` gives the stick the shares that a point off its axis has.
    """
    stick = PlanarBody(
        mass=m.stick_mass,
        x=m.stick_x,
        y=m.stick_y,
        xx=m.stick_xx,
        yy=m.stick_yy,
        zz=m.stick_zz,
        xy=m.stick_xy,
    )
    if m.pendulum is not None:
        return stick
    loaded = combined(stick, point_mass(m.head_mass, m.stick_length, 0.0))
    if m.head_folding == "thesis":
        loaded = loaded._replace(xx=stick.xx, xy=stick.xy)
    if m.log is None:
        return loaded
    log = point_mass(m.log.mass, m.stick_length + m.log.x, m.log.y)
    return combined(loaded, log._replace(yy=m.log.inertia, zz=m.log.inertia))


def bearing_stick(m: Manipulator) -> PlanarBody:
    """Return the stick with all whose weight it bears: a head that hangs is a point at its joint."""
    hanging = hanging_body(m)
    stick = stick_body(m)
    return stick if hanging is None else combined(stick, point_mass(hanging.mass, m.stick_length, 0.0))


def hanging_body(m: Manipulator) -> HangingBody | None:
    """Return head and log under the pendulum's joint as one body, None without a pendulum."""
    if m.pendulum is None:
        return None
    if isinstance(m.pendulum, RotatorAndGrapple):
        head = _rotator_and_grapple(m.pendulum, m.head_mass)
    else:
        head = HangingBody(m.head_mass, m.pendulum.length, m.pendulum.inertia, 0.0)
    if m.log is None:
        return head
    return _on_axis(head, HangingBody(m.log.mass, m.log.x, 0.0, m.log.inertia))


def _rotator_and_grapple(p: RotatorAndGrapple, head_mass: float) -> HangingBody:
    """Return both parts as one body."""
    grapple = head_mass - p.rotator_mass, p.rotator_length + p.grapple_centre, p.grapple_inertia
    return _on_axis(HangingBody(*grapple, 0.0), HangingBody(p.rotator_mass, p.rotator_centre, 0.0, 0.0))


def _on_axis(a: HangingBody, b: HangingBody) -> HangingBody:
    """Return two bodies on one axis as one: parallel axes to the common centre of mass."""
    mass = a.mass + b.mass
    length = (a.mass * a.length + b.mass * b.length) / mass
    apart = a.mass * (a.length - length) ** 2 + b.mass * (b.length - length) ** 2
    return HangingBody(mass, length, a.inertia + b.inertia + apart, a.log_inertia + b.log_inertia)


def with_log(m: Manipulator, mass: float, length: float) -> Manipulator:
    """Return a crane whose head holds a log of a mass [kg] and a length [m]; of no mass: none.

    The log's centre is where the machine's own log has it, at the grapple's grip, or at the head's
    centre.
    """
    if mass == 0.0:
        return dataclasses.replace(m, log=None)
    x, y = (m.log.x, m.log.y) if m.log is not None else (_grip(m), 0.0)
    return dataclasses.replace(m, log=Log(mass, x, y, length))


def _grip(m: Manipulator) -> float:
    """Return how far from the tip a log is held [m]."""
    if isinstance(m.pendulum, RotatorAndGrapple):
        return m.pendulum.rotator_length + m.pendulum.grip
    return 0.0 if m.pendulum is None else m.pendulum.length
