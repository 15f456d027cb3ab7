"""A hand on the levers that never was: movements with the shape, the rests and the tremor of a person's.

Each lever goes from one deflection to the next along a minimum-jerk path, rests, and goes on, independently
of the others; on top lies a tremor, and the stick has the steps of an 8-bit converter. Seeded: the same seed
is the same hand.

| symbol | name | unit |
|---|---|---|
| s(u) = 10 u³ − 15 u⁴ + 6 u⁵ | part of a movement done at the part u of its time | 1 |
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from forest_description.types import Floats

RATE = 50.0  # [Hz]
MOVEMENT = 0.35, 0.9  # [s] shortest and longest
REST = 0.0, 0.5  # [s]
REACH = 0.8  # of full deflection
TREMOR, TREMOR_RATE = 0.008, 9.0  # of full deflection; [Hz]
STEPS = 127  # of the converter, on each side
AT_REST = 0.3, 0.5  # [s] centred before the first movement, at least, and after the last
HEADER = "time_s,swing,boom,stick"


def hand_levers(seed: int, duration: float) -> tuple[Floats, Floats]:
    """Return times [s], of shape [N], and deflections [N, 3] of so many seconds."""
    generator = np.random.default_rng(seed)
    times = np.arange(0.0, duration + 0.5 / RATE, 1.0 / RATE)
    return times, np.column_stack([_lever(generator, times) for _ in range(3)])


def _lever(generator: np.random.Generator, times: Floats) -> Floats:
    knots, levels = [0.0, AT_REST[0] + generator.uniform(*REST)], [0.0, 0.0]
    end = times[-1] - AT_REST[1]
    while knots[-1] + MOVEMENT[1] + REST[1] + MOVEMENT[0] <= end:
        level = generator.uniform(-REACH, REACH) if generator.random() > 0.3 else 0.0
        moved = knots[-1] + generator.uniform(*MOVEMENT)
        knots += [moved, moved + generator.uniform(*REST)]
        levels += [level, level]
    knots, levels = [*knots, knots[-1] + min(MOVEMENT[1], end - knots[-1])], [*levels, 0.0]
    shaped = _minimum_jerk(times, np.array(knots), np.array(levels))
    tremor = TREMOR * np.sin(2.0 * np.pi * (TREMOR_RATE * times + generator.random()))
    held = np.where(shaped == 0.0, 0.0, shaped + tremor)
    return np.round(np.clip(held, -1.0, 1.0) * STEPS) / STEPS


def _minimum_jerk(times: Floats, knots: Floats, levels: Floats) -> Floats:
    """Return the path through the levels [K] at the knots [K] [s]; the last level holds."""
    place = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    u = np.clip((times - knots[place]) / (knots[place + 1] - knots[place]), 0.0, 1.0)
    path: Floats = (
        levels[place] + (levels[place + 1] - levels[place]) * (10.0 - 15.0 * u + 6.0 * u * u) * u**3
    )
    return path


def valve_ramps(peak: float, rise: float) -> tuple[Floats, Floats]:
    """Return times [N] s and commands [N, 3] V: each axis slowly to +peak, to -peak and back."""
    times = np.arange(0.0, 12.0 * rise + 0.5 / RATE, 1.0 / RATE)
    knots = np.arange(0.0, 13.0) * rise
    ramps = [
        np.interp(times, knots[4 * axis : 4 * axis + 5], [0.0, peak, 0.0, -peak, 0.0]) for axis in range(3)
    ]
    return times, np.column_stack(ramps)


def write_csv(path: Path, header: str, times: Floats, values: Floats) -> None:
    """Write a lever or voltage file."""
    rows: Sequence[Sequence[float]] = np.column_stack([times, values]).tolist()
    lines = [header, *(",".join(f"{value:.6g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
