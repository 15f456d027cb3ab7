"""What a scene is made of, as JSON takes it; lengths [m] and angles [rad] in the base frame, or a link's.

The page draws what stands here and knows no machine. docs/reference/station-protocol.md describes it.
"""

from typing import Literal, TypedDict


class Visual(TypedDict):
    """A shape of a link: box (length, width, height), cylinder along z (radius, length), sphere (radius)."""

    shape: str
    size: list[float]
    xyz: list[float]
    rpy: list[float]


class Mimic(TypedDict):
    """A joint that follows another one as offset + multiplier q where nobody tells its own position."""

    joint: str
    multiplier: float
    offset: float


class Joint(TypedDict):
    """A joint of the tree: ``signal`` tells its position, ``limit`` is (lower, upper).

    ``deflection`` tells by how much a link that bends is ahead of its joint.
    """

    name: str
    type: str
    parent: str
    child: str
    xyz: list[float]
    rpy: list[float]
    axis: list[float]
    limit: list[float] | None
    mimic: Mimic | None
    signal: str | None
    deflection: str | None


class HosePoint(TypedDict):
    """A point that moves with a link."""

    link: str
    xyz: list[float]


class FlowSignal(TypedDict):
    """A signal that tells how oil flows; times ``factor`` about 1 at full flow towards the actuator."""

    signal: str
    factor: float


class Hose(TypedDict):
    """A hose from valve to port; the first of ``flow`` that is known tells the direction."""

    name: str
    points: list[HosePoint]
    flow: list[FlowSignal]


class PlaneWall(TypedDict):
    """The tip stays where p.normal >= offset."""

    kind: Literal["plane"]
    name: str
    normal: list[float]
    offset: float


class BoxWall(TypedDict):
    """The tip stays out of a box."""

    kind: Literal["box"]
    name: str
    lower: list[float]
    upper: list[float]


class CylinderWall(TypedDict):
    """The tip stays out of an upright cylinder about centre (x, y) from z = bottom to top."""

    kind: Literal["cylinder"]
    name: str
    centre: list[float]
    radius: float
    bottom: float
    top: float


DrawnWall = PlaneWall | BoxWall | CylinderWall


class WorkArea(TypedDict):
    """Where the tip can be: outline (r, z) in the crane's plane, radii on the ground, range of swing."""

    section: list[list[float]]
    ground: list[float] | None
    swing: list[float]


class Thing(TypedDict):
    """A thing for the eye only: the crane neither feels nor avoids it."""

    kind: str
    xyz: list[float]
    size: list[float]
    yaw: float


class Scene(TypedDict):
    """Everything that the page draws."""

    machine: str
    links: dict[str, list[Visual]]
    joints: list[Joint]
    hoses: list[Hose]
    ground: float
    walls: list[DrawnWall]
    slow_zone: float
    work_area: WorkArea
    capacity: list[list[float]]
    surroundings: list[Thing]
