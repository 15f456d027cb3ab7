"""Who takes part: one module per contestant, imported only in the process that runs it.

A module has `prepare(work, start, tolerance) -> integrate`, where `start` holds the 18 states in SI at t = 0
and `integrate()` returns a `Run`. Compiling belongs to `prepare` or to the first `integrate()`, reading the
input to `prepare`.
"""

import importlib.util
import shutil
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_sim.solver.step_schedule import LONGEST
from work import Work

Floats = NDArray[np.float64]


class Run(NamedTuple):
    """One integration of the whole work."""

    states: Floats  # (samples + 1, 18), SI
    cpu_seconds: float  # of the integration alone


Prepare = Callable[[Work, Floats, float], Callable[[], Run]]


class Contestant(NamedTuple):
    """One row of the table."""

    name: str
    module: str  # in this package
    needs: tuple[str, ...]  # importable packages, or programs with a leading "$"
    tolerance: dict[str, float]  # relative, by mode; absolute for states of order one; ours: the step [s]
    shares: Mapping[str, float] = MappingProxyType({})  # less than all of the work [s], by mode

    def missing(self) -> list[str]:
        """Return what is not installed here."""
        return [need.lstrip("$") for need in self.needs if not _found(need)]


def _found(need: str) -> bool:
    if need.startswith("$"):
        return shutil.which(need[1:]) is not None
    return importlib.util.find_spec(need) is not None


# The loosest tolerances of a 1-2-5 series with which both error limits are met on the shipped input, even if
# a tighter one misses them again. The search: `plant.py --peers NAME --tolerance T`.
CONTESTANTS = {
    "ours": Contestant(
        "forest_sim, SDIRK2 1.67 ms, finer after jumps",
        "ours_paced",
        ("llvmlite",),
        {"open": LONGEST, "held": LONGEST},
    ),
    "ours-even": Contestant(
        "forest_sim, SDIRK2 1 ms", "ours_even", ("llvmlite",), {"open": 1e-3, "held": 1e-3}
    ),
    "numbalsoda": Contestant(
        "numbalsoda", "numbalsoda_lsoda", ("numba", "numbalsoda"), {"open": 5e-6, "held": 1e-5}
    ),
    "casadi": Contestant(
        "CasADi + CVODES, C by gcc", "casadi_cvodes", ("casadi", "$gcc"), {"open": 2e-6, "held": 5e-6}
    ),
    "lsoda-numba": Contestant(
        "scipy LSODA, numba", "scipy_lsoda_numba", ("scipy", "numba"), {"open": 1e-6, "held": 1e-5}
    ),
    "lsoda-numpy": Contestant(
        "scipy LSODA, NumPy", "scipy_lsoda_numpy", ("scipy",), {"open": 5e-6, "held": 1e-5}
    ),
    "bdf-numba": Contestant(
        "scipy BDF, numba", "scipy_bdf_numba", ("scipy", "numba"), {"open": 5e-6, "held": 2e-6}
    ),
    "bdf-numpy": Contestant("scipy BDF, NumPy", "scipy_bdf_numpy", ("scipy",), {"open": 1e-6, "held": 2e-6}),
    "octave": Contestant(
        "Octave ode15s", "octave_ode15s", ("$octave-cli",), {"open": 2e-6, "held": 1e-4}, {"held": 2.0}
    ),
}
