"""Where logs, bunk, ground and wheels are about the crane.

All sizes are those of a forwarder of 15 t, whose crane reaches 8 m, and are scaled by the machine's reach;
masses by its third power. Every number is assumed, from the usual sizes of the class: no maker's drawing.

Frame as in `kinematics`: origin on the swing axis at the height of the boom's pivot, x over the bunk, y left,
z up.
"""

import dataclasses
import math
from typing import NamedTuple

from forest_description.derived.bodies import with_log
from forest_description.derived.limits import pose_at, workspace_limits
from forest_description.machine import Machine
from forest_description.mechanics.chassis import Chassis
from forest_description.types import Vec3
from forest_study.results import StudyError

REACH = 8.0  # [m] of the crane that the sizes below belong to
PIVOT = 3.0  # [m] height of the boom's pivot above the ground
FLOOR = 1.2  # [m] height of the bunk's floor above the ground
STAKES = 1.2  # [m] height of the stakes above the floor
STAKE_ROWS = (3.8, 6.6)  # [m] ahead of the swing axis
HALF_WIDTH = 1.25  # [m] of the bunk, to the stakes' middle
STAKE_RADIUS = 0.06  # [m]
VEHICLE = Chassis(15000.0, 0.5, 1.2, PIVOT, 4.5, 2.5, 1.35)  # under a machine whose file tells none
LOG_MASS, LOG_LENGTH, LOG_RADIUS = 150.0, 4.0, 0.12  # [kg], [m], [m]: spruce of 0.83 t/m3, fresh
CLEAR = 0.3  # [m] between a carried log and the stakes' ends, as the task's ways have it
NEAR = 0.15  # [m] from a log's middle at which the grapple takes it; and of a place at which it is laid
# A log's middle: azimuth [deg], distance from the swing axis [m]; on the ground, and across the bunk [m].
GROUND = {"red": (70.0, 6.0), "blue": (95.0, 5.4)}
BUNK = {"red": (5.2, 0.45), "blue": (5.2, -0.45)}


class Site(NamedTuple):
    """The place of work; lengths in m."""

    scale: float  # [1]
    ground: float  # z
    floor: float  # z of the bunk's
    stake_top: float  # z
    stakes: tuple[Vec3, ...]  # their feet, at the floor
    stake_radius: float
    chassis: Chassis
    log_mass: float  # [kg]
    log_length: float
    log_radius: float
    hang: float  # from the tip down to a log's middle in the grapple
    near: float
    clear: float  # z of a grapple's grip that passes over the stakes
    places: dict[str, Vec3]  # of the grip at a log's middle: "red on the ground", "red in the bunk", ...


def site_of(machine: Machine) -> Site:
    """Return the place of work of a machine.

    Raises:
        StudyError: the machine does not reach one of the places.
    """
    s = workspace_limits(machine).reach_max / REACH
    radius = LOG_RADIUS * s
    log = with_log(machine.manipulator, 1.0, 1.0).log
    assert log is not None
    ground, floor = -PIVOT * s, (FLOOR - PIVOT) * s
    places: dict[str, Vec3] = {}
    for name in GROUND:
        turn, away = math.radians(GROUND[name][0]), GROUND[name][1] * s
        places[f"{name} on the ground"] = (away * math.cos(turn), away * math.sin(turn), ground + radius)
        places[f"{name} in the bunk"] = (BUNK[name][0] * s, BUNK[name][1] * s, floor + radius)
    site = Site(
        scale=s,
        ground=ground,
        floor=floor,
        stake_top=floor + STAKES * s,
        stakes=tuple((x * s, side * HALF_WIDTH * s, floor) for x in STAKE_ROWS for side in (1.0, -1.0)),
        stake_radius=STAKE_RADIUS * s,
        chassis=machine.chassis or _chassis(s),
        log_mass=LOG_MASS * s**3,
        log_length=LOG_LENGTH * s,
        log_radius=radius,
        hang=log.x if machine.manipulator.pendulum is not None else 0.0,
        near=NEAR * s,
        clear=floor + STAKES * s + radius + CLEAR * s,
        places=places,
    )
    _require_reach(machine, site)
    return site


def _chassis(s: float) -> Chassis:
    """Return the usual vehicle under a crane of a scale."""
    scaled = {name: s * size for name, size in dataclasses.asdict(VEHICLE).items()}
    return Chassis(**scaled | {"mass": s**3 * VEHICLE.mass})


def _require_reach(machine: Machine, site: Site) -> None:
    for name, (x, y, z) in site.places.items():
        try:
            for height in (z, site.clear):
                pose_at((x, y, height + site.hang), machine)
        except ValueError as error:  # noqa: PERF203  eight poses
            raise StudyError(f"logs: {machine.name} does not reach the log {name}: {error}") from error
