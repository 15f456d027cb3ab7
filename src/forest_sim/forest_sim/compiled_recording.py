"""`recording.record` compiled: steps, energies and rows in one loop, where `compiled` has the steps alone.

Numba keeps the laws as functions of their own here and caches the result under a digest of their sources,
because it does not notice by itself when a function that another one calls has changed.
"""

import hashlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from forest_sim import power, recording
from forest_sim.compiled import LAWS
from forest_sim.integrator import Simulation, advance
from forest_sim.parameters import PlantParameters

Floats = NDArray[np.float64]
Record = Callable[[Simulation, Floats, float, PlantParameters, Floats, Floats], Simulation]


def have_compiler() -> bool:
    """Tell whether numba is installed."""
    return importlib.util.find_spec("numba") is not None


def fastest_record() -> Record:
    """Return `recording.record`, compiled if numba is installed, else as it is: a hundred times slower."""
    return compiled_record() if have_compiler() else recording.record


@lru_cache(maxsize=1)
def compiled_record() -> Record:
    """Return `recording.record`, compiled; the first call takes some seconds, later runs read the cache.

    Raises:
        ModuleNotFoundError: numba is not installed.
    """
    modules = (*LAWS, power, recording)
    _choose_cache(modules)
    import numba
    from numba.extending import register_jitable

    for module in modules:
        for _, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and function not in (advance, recording.record):
                register_jitable(error_model="numpy")(function)
    compiled: Any = numba.njit(cache=True, error_model="numpy")(recording.record)
    return compiled  # type: ignore[no-any-return]


def _choose_cache(modules: tuple[Any, ...]) -> None:
    """Point Numba at a cache of our own unless the user has chosen one."""
    digest = hashlib.sha256(sys.version.encode())
    for module in (*modules, sys.modules[__name__]):
        digest.update(Path(str(module.__file__)).read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    os.environ.setdefault("NUMBA_CACHE_DIR", str(home / "forest_sim" / digest.hexdigest()[:16]))
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]
