"""The actuator's simulation as machine code where llvmlite is installed, interpreted where it is not.

Two minutes of fitting are some hundred thousand simulations: compiled, one takes a millisecond; interpreted,
a third of a second.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from forest_compile import flat_layout
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel, can_compile
from forest_description.types import Floats
from forest_ident.actuator import steps
from forest_ident.actuator.model import Parameters
from forest_ident.actuator.steps import SUBSTEPS

BEYOND = 100.0  # pressure and position of a simulation that diverged
_TEXT = """
def kernel(signal, rows, substeps, parameters, pressures, positions, filled):
    filled[0] = run(signal, rows, substeps, p, pressures, positions)
"""
_LETTERS = "piipppp"


def delayed(signal: Floats, dead_time: float, substeps: int = SUBSTEPS) -> Floats:
    """Return a signal [V] that a dead time [n] later is straight between samples, one value to a substep."""
    count = len(signal)
    times = np.arange(substeps * count + 1) / substeps - dead_time
    return np.interp(times, np.arange(count), signal)


def simulate(
    signal: Floats, dead_time: float, p: Parameters, rows: int | None = None
) -> tuple[Floats, Floats]:
    """Return pressures [P] and positions [X] at every sample, freely from the signal [V], from rest.

    Args:
        signal: the valve's, one value to a sample.
        dead_time: before the spool hears of it [n].
        p: the actuator.
        rows: samples wanted; default: all.
    """
    count = len(signal) if rows is None else rows
    pressures, positions = np.full(count, BEYOND), np.full(count, BEYOND)
    _runner()(delayed(signal[:count], dead_time), count, p, pressures, positions)
    return pressures, positions


@lru_cache(maxsize=1)
def _runner() -> Callable[[Floats, int, Parameters, Floats, Floats], None]:
    return _compiled() if can_compile() else _interpreted


def _interpreted(signal: Floats, count: int, p: Parameters, pressures: Floats, positions: Floats) -> None:
    try:
        steps.run(signal.tolist(), count, SUBSTEPS, p, pressures, positions)  # type: ignore[arg-type]
    except (OverflowError, ZeroDivisionError):
        return  # ran away within one sample


def _compiled() -> Callable[[Floats, int, Parameters, Floats, Floats], None]:
    kernel, pack = KERNEL.kernel(), flat_layout.packer(_EXAMPLE)

    def run(signal: Floats, count: int, p: Parameters, pressures: Floats, positions: Floats) -> None:
        row, filled = np.array(pack(p)), np.empty(1)
        columns = (signal, row, pressures, positions, filled)
        at = [column.ctypes.data for column in columns]
        kernel(at[0], count, SUBSTEPS, *at[1:])

    return run


_EXAMPLE = Parameters(*(1.0 for _ in Parameters._fields))
_ENTRY = Entry(
    text=_TEXT,
    names={"run": steps.run},
    arguments=_LETTERS,
    tuples={"p": ("parameters", _EXAMPLE)},
)
KERNEL = CachedKernel("actuator", lambda: _ENTRY)
"""The actuator's simulation as machine code."""
