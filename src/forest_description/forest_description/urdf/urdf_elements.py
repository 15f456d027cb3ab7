"""What a URDF is made of: links with mass and shape, joints with limits; numbers with all their digits."""

from typing import NamedTuple
from xml.etree import ElementTree

from forest_description.derived.limits import Interval
from forest_description.types import Vec3

ORIGIN: Vec3 = (0.0, 0.0, 0.0)


class Inertial(NamedTuple):
    """Mass [kg], centre of mass [m], and the inertia tensor about it in the link's directions [kg m^2]."""

    mass: float
    centre: Vec3
    diagonal: Vec3  # ixx, iyy, izz
    ixz: float  # the only product that a body symmetric about the x-z plane has


def link(robot: ElementTree.Element, name: str, inertial: Inertial | None = None) -> ElementTree.Element:
    """Add a link; without mass properties it is only drawn."""
    added = ElementTree.SubElement(robot, "link", name=name)
    if inertial is None:
        return added
    element = ElementTree.SubElement(added, "inertial")
    ElementTree.SubElement(element, "origin", xyz=text(inertial.centre), rpy=text(ORIGIN))
    ElementTree.SubElement(element, "mass", value=repr(inertial.mass))
    moments = dict(zip(("ixx", "iyy", "izz"), map(repr, inertial.diagonal), strict=True))
    moments |= {"ixy": "0", "ixz": repr(inertial.ixz), "iyz": "0"}
    ElementTree.SubElement(element, "inertia", moments)
    return added


def material(robot: ElementTree.Element, name: str, colour: Vec3) -> None:
    """Add a colour, red, green and blue 0..1, that visuals name."""
    element = ElementTree.SubElement(robot, "material", name=name)
    ElementTree.SubElement(element, "color", rgba=f"{text(colour)} 1.0")


def visual(
    owner: ElementTree.Element,
    colour: str,
    shape: str,
    centre: Vec3 = ORIGIN,
    turned: Vec3 = ORIGIN,
    **size: str,
) -> None:
    """Add what a viewer draws: box, cylinder (along its z) or sphere; roll, pitch, yaw turn it."""
    element = ElementTree.SubElement(owner, "visual")
    ElementTree.SubElement(element, "origin", xyz=text(centre), rpy=text(turned))
    ElementTree.SubElement(ElementTree.SubElement(element, "geometry"), shape, size)
    ElementTree.SubElement(element, "material", name=colour)


def joint(
    robot: ElementTree.Element,
    name: str,
    kind: str,
    between: tuple[str, str],
    place: Vec3,
    axis: Vec3 | None = None,
) -> ElementTree.Element:
    """Add a joint between parent and child at ``place`` in the parent's frame."""
    added = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(added, "parent", link=between[0])
    ElementTree.SubElement(added, "child", link=between[1])
    ElementTree.SubElement(added, "origin", xyz=text(place), rpy=text(ORIGIN))
    if axis is not None:
        ElementTree.SubElement(added, "axis", xyz=text(axis))
    return added


def limit(of: ElementTree.Element, interval: Interval, effort: float, speed: float) -> None:
    """Add range [rad, m], greatest effort [N m, N] and greatest speed [rad/s, m/s] of a joint."""
    lower, upper = map(repr, interval)
    ElementTree.SubElement(of, "limit", lower=lower, upper=upper, effort=repr(effort), velocity=repr(speed))


def mimic(follower: ElementTree.Element, leader: str, multiplier: float, offset: float) -> None:
    """Let a joint follow another one where nobody tells its own position."""
    ElementTree.SubElement(follower, "mimic", joint=leader, multiplier=repr(multiplier), offset=repr(offset))


def text(numbers: Vec3) -> str:
    """Return three numbers as URDF writes them."""
    return " ".join(repr(number) for number in numbers)
