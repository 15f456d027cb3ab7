"""Levers as functions of time: the thesis' test input, and a person's recorded levers."""

import math
from bisect import bisect_right
from pathlib import Path
from typing import Annotated, NamedTuple

from forest_control.operator.joystick_interpolation import LONGEST_LINE, between
from forest_control.operator.levers import BUTTON_COUNT, LEFT_SHOULDER, REST, Levers, levers_for_tip_velocity
from forest_description.types import AXES, Vec3
from forest_msgs_py.interfaces.csv_text import Column, read_rows
from forest_msgs_py.runtime.parameter_table import Parameter

THESIS_DURATION = 10.0  # [s] of the test input: the time axis of Thesis fig. 5.4 to 5.9
LEAD_IN = 0.5  # [s] at rest, deadman held, before a source plays: a recorder may subscribe late
LEAD_OUT = 0.3  # [s] at rest, deadman released, after it; chosen, not measured
LONGEST = 86400.0  # [s] of a source: a day; a longer one has other units
COLUMNS = (Column("time_s", 0.0, LONGEST), *(Column(axis, -1.0, 1.0) for axis in AXES))


class LeverError(ValueError):
    """A lever file is not usable; the message names file, line and what is allowed."""


def thesis_tip_velocity(time: float) -> Vec3:
    """Return the tip velocity command [m/s] of the thesis' evaluation at a time [s]. Thesis section 5.2.

    Steps in x and z at different times and a sinusoid in y; amplitudes as read in
    docs/explanation/equations.md.
    """
    x = 0.30 if 1.0 <= time < 4.0 else 0.0
    z = 0.25 if 2.5 <= time < 5.5 else 0.0
    return x, 0.47 * math.sin(2.0 * math.pi * 1.18 * time), z


def thesis_levers(time: float, tip_speed: float) -> Levers:
    """Return the levers for the thesis' input; a full deflection asks for `tip_speed` [m/s]."""
    return levers_for_tip_velocity(thesis_tip_velocity(time), tip_speed)


class JoystickParameters(NamedTuple):
    """Of `joystick_node`."""

    source: Annotated[
        str, Parameter("thesis, or the path of a CSV of levers or of a bag with a joystick")
    ] = "thesis"
    duration: Annotated[float, Parameter("length to be played; 0: the whole source", "s", 0.0, LONGEST)] = 0.0
    tip_speed: Annotated[float, Parameter("tip speed at full deflection", "m/s", 0.48, 3.0)] = 0.5
    wait_for_subscribers: Annotated[int, Parameter("subscribers to wait for", low=0, high=100)] = 1
    deadman_button: Annotated[
        int, Parameter("button to hold as the deadman", low=0, high=BUTTON_COUNT - 1)
    ] = LEFT_SHOULDER
    faults: Annotated[
        str, Parameter("faults of the link, such as lost from 3 s until 4 s; frozen from 6 s")
    ] = ""
    interpolate: Annotated[
        bool, Parameter("interpolate between the rows of a CSV; false: each row holds")
    ] = True


class LeverRecord(NamedTuple):
    """Rows of a lever file."""

    times: tuple[float, ...]  # [s]
    levers: tuple[Levers, ...]
    interpolated: bool = True  # False: each row holds until the next

    def at(self, time: float) -> Levers:
        """Return the levers at a time [s]; rest before the first row and after the last.

        They go on straight lines from row to row. Before a longer gap, as in a list of steps, a row
        holds until `LONGEST_LINE` before the next.
        """
        row = bisect_right(self.times, time) - 1
        if row < 0 or time > self.times[-1]:
            return REST
        if not self.interpolated or row + 1 == len(self.times):
            return self.levers[row]
        end = self.times[row + 1]
        begun = max(self.times[row], end - LONGEST_LINE)
        return between(self.levers[row], self.levers[row + 1], max(0.0, time - begun) / (end - begun))


def read_levers(path: Path) -> LeverRecord:
    """Read a CSV with the columns time_s, swing, boom, stick; deflections -1..1, times rising.

    Raises:
        LeverError: the file cannot be read, or a line does not fit.
    """
    rows = read_rows(path, COLUMNS, LeverError)
    return LeverRecord(tuple(n[0] for n in rows), tuple(Levers(*n[1:]) for n in rows))
