"""Valve voltages as functions of time: for runs of the machine alone, without a driver in front of it.

A voltage acts from the first step of the integrator at or after its time, and is held over the
step.

| name | what it does |
|---|---|
| step | swing, boom, stick in turn: +A, rest, -A, rest, 1 s each but the rests, which are half as long |
| chirp | swing, boom, stick in turn, a third of the duration each: a sinusoid with growing frequency |
| thesis | swing, then stick: a lever pulled, held and let go to one side and to the other |
| FILE.csv | columns time, swing, boom, stick; each row holds until the next one's time, the last to the end |
"""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from forest_description.types import AXES, ZERO, Floats
from forest_msgs_py.interfaces.csv_text import Column, read_rows

NAMES = ("step", "chirp", "thesis")
LONGEST = 86400.0  # [s] the latest time of a file
GREATEST = 100.0  # [V] beyond any amplifier: a number in other units
COLUMNS = (
    Column("time", 0.0, LONGEST, "s"),
    *(Column(axis, -GREATEST, GREATEST, "V") for axis in AXES),
)
LEAD_IN = 0.5  # [s] at rest before the built-in inputs
HOLD, REST = 1.0, 0.5  # [s] of `step`
ROUNDING = 1e-9  # [s] of a time that is a multiple of the step
PULL, HELD, PAUSE = 0.3, 1.2, 0.45  # [s] of `thesis`: a lever is pulled, held and let go; between two pulls


class InputError(ValueError):
    """A voltage input is not usable; the message names file, line and what is allowed."""


class Voltages(NamedTuple):
    """An input: its name, the voltages at given times, and how long it is by itself."""

    name: str
    at: Callable[[Floats], Floats]  # times [N] s to voltages [N, 3] V
    duration: float  # [s]


def _held(times: Floats, levels: Floats, wanted: Floats) -> Floats:
    """Return rows that hold from their time to the next one's; zero before the first.

    Args:
        times: of the rows [s], shape (N,), rising.
        levels: voltages [V], shape (N, 3).
        wanted: times [s], shape (M,).
    """
    # A step's time is a multiple of the step and carries its rounding.
    row = np.searchsorted(times, wanted + ROUNDING, side="right") - 1
    return np.where((row >= 0)[:, np.newaxis], levels[np.maximum(row, 0)], 0.0)


def _ramps(times: Floats, levels: Floats, wanted: Floats) -> Floats:
    """Return straight lines from row to row; arguments as `_held`."""
    return np.column_stack([np.interp(wanted, times, column) for column in levels.T])


def _sweep(amplitude: float, lowest: float, growth: float, turn: float, wanted: Floats) -> Floats:
    """Return the law of `chirp`.

    Args:
        amplitude: A [V].
        lowest: f_1 [Hz].
        growth: ln k.
        turn: T [s].
        wanted: times [s], shape (M,).
    """
    axis = np.floor((wanted + ROUNDING) / turn)
    local = wanted - axis * turn
    whole = 2.0 * math.pi * lowest * turn / growth
    wave = -amplitude * np.sin(whole * np.expm1(growth * local / turn))
    return np.where(axis[:, np.newaxis] == np.arange(len(AXES)), wave[:, np.newaxis], 0.0)


def steps(amplitude: float = 4.0) -> Voltages:
    """Return steps of one axis after the other [V], both directions, with rests for the crane to ring out."""
    pattern = ((HOLD, amplitude), (REST, 0.0), (HOLD, -amplitude), (REST, 0.0))
    edges, levels = [0.0, LEAD_IN], [list(ZERO)]
    for axis in range(len(AXES)):
        for length, voltage in pattern:
            edges.append(edges[-1] + length)
            levels.append(_on_axis(axis, voltage))
    return Voltages("step", partial(_held, np.array(edges[:-1]), np.array(levels)), edges[-1])


def chirp(
    amplitude: float = 4.0, lowest: float = 0.1, highest: float = 5.0, duration: float = 60.0
) -> Voltages:
    """Return a swept sinusoid for each axis in turn.

    -A sin(2 pi f_1 T/ln k (k^(t/T) - 1)) with k = f_2/f_1 over T = duration/3: f grows
    geometrically. The first and longest wave goes to the negative side, where the usual start has
    more room.

    Args:
        amplitude: A [V].
        lowest: f_1 [Hz].
        highest: f_2 [Hz], above f_1.
        duration: of all three [s].

    Raises:
        InputError: the frequencies do not rise.
    """
    if not 0.0 < lowest < highest:
        raise InputError(f"chirp from {lowest:g} to {highest:g} Hz; allowed: 0 < from < to")
    growth = math.log(highest / lowest)
    return Voltages("chirp", partial(_sweep, amplitude, lowest, growth, duration / 3.0), duration)


def thesis(amplitude: float = 5.0) -> Voltages:
    """Return the input of the model validation: the swing, then the stick, each to one side and the other.

    Thesis section 4.4. Differs: its figures are lost; these are a person's pulls of a lever, A V
    high, with ramps that a hand makes. The boom, which the thesis does not show, stands still.
    """
    corners = [(0.0, list(ZERO)), (LEAD_IN, list(ZERO))]
    for axis in (0, 2):
        for voltage in (amplitude, -amplitude):
            for length, level in ((PULL, voltage), (HELD, voltage), (PULL, 0.0), (PAUSE, 0.0)):
                corners.append((corners[-1][0] + length, _on_axis(axis, level)))
    times, levels = np.array([c[0] for c in corners]), np.array([c[1] for c in corners])
    return Voltages("thesis", partial(_ramps, times, levels), float(times[-1]))


def _on_axis(axis: int, voltage: float) -> list[float]:
    return [voltage if place == axis else 0.0 for place in range(len(AXES))]


def read_voltages(path: Path) -> Voltages:
    """Read a CSV with columns time [s], swing, boom, stick [V]; times rise, each row holds until the next.

    Before the first row the voltages are zero; the last row holds to the end of the run.

    Raises:
        InputError: the file cannot be read, or a line does not fit.
    """
    table = np.array(read_rows(path, COLUMNS, InputError))
    return Voltages(path.name, partial(_held, table[:, 0], table[:, 1:]), float(table[-1, 0]))
