"""A cycle of taught work: segments in their order, each with a name.

| symbol | name | unit |
|---|---|---|
| tip, points | places of the tip in the base frame: x ahead, y left, z up from the boom's pivot | m |
| speed | wished speed of the tip; limits may leave less | m/s |
| wait | of a grapple: how long it takes; `CONFIRMATION`: until a person confirms | s |
"""

from typing import NamedTuple

from forest_description.types import Vec3

CONFIRMATION = 0.0  # [s] `wait` of a grapple that a person confirms: no grapple takes no time
ACTIONS = ("close", "open")


class Pose(NamedTuple):
    """A place that the tip goes to on a straight line, from wherever it is."""

    name: str
    tip: Vec3
    speed: float


class Path(NamedTuple):
    """A path that the tip follows from its first point to its last."""

    name: str
    points: tuple[Vec3, ...]
    speed: float


class Grapple(NamedTuple):
    """A step of the grapple, while the tip stands."""

    name: str
    action: str  # of `ACTIONS`
    wait: float = CONFIRMATION


Segment = Pose | Path | Grapple


class Cycle(NamedTuple):
    """What is taught under a name."""

    name: str
    segments: tuple[Segment, ...] = ()
    description: str = ""

    def with_segment(self, segment: Segment) -> "Cycle":
        """Return the cycle with one more segment, under a name that no other has."""
        taken = {one.name for one in self.segments}
        name, count = segment.name, 1
        while name in taken:
            count += 1
            name = f"{segment.name} {count}"
        return self._replace(segments=(*self.segments, segment._replace(name=name)))
