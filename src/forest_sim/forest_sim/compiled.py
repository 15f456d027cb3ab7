"""The plant's steps compiled by Numba, for studies and tests that take millions of them.

The laws stay ordinary Python: here, and only here, they are registered with Numba, so that the compiled steps
are made of the very functions that the node interprets. The node does without: the compiler would triple its
memory and its start.

Compiled code is cached on disk under a digest of the laws' sources, because Numba itself does not notice when
a function that another one calls has changed.
"""

import hashlib
import inspect
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

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
)

Advance = Callable[[Simulation, Triple, float, int, PlantParameters], Simulation]


@lru_cache(maxsize=1)
def compiled_advance() -> Advance:
    """Return `integrator.advance`, compiled.

    The first call with arguments takes some seconds; later runs read the cache.

    Raises:
        ModuleNotFoundError: numba is not installed.
    """
    _choose_cache()
    import numba
    from numba.extending import register_jitable

    for module in LAWS:
        for _, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and function is not integrator.advance:
                register_jitable(function)
    compiled: Any = numba.njit(cache=True)(integrator.advance)
    return compiled  # type: ignore[no-any-return]


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
