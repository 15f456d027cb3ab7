"""The work that every contestant does: 20 s of one input, from rest, as `c180_thesis`.

The input file lists pieces of V(t) = mean + amplitude sin(2 pi f (t - start) + phase), one per row and axis;
between pieces the voltage is zero. An amplitude of zero is a step, half a period from 90 degrees a smooth
return, the rest are sinusoids. Valves open by steps, too, but close smoothly: a step that shuts a valve on a
flow has no finite derivative, and only ours could take it.

Two modes: `open` follows the formula, `held` samples it every 5 ms and holds the command until the next one.

| symbol | name | unit |
|---|---|---|
| V | valve voltage | V |
| w | a segment's wave: mean, amplitude, angular frequency, phase at t = 0, for each axis | V, V, rad/s, rad |
"""

import csv
import hashlib
import itertools
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_description.types import AXES

Floats = NDArray[np.float64]

INPUT = Path(__file__).parent / "inputs" / "steps_returns_sines.csv"
SAMPLE = 0.005  # [s] between states that are compared, and between held commands
SECONDS = 20.0
START = (0.0, math.radians(20.0), math.radians(-90.0))  # joint angles [rad]
MODES = ("open", "held")
ERROR_RAD, ERROR_MPA = 1e-5, 0.04  # what "equal accuracy" means


class Segment(NamedTuple):
    """A stretch of time in which all three voltages are smooth."""

    first: int  # samples
    last: int
    wave: Floats  # (12,): mean, amplitude, angular frequency, phase of swing, boom, stick


class Work(NamedTuple):
    """What is to be integrated; states are compared at `SAMPLE` times 0 ... samples."""

    mode: str
    samples: int
    segments: list[Segment]

    @property
    def seconds(self) -> float:
        """Length in simulated time [s]."""
        return self.samples * SAMPLE


class Piece(NamedTuple):
    """One row of the input file."""

    axis: str
    start: float
    end: float
    mean: float
    amplitude: float
    frequency: float
    phase: float


def read_pieces(path: Path = INPUT) -> list[Piece]:
    """Return the input file's rows; angles in rad, frequencies in rad/s."""
    with path.open(newline="") as file:
        rows = [(row["axis"], *(float(v) for v in list(row.values())[1:])) for row in csv.DictReader(file)]
    return [
        Piece(axis, start, end, mean, amplitude, math.tau * f, math.radians(phase))
        for axis, start, end, mean, amplitude, f, phase in rows
    ]


def open_loop(seconds: float = SECONDS) -> Work:
    """Return the work with voltages that follow the input's formula; segments end where a piece does."""
    pieces, samples = read_pieces(), round(seconds / SAMPLE)
    ends = {round(t / SAMPLE) for piece in pieces for t in (piece.start, piece.end)}
    breaks = sorted({0, samples} | {k for k in ends if k < samples})
    return Work(
        "open",
        samples,
        [Segment(a, b, _wave(pieces, 0.5 * (a + b) * SAMPLE)) for a, b in itertools.pairwise(breaks)],
    )


def held(seconds: float = SECONDS) -> Work:
    """Return the work with voltages sampled from the formula every 5 ms; each command is a segment."""
    commands = held_commands(open_loop(seconds))
    waves = np.zeros((len(commands), 3, 4))
    waves[:, :, 0] = commands
    return Work("held", len(commands), [Segment(k, k + 1, w.ravel()) for k, w in enumerate(waves)])


def make(mode: str, seconds: float = SECONDS) -> Work:
    """Return the work of a mode."""
    return {"open": open_loop, "held": held}[mode](seconds)


def held_commands(work: Work) -> Floats:
    """Return the voltage [V] at the start of every sample interval, shape (samples, 3)."""
    return _voltages_at(work, 0.0)


def step_voltages(work: Work, per_sample: int) -> Floats:
    """Return the voltage [V] in the middle of every one of `per_sample` equal steps a sample, (steps, 3)."""
    fractions = (np.arange(per_sample) + 0.5) / per_sample
    return np.stack([_voltages_at(work, f) for f in fractions], axis=1).reshape(-1, 3)


def _voltages_at(work: Work, fraction: float) -> Floats:
    blocks = [voltages((np.arange(s.first, s.last) + fraction) * SAMPLE, s.wave) for s in work.segments]
    return np.concatenate(blocks)


def voltages(time: Floats, wave: Floats) -> Floats:
    """Return V = mean + amplitude sin(omega t + phase) [V], shape (times, 3)."""
    mean, amplitude, omega, phase = wave.reshape(3, 4).T
    return mean + amplitude * np.sin(np.multiply.outer(time, omega) + phase)


def digest(work: Work) -> str:
    """Return a name for this work that changes with everything in it."""
    sums = hashlib.sha256(f"{work.mode} {SAMPLE} {START}".encode())
    for segment in work.segments:
        sums.update(f"{segment.first} {segment.last}".encode() + segment.wave.tobytes())
    return sums.hexdigest()[:16]


def _wave(pieces: list[Piece], time: float) -> Floats:
    """Return the wave of all axes around a time [s]; phases are counted from t = 0."""
    wave = np.zeros((3, 4))
    for piece in pieces:
        if piece.start < time < piece.end:
            phase = piece.phase - piece.frequency * piece.start
            wave[AXES.index(piece.axis)] = piece.mean, piece.amplitude, piece.frequency, phase
    return wave.ravel()
