"""The drawings: every branch is there, the tree is bold, and no label stands on anything else."""

import xml.etree.ElementTree as ET
from itertools import combinations

import pytest

from forest_sim.linear_graph.drawing import COLOURS, NAME_PX, NAME_RISE, svg
from forest_sim.linear_graph.drawing_geometry import (
    Box,
    Label,
    Layout,
    Point,
    along,
    coupled,
    curve,
    ends,
    labels,
    notation,
    sideways,
    width,
)
from forest_sim.linear_graph.layouts import CIRCUITS
from forest_sim.linear_graph.linear_graph import Branch, Domain, Kind
from forest_sim.linear_graph.normal_tree import normal_tree

ALL = pytest.mark.parametrize("circuit", CIRCUITS, ids=lambda c: c.file)
SVG = "{http://www.w3.org/2000/svg}"
LAYOUT = Layout(100, 100, {"a": Point(0, 0), "b": Point(100, 0)}, {})


def overlap(one, two):
    return one.left < two.right and two.left < one.right and one.top < two.bottom and two.top < one.bottom


def holds(box, point):
    return box.left <= point.x <= box.right and box.top <= point.y <= box.bottom


def names(layout):
    """Return what the names of the nodes cover."""
    for name, place in layout.nodes.items():
        half, bottom = 0.3 * NAME_PX * len(name), place.y - NAME_RISE + 3.0
        x = place.x + layout.name_shifts.get(name, 0.0)
        yield name, Box(x - half, bottom - NAME_PX, x + half, bottom)


@ALL
def test_labels_stand_clear_of_each_other(circuit):
    boxes = [(label.symbol, label.box) for label in labels(circuit.graph(), circuit.layout)]
    boxes += list(names(circuit.layout))
    assert not [(a, b) for (a, one), (b, two) in combinations(boxes, 2) if overlap(one, two)]


@ALL
def test_labels_stand_clear_of_branches_and_couplings_and_inside_the_picture(circuit):
    graph, layout = circuit.graph(), circuit.layout
    lines = {branch.name: curve(branch, layout, 201) for branch in graph.branches}
    for coupling in layout.couplings:
        one, two = coupled(graph, coupling, layout)
        lines[f"two-port {coupling.one}"] = [
            Point(one.x + t * (two.x - one.x), one.y + t * (two.y - one.y))
            for t in (k / 50 for k in range(51))
        ]
    picture = Box(0, 0, layout.width, layout.height)
    for symbol, box in [*((label.symbol, label.box) for label in labels(graph, layout)), *names(layout)]:
        # Half a bold line's width and a little air.
        wide = Box(box.left - 3.0, box.top - 3.0, box.right + 3.0, box.bottom + 3.0)
        hit = [name for name, points in lines.items() if any(holds(wide, point) for point in points)]
        assert not hit, symbol
        assert holds(picture, Point(box.left, box.top))
        assert holds(picture, Point(box.right, box.bottom))


@ALL
def test_every_branch_is_drawn_in_its_domains_colour_and_the_tree_is_bold(circuit):
    tree = normal_tree(circuit.graph())
    paths = [p for p in ET.fromstring(svg(tree, circuit.layout)).iter(f"{SVG}path") if " Q " in p.get("d")]
    assert len(paths) == len(tree.graph.branches)
    inside = {branch.name for branch in tree.tree}
    for branch, path in zip(tree.graph.branches, paths, strict=True):
        assert path.get("stroke") == COLOURS[branch.domain]
        assert (float(path.get("stroke-width")) > 3.0) == (branch.name in inside)


@ALL
def test_domains_other_than_the_hydraulic_one_stay_on_their_panel(circuit):
    for branch in circuit.graph().branches:
        for domain, panel in circuit.layout.panels.items():
            on_panel = all(holds(panel, point) for point in curve(branch, circuit.layout))
            assert on_panel == (branch.domain is domain)


@ALL
def test_every_two_port_is_coupled(circuit):
    coupled_ports = {coupling.one for coupling in circuit.layout.couplings}
    assert coupled_ports == {one.name for one, _ in circuit.graph().pairs()}


def test_a_branch_runs_from_start_to_end_and_bends_upwards():
    there, back = Branch("R", Kind.D_TYPE, "a", "b", "R"), Branch("R", Kind.D_TYPE, "b", "a", "R")
    bent = Layout(100, 100, LAYOUT.nodes, {}, bends={"R": 20.0})
    assert ends(there, bent) == (Point(0, 0), Point(100, 0))
    assert curve(back, bent)[0] == Point(100, 0)
    assert along(there, bent, 0.5) == along(back, bent, 0.5) == Point(50, -20)
    assert sideways(there, bent) == sideways(back, bent) == Point(0, -1)


def test_a_branch_without_a_place_is_named():
    with pytest.raises(ValueError, match="places neither x nor y of R"):
        ends(Branch("R", Kind.D_TYPE, "x", "y", "R"), LAYOUT)


def test_symbols_are_taken_apart():
    assert notation("C_R'") == ("C", False, "R", True)
    assert notation("qdot_sw") == ("q", True, "sw", False)
    assert notation("B") == ("B", False, "", False)


def test_a_labels_box_is_as_wide_as_its_symbol():
    box = Label("R_in", Point(50, 50), Domain.HYDRAULIC).box
    assert box.right - box.left == pytest.approx(width("R_in"))
    assert width("R_in") > width("R")
