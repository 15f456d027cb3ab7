"""Geometry of a drawn linear graph: nodes, curves and labels, from coordinates that a layout gives.

Nodes are points, or a rail for a reference (tank, frame). Coordinates are pixels, x to the right, y
down. A bend is how far [px] the middle of a branch stands off the straight line, upwards or to the
right positive; its label stands on that side.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from forest_sim.linear_graph.linear_graph import Branch, Domain, LinearGraph

FONT_PX = 19
SUBSCRIPT_PX = 13


class Point(NamedTuple):
    """A place in the drawing."""

    x: float
    y: float


class Rail(NamedTuple):
    """A reference node, drawn as a bar."""

    left: float
    right: float
    y: float


class Box(NamedTuple):
    """A rectangle: of a panel, or what a label covers."""

    left: float
    top: float
    right: float
    bottom: float


class Coupling(NamedTuple):
    """The dashed line of a two-port: from a fraction along port 1 to a fraction along port 2."""

    one: str
    along_one: float
    along_two: float
    label_offset: Point = Point(0.0, -16.0)


class Notation(NamedTuple):
    """A symbol taken apart: qdot_sw is q with a dot, subscript sw; C_R' has a prime."""

    base: str
    dotted: bool
    subscript: str
    prime: bool


@dataclass(frozen=True)
class Layout:
    """Where a graph's nodes stand, and how its branches run between them."""

    width: int
    height: int
    nodes: dict[str, Point]
    rails: dict[str, Rail]
    bends: dict[str, float] = field(default_factory=dict)
    flipped: frozenset[str] = frozenset()  # branches with the label on the other side
    couplings: tuple[Coupling, ...] = ()
    name_shifts: dict[str, float] = field(default_factory=dict)  # of nodes' names to the right
    panels: dict[Domain, Box] = field(default_factory=dict)


class Label(NamedTuple):
    """A symbol at a place, its middle there."""

    symbol: str
    middle: Point
    domain: Domain | None  # None: of a two-port

    @property
    def box(self) -> Box:
        """What it covers, by the widths of a usual serif font."""
        half, n = width(self.symbol) / 2.0, notation(self.symbol)
        low = 11.0 if n.subscript else 8.0
        return Box(self.middle.x - half, self.middle.y - 9.0, self.middle.x + half, self.middle.y + low)


def notation(symbol: str) -> Notation:
    """Return the parts of a symbol's name."""
    plain = symbol.removesuffix("'")
    base, _, subscript = plain.partition("_")
    return Notation(base.removesuffix("dot"), base.endswith("dot"), subscript, plain != symbol)


def labels(graph: LinearGraph, layout: Layout) -> list[Label]:
    """Return the labels of branches and two-ports; of a port it is the branch's own number."""
    found = []
    for branch in graph.branches:
        side = label_side(branch, layout)
        middle, normal = along(branch, layout, 0.5), sideways(branch, layout)
        symbol = branch.name if branch.partner else branch.parameter
        gap = 12.0 + abs(normal.x) * width(symbol) / 2.0 + abs(normal.y) * 9.0
        place = Point(middle.x + side * gap * normal.x, middle.y + side * gap * normal.y)
        found.append(Label(symbol, place, branch.domain))
    for coupling in layout.couplings:
        one, two = coupled(graph, coupling, layout)
        dx, dy = coupling.label_offset
        parameter = graph.branch(coupling.one).parameter
        found.append(Label(parameter, Point((one.x + two.x) / 2.0 + dx, (one.y + two.y) / 2.0 + dy), None))
    return found


def curve(branch: Branch, layout: Layout, points: int = 41) -> list[Point]:
    """Return points along a branch, from its start to its end."""
    return [along(branch, layout, k / (points - 1)) for k in range(points)]


def ends(branch: Branch, layout: Layout) -> tuple[Point, Point]:
    """Return both ends; on a rail straight below the other one."""
    start, end = layout.nodes.get(branch.start), layout.nodes.get(branch.end)
    if start is None and end is not None:
        start = Point(end.x, layout.rails[branch.start].y)
    if end is None and start is not None:
        end = Point(start.x, layout.rails[branch.end].y)
    if start is None or end is None:
        raise ValueError(f"the layout places neither {branch.start} nor {branch.end} of {branch.name}")
    return start, end


def sideways(branch: Branch, layout: Layout) -> Point:
    """Return the unit vector across a branch, upwards, or to the right of a vertical one."""
    start, end = ends(branch, layout)
    dx, dy = end.x - start.x, end.y - start.y
    if (dy if abs(dy) > abs(dx) else dx) < 0.0:  # whichever way the arrow points
        dx, dy = -dx, -dy
    length = math.hypot(dx, dy)
    return Point(dy / length, -dx / length)


def control(branch: Branch, layout: Layout) -> Point:
    """Return the control point of a branch's quadratic curve."""
    (start, end), normal = ends(branch, layout), sideways(branch, layout)
    bend = 2.0 * layout.bends.get(branch.name, 0.0)
    return Point((start.x + end.x) / 2.0 + bend * normal.x, (start.y + end.y) / 2.0 + bend * normal.y)


def along(branch: Branch, layout: Layout, t: float) -> Point:
    """Return the place at a fraction of a branch's way, 0 its start, 1 its end."""
    (a, b), c = ends(branch, layout), control(branch, layout)
    u, v, w = (1.0 - t) ** 2, 2.0 * t * (1.0 - t), t * t
    return Point(u * a.x + v * c.x + w * b.x, u * a.y + v * c.y + w * b.y)


def label_side(branch: Branch, layout: Layout) -> int:
    """Return on which side a branch's label stands, 1 upwards or right."""
    side = -1 if layout.bends.get(branch.name, 0.0) < 0.0 else 1
    return -side if branch.name in layout.flipped else side


def coupled(graph: LinearGraph, coupling: Coupling, layout: Layout) -> tuple[Point, Point]:
    """Return both ends of a two-port's dashed line."""
    one = graph.branch(coupling.one)
    two = graph.branch(one.partner or "")
    return along(one, layout, coupling.along_one), along(two, layout, coupling.along_two)


def width(symbol: str) -> float:
    """Return a symbol's width by a usual serif font [px]."""
    n = notation(symbol)
    return 0.62 * FONT_PX * len(n.base) + 0.62 * SUBSCRIPT_PX * len(n.subscript) + (5.0 if n.prime else 0.0)
