"""The plant's steps compiled by Numba, for studies and tests that take millions of them.

The laws stay ordinary Python: here, and only here, they are registered with Numba, so that the compiled steps
are made of the very functions that the node interprets. The node does without: the compiler would triple its
memory and its start.

Compiled code is cached on disk under a digest of the laws' sources, because Numba itself does not notice when
a function that another one calls has changed.
"""

import hashlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from forest_description import linkage, valve
from forest_sim import (
    actuator,
    end_stop,
    friction,
    integrator,
    line,
    manipulator,
    mechanics,
    pendulum,
    plant,
    power,
    recording,
    spool,
    supply,
)
from forest_sim.integrator import Simulation
from forest_sim.manipulator import Triple
from forest_sim.parameters import PlantParameters

LAWS: tuple[ModuleType, ...] = (
    linkage,
    valve,
    spool,
    supply,
    actuator,
    friction,
    end_stop,
    line,
    manipulator,
    pendulum,
    mechanics,
    plant,
    integrator,
    power,
    recording,
)
ENTRIES = (integrator.advance, recording.record)  # compiled as such; everything else into them

Advance = Callable[[Simulation, Triple, float, int, PlantParameters], Simulation]
Floats = NDArray[np.float64]
Record = Callable[[Simulation, Floats, float, PlantParameters, Floats, Floats], Simulation]


@lru_cache(maxsize=1)
def compiled_advance() -> Advance:
    """Return `integrator.advance`, compiled.

    The first call with arguments takes some seconds; later runs read the cache.

    Raises:
        ModuleNotFoundError: numba is not installed.
    """
    return _compiled(integrator.advance)  # type: ignore[no-any-return]


@lru_cache(maxsize=1)
def compiled_record() -> Record:
    """Return `recording.record`, compiled.

    Raises:
        ModuleNotFoundError: numba is not installed.
    """
    return _compiled(recording.record)  # type: ignore[no-any-return]


def have_compiler() -> bool:
    """Tell whether numba is installed."""
    return importlib.util.find_spec("numba") is not None


def fastest_record() -> Record:
    """Return `recording.record`, compiled if numba is installed, else as it is: a thousand times slower."""
    return compiled_record() if have_compiler() else recording.record


def _compiled(entry: Callable[..., Any]) -> Any:
    _register_laws()
    import numba

    return numba.njit(cache=True)(entry)


@lru_cache(maxsize=1)
def _register_laws() -> None:
    """Have Numba compile every function of the laws into whatever calls it."""
    _choose_cache()
    from numba.extending import register_jitable

    for module in LAWS:
        for _, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and function not in ENTRIES:
                register_jitable(function)


def _choose_cache() -> None:
    """Point Numba at a cache of our own unless the user has chosen one."""
    digest = hashlib.sha256(sys.version.encode())
    for module in LAWS:
        digest.update(Path(str(module.__file__)).read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    os.environ.setdefault("NUMBA_CACHE_DIR", str(home / "forest_sim" / digest.hexdigest()[:16]))
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]
