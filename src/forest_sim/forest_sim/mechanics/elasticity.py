"""A link that gives way: a spring and a damper between its root and the rest of it.

| symbol | name | unit |
|---|---|---|
| theta, q | angle of the root, where actuator and sensors are; of the link, where its tip is | rad |
| T | torque of the spring on the link, its reverse on the root | N m |
| k, c | stiffness, damping | N m/rad, N m s/rad |
| J | inertia of what turns with the root | kg m^2 |

    T = k (theta - q) + c (theta' - q'),     J theta'' = torque of the actuator - T

The link is a pseudo-rigid body: it turns about its joint as a whole. With k = 3 E I/L the tip of a
uniform cantilever under a force F at it has the deflection F L^3/(3 E I). Its slope there is then a
third less than the cantilever's. Book, Recursive Lagrangian dynamics of flexible manipulator arms, Int.
J. Robotics Research 3, 1984, has more modes a link; here it is one, the first.
"""

from typing import NamedTuple

from forest_description.mechanics.elasticity_parameters import Elasticity


class ElasticLink(NamedTuple):
    """Constants of the law; an `inertia` of 0 leaves it out: root and link are one."""

    inertia: float  # J [kg m^2]
    stiffness: float  # k [N m/rad]
    damping: float  # c [N m s/rad]


RIGID = ElasticLink(0.0, 0.0, 0.0)


def elastic_link(given: Elasticity | None) -> ElasticLink:
    """Return the law's constants; without elasticity the link is rigid."""
    if given is None:
        return RIGID
    return ElasticLink(given.root_inertia, given.stiffness, given.damping)


def elastic_torque(deflection: float, speed: float, link: ElasticLink) -> float:
    """Return T [N m] at a deflection theta - q [rad] and its rate [rad/s]."""
    return link.stiffness * deflection + link.damping * speed
