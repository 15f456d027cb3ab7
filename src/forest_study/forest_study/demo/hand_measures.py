"""What a person's hand asked of the tip, from a bag, and how far the tip was from it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.plots.standard_plots import command_stamps, tip_error, travelled
from forest_bag.read.timeseries import Bag
from forest_control.config.controller_settings import Settings, operator_profile
from forest_control.operator.levers import RIGHT_Y, levers_from_axes
from forest_control.operator.operator_profile import Mode, OperatorProfile, rate_mode_velocity, shaped
from forest_control.taught.tip_path import cross_track_distance
from forest_description.types import Floats
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.parameter_table import table_of, typed_values
from forest_study.measures import Deviation, deviation


class HandMeasures(NamedTuple):
    """The measures of a hand's session; None where nothing was drawn (`wished`)."""

    governed: Deviation
    cross_track: Deviation | None
    wish: Deviation | None
    time_lost_s: float


def profile_of(told: Mapping[str, Any]) -> OperatorProfile:
    """Return an operator's profile of the controller's parameters that differ from their defaults."""
    return operator_profile(table_of(Settings, typed_values(Settings()) | dict(told)))


def wished(bag: Bag, profile: OperatorProfile) -> Floats | None:
    """Return where the levers wanted the tip [N, 3] m, at the times of `tip_error`.

    Each sample holds from its stamp to the next one's; while the joystick is not armed nothing is asked for.
    None where levers do not ask for a velocity: in position mode, and where taught work was played.

    Raises:
        NotInBag: the bag lacks a topic that tells.
    """
    taught = bag.name(topics.TAUGHT_COMMAND)
    if profile.mode != Mode.RATE or (taught is not None and bag.topics[taught].count > 0):
        return None
    time, _, moved = tip_error(bag)
    joy, joints = bag.series(topics.JOY), bag.series(topics.JOINT_STATES)
    if joy.values.shape[1] <= RIGHT_Y:
        return None
    stamps = command_stamps(bag)
    newest = np.searchsorted(joy.time_ns, stamps, side="right") - 1
    swing = np.interp(stamps, joints.time_ns, joints.values[:, 0])
    asked = [rate_mode_velocity(shaped(levers_from_axes(tuple(axes)), profile), (angle, 0.0, 0.0), profile)
             for axes, angle in zip(joy.values[newest].tolist(), swing.tolist(), strict=True)]  # fmt: skip
    counts = (newest >= 0) & (_status(bag, "armed", stamps) > 0.0)
    found: Floats = moved[0] + travelled(time, np.where(counts[:, None], asked, 0.0))
    return found


def hand_measures(bag: Bag, profile: OperatorProfile) -> HandMeasures:
    """Return the measures of a session in a tip scheme.

    Raises:
        NotInBag: the bag lacks a topic that tells.
    """
    time, governed, moved = tip_error(bag)
    wish = wished(bag, profile)
    stamps = command_stamps(bag)
    factor, armed = _status(bag, "factor", stamps), _status(bag, "armed", stamps) > 0.0
    lost = np.where(armed, 1.0 - factor, 0.0)[:-1] @ np.diff(time)
    return HandMeasures(
        governed=deviation(np.linalg.norm(moved - governed, axis=1)),
        cross_track=None if wish is None else deviation(cross_track_distance(wish, moved)),
        wish=None if wish is None else deviation(np.linalg.norm(moved - wish, axis=1)),
        time_lost_s=float(lost),
    )


def _status(bag: Bag, label: str, stamps: NDArray[np.int64]) -> Floats:
    """Return what the controller last said of itself at stamps [N] [ns]."""
    status = bag.series(topics.CONTROLLER_STATUS)
    newest = np.searchsorted(status.time_ns, stamps, side="right") - 1
    said: Floats = np.where(newest >= 0, status.column(label)[newest], 0.0)
    return said
