"""A machine at many temperatures of its oil, as a fit asks for them: between a few made anew.

A record of a warming crane is simulated with another plant every second, some hundred times in a fit. All
that the oil changes is smooth in its temperature; so plants are made at multiples of `GRID` and what lies
between two of them is read off the straight line. The viscosity, which bends the most, is then right to 2e-6.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from forest_compile import flat_layout
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_sim.solver.oil_temperature import parameters_at
from forest_sim.solver.plant_parameters import PlantParameters

GRID = 0.1  # [K]


def plants_at(machine: Machine, temperatures: Sequence[float]) -> list[PlantParameters]:
    """Return the kernel's parameters of a machine at several temperatures [K] of its oil."""
    places = [temperature / GRID for temperature in temperatures]
    below = [int(np.floor(place)) for place in places]
    made = {k: parameters_at(machine, k * GRID) for k in {*below, *(k + 1 for k in below)}}
    pack, unpack = _layout()
    rows = {k: np.array(pack(p), dtype=np.float64) for k, p in made.items()}
    between = (_mixed(rows[k], rows[k + 1], place - k) for k, place in zip(below, places, strict=True))
    return [unpack(row.tolist()) for row in between]


def _mixed(low: Floats, high: Floats, share: float) -> Floats:
    # Infinite ones, and whole numbers, stay as they are.
    apart = np.subtract(high, low, out=np.zeros(len(low)), where=low != high)
    return np.asarray(low + share * apart, dtype=np.float64)


@lru_cache(maxsize=1)
def _layout() -> tuple[Callable[[Any], flat_layout.Row], Callable[[Any], PlantParameters]]:
    from forest_description.machine import load_machine

    example = parameters_at(load_machine("c180"), 313.15)
    return flat_layout.packer(example), flat_layout.unpacker(example)
