"""A log that is grasped and dropped while the tip is held: what that moves, against what shut valves give."""

import numpy as np

from forest_description.derived.limits import pose_at
from forest_description.machine import Machine
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.types import Floats
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.simulation.load_schedule import Load, loaded
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.matrix.figures import Figures
from forest_study.tracking.tracking import Course

GRASPED, DROPPED, ENDED = 400, 2400, 4800  # [periods] 2, 12 and 24 s
NEAR = 0.005  # [m] of where the tip was before, within which it is back


def grasped_and_dropped(
    course: Course,
    machine: Machine,
    suite: Suite,
    adapt: bool,
    plant: PlantParameters,
    crane: Manipulator,
    mass: float,
) -> Figures:
    """Return the figures of a tip that is held where a course starts.

    Cross-track and governed: distance from where it was at first. Overshoot: how much further it goes from
    where it was before grasp or drop than with shut valves. Time lost: until it stays within `NEAR`.

    Args:
        course: for start and settings.
        machine: what controller and driver believe.
        suite: sensors.
        adapt: the driver learns its valves.
        plant: what is simulated.
        crane: that the plant's parameters are of.
        mass: of the log [kg].
    """
    loads = {GRASPED: loaded(plant, crane, Load(mass)), DROPPED: plant}
    drive = course.drive._replace(adapt=adapt)
    runs = []
    for held in (1.0, 0.0):
        rows = np.tile([0.0, 0.0, 0.0, held], (ENDED, 1))
        start = pose_at(course.start, machine)
        given = (machine, rows, start, course.settings, drive, course.model, suite, plant)
        runs.append(compiled_loop.prepared(*given).run(loads))
    ours, shut = runs
    away: Floats = 1e3 * np.linalg.norm(ours.tip - ours.tip[GRASPED], axis=1)[GRASPED:]
    back = max(_back(away[: DROPPED - GRASPED] / 1e3), _back(away[DROPPED - GRASPED :] / 1e3))  # [s]
    volts = np.abs(np.diff(ours.voltages[GRASPED:], axis=0)) / PERIOD
    return Figures(
        cross_track_rms_mm=float(np.sqrt(np.mean(away**2))),
        cross_track_max_mm=float(away.max()),
        governed_rms_mm=float(np.sqrt(np.mean(away**2))),
        governed_max_mm=float(away.max()),
        wish_rms_mm=float(np.sqrt(np.mean(away**2))),
        wish_max_mm=float(away.max()),
        wish_over_bound=0.0,
        waited_s=0.0,
        time_lost_s=back,
        velocity_rms=float(np.sqrt(np.mean(np.sum(np.gradient(ours.tip, PERIOD, axis=0) ** 2, axis=1)))),
        end_mm=float(away[-1]),
        overshoot_mm=max(0.0, 1e3 * max(_peak(ours, k) - _peak(shut, k) for k in (GRASPED, DROPPED))),
        activity=float(volts.mean(axis=0).max()),
    )


def _peak(moved: Trajectory, row: int) -> float:
    """Return how far the tip goes from where it is in a row, before the next change [m]."""
    end = DROPPED if row == GRASPED else ENDED
    return float(np.linalg.norm(moved.tip[row:end] - moved.tip[row], axis=1).max())


def _back(away: Floats) -> float:
    """Return the time [s] after which a tip stays within `NEAR`; all of it, if it does not."""
    beyond = np.flatnonzero(away > NEAR)
    return PERIOD * (int(beyond[-1]) + 1) if len(beyond) else 0.0
