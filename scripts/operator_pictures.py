#!/usr/bin/env python3
"""Draw what an operator can set as docs/pictures/operator.png: .venv/bin/python scripts/operator_pictures.py.

Every curve comes from the controller's own functions: stick curves, the end damping of a joint, the slow zone
above the ground, and the work area that the shipped walls leave.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from forest_control.config.controller_settings import Settings, parameters
from forest_control.config.profile_file import load_profile
from forest_control.config.workspace_file import load_workspace
from forest_control.limits.velocity_scaling import velocity_scaling
from forest_control.limits.workspace import clearance, slide
from forest_control.operator.operator_profile import curve
from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine

OUTPUT = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "operator.png"
CRANE = load_machine("c180_hoses")
WALLS = load_workspace("c180")
PROFILES = ("exact", "default", "operator", "fine")
BOOM = 1  # its lever
SPEED = 0.5  # [m/s] of the tip
RATE = 0.2  # [rad/s] of the stick towards its end


def stick_curves(axes: Axes) -> None:
    """Draw the part of the speed that the boom's lever asks for."""
    deflections = np.linspace(-1.0, 1.0, 401)
    for name in PROFILES:
        profile = load_profile(name)
        asked = [curve(d, profile["deadzone"][BOOM], profile["expo"][BOOM]) for d in deflections]
        axes.plot(deflections, asked, label=name)
    axes.set(title="stick curves of the profiles", xlabel="deflection", ylabel="part of full speed")


def end_damping(axes: Axes) -> None:
    """Draw what is left of the stick's rate before its end."""
    boom = inverse_kinematics(start_tip(CRANE), CRANE.manipulator.links)[BOOM]
    before = np.linspace(0.0, 0.5, 200)
    for approach in (1.0, 2.0, 4.0):
        p = parameters(CRANE, Settings(approach=(approach, approach, approach)))
        poses = [(0.0, boom, p.velocity_limits.upper[2] - away) for away in before.tolist()]
        left = [velocity_scaling(pose, (0.0, 0.0, RATE), p.velocity_limits).factor for pose in poses]
        axes.plot(np.degrees(before), np.degrees(RATE * np.array(left)), label=f"approach {approach:g} 1/s")
    axes.set(title="end damping of the stick", xlabel="way left to its end, deg", ylabel="rate, deg/s")


def slow_zone(axes: Axes) -> None:
    """Draw what the ground leaves of the speed at which the tip is lowered."""
    low = clearance((6.0, 0.0, 0.0), WALLS.walls[0]).distance
    heights = np.linspace(0.0, 0.6, 200)
    for approach in (1.0, 2.0, 4.0):
        walls = WALLS._replace(approach=approach)
        left = [-slide((6.0, 0.0, height - low), (0.0, 0.0, -SPEED), walls)[2] for height in heights.tolist()]
        axes.plot(heights, left, label=f"approach {approach:g} 1/s")
    axes.set(title="slow zone above the ground", xlabel="height over its margin, m", ylabel="speed down, m/s")


def work_area(axes: Axes) -> None:
    """Draw reach, walls, and the border of the slow zone in the crane's plane."""
    ahead, up = np.meshgrid(np.linspace(-4.0, 10.0, 181), np.linspace(-3.0, 9.0, 156))
    free = np.vectorize(nearest)(ahead, up)
    axes.contourf(ahead, up, np.vectorize(reached)(ahead, up) * (free > 0.0), [0.5, 1.5], colors=["#cfe8cf"])
    axes.contourf(ahead, up, free, [-20.0, 0.0], colors=["#c9c9c9"])
    axes.contour(ahead, up, free, [SPEED / WALLS.approach], colors=["#c62828"], linestyles="dashed")
    axes.set(title="work area; dashed: 0.5 m/s slows from here", xlabel="x, m", ylabel="z, m", aspect="equal")


def nearest(x: float, z: float) -> float:
    """Return the distance of the nearest wall [m], negative within."""
    return min(clearance((x, 0.0, z), wall).distance for wall in WALLS.walls[: WALLS.number])


def reached(x: float, z: float) -> bool:
    """Tell whether the tip can be at a place [m]."""
    try:
        pose_at((x, 0.0, z), CRANE)
    except ValueError:
        return False
    return True


def main(output: Path) -> None:
    """Draw all four."""
    figure, axes = plt.subplots(2, 2, figsize=(10.0, 8.0), layout="constrained")
    for draw, place in zip((stick_curves, end_damping, slow_zone, work_area), axes.flat, strict=True):
        draw(place)
        place.grid(alpha=0.3)
        if place.get_legend_handles_labels()[0]:
            place.legend()
    figure.savefig(output, dpi=90)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else OUTPUT)
