"""Drawings of linear graphs as SVG.

Nodes are dots, references bars; a branch is a curve with its arrow in the middle and its element's
symbol beside it. Branches of the normal tree are bold. Each domain has its colour, and what is not
hydraulic stands on a panel of its own; a dashed line couples the two ports of a two-port.
"""

import math
from html import escape

from forest_sim.linear_graph.drawing_geometry import (
    FONT_PX,
    SUBSCRIPT_PX,
    Box,
    Coupling,
    Label,
    Layout,
    Rail,
    along,
    control,
    coupled,
    ends,
    labels,
    notation,
    width,
)
from forest_sim.linear_graph.linear_graph import Branch, Domain, LinearGraph
from forest_sim.linear_graph.normal_tree import NormalTree

NAME_PX = 12  # of nodes
NAME_RISE = 11.0
GREY = "#555555"
COLOURS = {Domain.HYDRAULIC: "#1c5d9f", Domain.ROTATION: "#b0501a", Domain.TRANSLATION: "#2f7d32"}
TINTS = {Domain.HYDRAULIC: "#ffffff", Domain.ROTATION: "#fdf1e7", Domain.TRANSLATION: "#edf6ed"}
DOT = "\u0307"  # combining


def svg(tree: NormalTree, layout: Layout) -> str:
    """Return the drawing as the text of an SVG file. Thesis fig. 3.8, 3.9: the style."""
    graph, inside = tree.graph, {branch.name for branch in tree.tree}
    size = f'width="{layout.width}" height="{layout.height}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {layout.width} {layout.height}" {size}',
        'font-family="DejaVu Serif, Georgia, Times, serif">',
        f"<title>Linear graph of {escape(graph.name)}</title>",
        f'<rect {size} fill="#ffffff"/>',
    ]
    parts += [_panel(domain, box) for domain, box in layout.panels.items()]
    parts += [_domain(domain, layout) for domain in graph.domains if domain not in layout.panels]
    parts += [_rail(rail, name) for name, rail in layout.rails.items()]
    parts += [_coupling(graph, coupling, layout) for coupling in layout.couplings]
    parts += [_branch(branch, layout, branch.name in inside) for branch in graph.branches]
    parts += [_node(name, layout) for name in layout.nodes]
    parts += [_text(label) for label in labels(graph, layout)]
    parts += [_caption(layout.height - 14.0)]
    return "\n".join([*parts, "</svg>", ""])


def _branch(branch: Branch, layout: Layout, in_tree: bool) -> str:
    """Draw the curve, and its arrow at the middle, where the tangent runs from end to end."""
    (start, end), c = ends(branch, layout), control(branch, layout)
    colour, width = COLOURS[branch.domain], 5.0 if in_tree else 1.8
    middle = along(branch, layout, 0.5)
    angle = math.degrees(math.atan2(end.y - start.y, end.x - start.x))
    return (
        f'<path d="M {start.x:g} {start.y:g} Q {c.x:g} {c.y:g} {end.x:g} {end.y:g}" fill="none" '
        f'stroke="{colour}" stroke-width="{width:g}"/>'
        f'<path d="M 10 0 L -7 7 L -3 0 L -7 -7 Z" fill="{colour}" '
        f'transform="translate({middle.x:g} {middle.y:g}) rotate({angle:.1f})"/>'
    )


def _coupling(graph: LinearGraph, coupling: Coupling, layout: Layout) -> str:
    one, two = coupled(graph, coupling, layout)
    return (
        f'<path d="M {one.x:.1f} {one.y:.1f} L {two.x:.1f} {two.y:.1f}" stroke="#777777" stroke-width="1.5" '
        f'stroke-dasharray="5 4"/>'
    )


def _node(name: str, layout: Layout) -> str:
    place = layout.nodes[name]
    x = place.x + layout.name_shifts.get(name, 0.0)
    return (
        f'<circle cx="{place.x:g}" cy="{place.y:g}" r="5" fill="#111111"/>'
        f'<text x="{x:g}" y="{place.y - NAME_RISE:g}" font-size="{NAME_PX}" fill="{GREY}" '
        f'text-anchor="middle">{escape(name)}</text>'
    )


def _rail(rail: Rail, name: str) -> str:
    hatches = "".join(
        f"M {x:g} {rail.y:g} l -8 9 " for x in range(int(rail.left) + 10, int(rail.right) + 1, 14)
    )
    return (
        f'<path d="M {rail.left:g} {rail.y:g} H {rail.right:g}" stroke="#111111" stroke-width="3"/>'
        f'<path d="{hatches.strip()}" stroke="#111111" stroke-width="1"/>'
        f'<text x="{rail.right:g}" y="{rail.y + 24:g}" font-size="13" fill="{GREY}" text-anchor="end">'
        f"{escape(name)}</text>"
    )


def _panel(domain: Domain, box: Box) -> str:
    return (
        f'<rect x="{box.left:g}" y="{box.top:g}" width="{box.right - box.left:g}" '
        f'height="{box.bottom - box.top:g}" rx="12" fill="{TINTS[domain]}"/>'
        f'<text x="{box.left + 12:g}" y="{box.bottom - 10:g}" font-size="13" fill="{COLOURS[domain]}">'
        f"{domain.name.lower()}</text>"
    )


def _domain(domain: Domain, layout: Layout) -> str:
    """Name a domain without a panel under the lowest rail."""
    rail = max(layout.rails.values(), key=lambda r: r.y)
    return (
        f'<text x="{rail.left + 10:g}" y="{rail.y + 24:g}" font-size="13" fill="{COLOURS[domain]}">'
        f"{domain.name.lower()}</text>"
    )


def _caption(y: float) -> str:
    return (
        f'<text x="40" y="{y:g}" font-size="13" fill="{GREY}">'
        f"bold: normal tree; thin: links; dashed: two-ports; bars: reference nodes</text>"
    )


def _text(label: Label) -> str:
    """Draw a symbol from its left edge: base in italics, subscript below, prime above."""
    n, colour = notation(label.symbol), GREY if label.domain is None else COLOURS[label.domain]
    x, y = label.middle.x - width(label.symbol) / 2.0, label.middle.y + 6.0
    style = ' font-style="italic"' if not n.base.isdigit() else ""
    parts = [f"<tspan{style}>{escape(n.base)}{DOT if n.dotted else ''}</tspan>"]
    if n.subscript:
        parts.append(f'<tspan dy="5" font-size="{SUBSCRIPT_PX}">{escape(n.subscript)}</tspan>')
    if n.prime:
        parts.append(f'<tspan dy="{-5 if n.subscript else 0}">′</tspan>')
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{FONT_PX}" fill="{colour}">' + "".join(parts) + "</text>"
    )
