#!/usr/bin/env python3
"""Draw the C-180 from its machine file as docs/pictures/crane.svg: .venv/bin/python scripts/crane_picture.py.

Links, cylinders, pins and the reach of the tip have the numbers of the machine file. Carrier, grapple and the
thickness of the beams are drawn by eye, because the thesis does not print them.

Frame: the crane's plane, x forward from the swing axis, z up from the boom pivot [m].
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from forest_description.derived.limits import joint_limits
from forest_description.derived.passive_joints import barrel_pivot
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.machine import Machine, load_machine
from forest_description.mechanics.drives import CylinderDrive

Point = tuple[float, float]

OUTPUT = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "crane.svg"
BOOM, STICK = math.radians(43.0), math.radians(-72.0)  # the pose that is drawn
WIDTH, HEIGHT, SCALE = 1040, 540, 88.0  # [px], [px], [px/m]
ORIGIN = (180.0, 375.0)  # of the frame [px]
GROUND = -1.45  # [m]
STEEL, EDGE, DARK, GREY, BLUE, RED = "#f0b323", "#7a5300", "#37424d", "#aeb8c0", "#1c5d9f", "#c62828"


def at(origin: Point, angle: float, along: float, up: float = 0.0) -> Point:
    """Return a point that lies `along` and `up` [m] in a frame turned by `angle` [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return origin[0] + along * c - up * s, origin[1] + along * s + up * c


def px(point: Point) -> str:
    """Return a point of the crane's plane as SVG coordinates."""
    return f"{ORIGIN[0] + SCALE * point[0]:.1f},{ORIGIN[1] - SCALE * point[1]:.1f}"


def polygon(points: Iterable[Point], style: str) -> str:
    """Return a closed outline."""
    return f'<polygon points="{" ".join(map(px, points))}" {style}/>'


def line(points: Iterable[Point], style: str) -> str:
    """Return an open line."""
    return f'<polyline points="{" ".join(map(px, points))}" fill="none" {style}/>'


def circle(centre: Point, radius: float, style: str) -> str:
    """Return a circle of a radius [m]."""
    x, y = px(centre).split(",")
    return f'<circle cx="{x}" cy="{y}" r="{SCALE * radius:.1f}" {style}/>'


def label(point: Point, words: str, colour: str = DARK, anchor: str = "start", size: int = 17) -> str:
    """Return words beside a point."""
    x, y = px(point).split(",")
    style = f'font-size="{size}" fill="{colour}" text-anchor="{anchor}"'
    return f'<text x="{x}" y="{y}" {style}>{words}</text>'


def arc(centre: Point, radius: float, start: float, end: float) -> str:
    """Return an angle's arc with an arrow at its end [rad]."""
    points = [at(centre, start + (end - start) * k / 24, radius) for k in range(25)]
    return line(points, f'stroke="{BLUE}" stroke-width="2" marker-end="url(#arrow)"')


def beam(pivot: Point, angle: float, length: float, profile: Sequence[tuple[float, float]]) -> str:
    """Return a tapered beam: (share of the length, half thickness [m]) from its pivot on."""
    upper = [at(pivot, angle, share * length, half) for share, half in profile]
    lower = [at(pivot, angle, share * length, -half) for share, half in reversed(profile)]
    return polygon(upper + lower, f'fill="{STEEL}" stroke="{EDGE}" stroke-width="2" stroke-linejoin="round"')


def cylinder(joint: Point, parent: float, angle: float, drive: CylinderDrive) -> list[str]:
    """Return barrel and rod between the pin on the parent link and the pin on the driven link."""
    base = at(joint, parent, *barrel_pivot(drive.linkage))
    eye = at(joint, angle, drive.pivot_to_rod)
    direction = math.atan2(eye[1] - base[1], eye[0] - base[0])
    head = at(base, direction, drive.retracted_length - 0.12)
    return [
        line([base, eye], f'stroke="{DARK}" stroke-width="9"'),
        line([base, eye], 'stroke="#e4e9ed" stroke-width="6"'),
        line([base, head], f'stroke="{DARK}" stroke-width="18" stroke-linecap="round"'),
        line([base, head], 'stroke="#5b6975" stroke-width="14" stroke-linecap="round"'),
        *(circle(pin, 0.05, f'fill="#ffffff" stroke="{DARK}" stroke-width="2.5"') for pin in (base, eye)),
    ]


def reach(machine: Machine, links: Links) -> list[Point]:
    """Return the outline of what the tip reaches in the crane's plane: the four edges of the joint limits."""
    _, (low, high), (fold, out) = joint_limits(machine)
    steps = [k / 40 for k in range(41)]
    poses = [(low + t * (high - low), out) for t in steps]
    poses += [(high, out + t * (fold - out)) for t in steps]
    poses += [(high + t * (low - high), fold) for t in steps]
    poses += [(low, fold + t * (out - fold)) for t in steps]
    tips = [tip_position((0.0, boom, stick), links) for boom, stick in poses]
    return [(x, z) for x, _, z in tips]


def carrier() -> list[str]:
    """Return the carrier and the column of the swing."""
    grey = f'fill="{GREY}" stroke="#87929b" stroke-width="2" stroke-linejoin="round"'
    dark = f'fill="#56626c" stroke="{DARK}" stroke-width="2" stroke-linejoin="round"'
    column = [(-0.27, -0.72), (0.52, -0.72), (0.5, -0.42), (0.27, -0.28), (0.22, 0.14)]
    return [
        polygon([(-9.0, GROUND), (10.0, GROUND), (10.0, -3.0), (-9.0, -3.0)], 'fill="#e9e4da"'),
        line([(-9.0, GROUND), (10.0, GROUND)], 'stroke="#b3a88f" stroke-width="2"'),
        polygon([(-1.9, -0.78), (1.5, -0.78), (1.5, -1.08), (-1.9, -1.08)], grey),
        *(circle((x, GROUND + 0.38), 0.38, dark) for x in (-1.35, -0.35, 0.95)),
        *(circle((x, GROUND + 0.38), 0.16, grey) for x in (-1.35, -0.35, 0.95)),
        polygon([*column, (-0.02, 0.2), (-0.2, 0.1)], dark),
    ]


def grapple(tip: Point) -> list[str]:
    """Return the head that hangs at the tip."""
    style = f'fill="#8d99a3" stroke="{DARK}" stroke-width="2" stroke-linejoin="round"'
    x, z = tip
    rotator = [(x - 0.07, z), (x + 0.07, z), (x + 0.09, z - 0.3), (x - 0.09, z - 0.3)]
    outer = [
        (0.06, -0.28),
        (0.36, -0.48),
        (0.38, -0.8),
        (0.1, -1.02),
        (0.26, -0.76),
        (0.24, -0.56),
        (0.0, -0.4),
    ]
    claws = [[(x + sign * dx, z + dz) for dx, dz in outer] for sign in (-1.0, 1.0)]
    return [*(polygon(claw, style) for claw in claws), polygon(rotator, style)]


def names_and_angles(pivot: Point, elbow: Point, tip: Point, machine: Machine) -> list[str]:
    """Return axes, angles and names."""
    thin = f'stroke="{BLUE}" stroke-width="1.5" stroke-dasharray="7 5"'
    parts, direction = machine.manipulator, BOOM + STICK
    turn = [math.pi * (1.1 + k / 16) for k in range(26)]
    swing = [(0.42 * math.cos(t), 1.02 + 0.11 * math.sin(t)) for t in turn]
    return [
        line([(0.0, -0.7), (0.0, 1.5)], thin),
        line(swing, f'stroke="{BLUE}" stroke-width="2" marker-end="url(#arrow)"'),
        line([pivot, (pivot[0] + 1.75, 0.0)], thin),
        arc(pivot, 1.5, 0.0, BOOM),
        line([elbow, at(elbow, BOOM, 1.25)], thin),
        arc(elbow, 1.05, BOOM, direction),
        label((0.0, 1.6), "swing, ±180°", BLUE, "middle"),
        label(at(pivot, 0.5 * BOOM, 1.62), "boom angle", BLUE),
        label(at(elbow, BOOM + 0.4 * STICK, 1.15), "stick angle, negative", BLUE),
        label(
            at(pivot, BOOM, 0.66 * parts.boom_length, 0.32), f"boom, {parts.boom_length:.2f} m", EDGE, "end"
        ),
        label(
            at(elbow, direction, 0.56 * parts.stick_length, 0.26), f"stick, {parts.stick_length:.2f} m", EDGE
        ),
        label((0.66, -0.34), "boom cylinder"),
        label((2.95, 1.62), "stick cylinder"),
        label((-0.35, -0.3), "swing motor", anchor="end"),
        circle(tip, 0.085, f'fill="#ffffff" stroke="{RED}" stroke-width="4"'),
        label((tip[0] + 0.2, tip[1] + 0.2), "tip", RED),
        label((tip[0] + 0.2, tip[1] - 0.03), "what the operator moves", RED, size=15),
        label((tip[0] + 0.45, tip[1] - 0.7), f"head, {parts.head_mass:.0f} kg"),
        label((1.6, -1.0), "carrier", "#6b7780", size=15),
        label((5.0, -1.2), "shaded: reach of the tip", "#4d7ba8", size=15),
    ]


def svg(machine: Machine) -> str:
    """Return the drawing as the text of an SVG file."""
    parts = machine.manipulator
    links = Links(parts.base_offset, parts.boom_length, parts.stick_length)
    pivot = (parts.base_offset, 0.0)
    elbow = at(pivot, BOOM, parts.boom_length)
    tip = at(elbow, BOOM + STICK, parts.stick_length)
    pin = f'fill="#ffffff" stroke="{DARK}" stroke-width="3"'
    drawing = [
        polygon(reach(machine, links), 'fill="#dcebf8" stroke="#9dc0e0" stroke-width="1.5"'),
        *carrier(),
        *grapple(tip),
        beam(elbow, BOOM + STICK, parts.stick_length, [(-0.03, 0.1), (0.2, 0.15), (1.0, 0.07)]),
        beam(pivot, BOOM, parts.boom_length, [(-0.03, 0.11), (0.43, 0.2), (0.55, 0.19), (1.025, 0.1)]),
        *cylinder(elbow, BOOM, BOOM + STICK, machine.stick),
        *cylinder(pivot, 0.0, BOOM, machine.boom),
        circle(pivot, 0.07, pin),
        circle(elbow, 0.07, pin),
        *names_and_angles(pivot, elbow, tip, machine),
    ]
    size = f'width="{WIDTH}" height="{HEIGHT}"'
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" {size}',
        'font-family="DejaVu Sans, Helvetica, Arial, sans-serif">',
        "<title>The C-180 with its cylinders, its angles and the reach of its tip</title>",
        '<defs><marker id="arrow" orient="auto" markerWidth="9" markerHeight="8" refX="6" refY="4">',
        f'<path d="M0,0 L8,4 L0,8 z" fill="{BLUE}"/></marker></defs>',
        f'<rect {size} rx="8" fill="#ffffff"/>',
    ]
    return "\n".join([*head, *drawing, "</svg>", ""])


def main() -> None:
    """Write the picture into the file that is named, by default docs/pictures/crane.svg."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else OUTPUT
    out.write_text(svg(load_machine("c180_hoses")), "utf-8")


if __name__ == "__main__":
    main()
