"""What the page shows of a cycle of taught work: its segments in words, and the way of the tip as a line."""

import math
from typing import TypedDict

from forest_control.config.controller_settings import Settings, parameters
from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace
from forest_control.taught.cycle import CONFIRMATION, Cycle, Grapple, Path, Segment
from forest_control.taught.plan import Leg, Step, assumed_start, planned
from forest_control.taught.tip_path import PathError
from forest_description.machine import Machine
from forest_description.types import Vec3

MOST = 1500  # [1] points of a line: the page keeps room for 2048
SPACING = 0.02  # [m] between them, at the least: finer than a line on the screen shows


class DrawnSegment(TypedDict):
    """A segment: what can be set of it, and what it is in words."""

    name: str
    kind: str  # pose, path or grapple
    speed: float | None  # [m/s]
    wait: float | None  # [s] of a grapple; 0: until a person confirms
    text: str
    end: list[float] | None  # where the tip is then [m]


class DrawnCycle(TypedDict):
    """A cycle."""

    name: str
    description: str
    segments: list[DrawnSegment]
    line: list[list[float]]  # where the tip goes from its first place on [m]
    trouble: str  # why it cannot be played, a sentence; "" for nothing


def drawn_cycle(taught: Cycle, machine: Machine, walls: str) -> DrawnCycle:
    """Return what is shown of a cycle.

    Args:
        taught: the cycle.
        machine: that shall do it.
        walls: name or file of the workspace that it keeps to.
    """
    steps, trouble = _planned(taught, machine, walls)
    return DrawnCycle(
        name=taught.name,
        description=taught.description,
        segments=[_segment(number, one, steps) for number, one in enumerate(taught.segments, start=1)],
        line=_line(taught, steps),
        trouble=trouble,
    )


def _planned(taught: Cycle, machine: Machine, walls: str) -> tuple[tuple[Step, ...], str]:
    """Return the steps of a cycle, or why there are none."""
    try:
        p = parameters(machine, Settings(), load_workspace(walls))
        return planned(taught, assumed_start(taught, machine), p), ""
    except (PathError, SettingFileError) as error:
        text = str(error)
        return (), f"{text[:1].upper()}{text[1:]}."


def _segment(number: int, segment: Segment, steps: tuple[Step, ...]) -> DrawnSegment:
    if isinstance(segment, Grapple):
        wait = "until confirmed" if segment.wait == CONFIRMATION else f"{segment.wait:g} s"
        text = f"grapple {segment.action}, {wait}"
        return DrawnSegment(
            name=segment.name, kind="grapple", speed=None, wait=segment.wait, text=text, end=None
        )
    legs = [step for step in steps if isinstance(step, Leg) and step.number == number]
    length, time = sum(leg.path.length for leg in legs), sum(leg.duration for leg in legs)
    kind, end = ("path", segment.points[-1]) if isinstance(segment, Path) else ("pose", segment.tip)
    text = f"{length:.2f} m, {math.ceil(time)} s" if legs else ""
    return DrawnSegment(
        name=segment.name, kind=kind, speed=segment.speed, wait=None, text=text, end=list(end)
    )


def _line(taught: Cycle, steps: tuple[Step, ...]) -> list[list[float]]:
    """Return points of the way of the tip, from the end of a first pose on: where it comes from is open."""
    moving = [(number, one) for number, one in enumerate(taught.segments, 1) if not isinstance(one, Grapple)]
    begins = [number for number, one in moving[:1] if not isinstance(one, Path)]
    legs = [step for step in steps if isinstance(step, Leg) and step.number not in begins]
    spacing = max(SPACING, sum(leg.path.length for leg in legs) / MOST)
    return [list(place) for leg in legs for place in _places(leg, spacing)]


def _places(leg: Leg, spacing: float) -> list[Vec3]:
    count = math.ceil(leg.path.length / spacing)
    return [leg.path.at(leg.path.length * k / count) for k in range(count + 1)]
