"""The plant's steps as machine code, for studies that take millions of them and for the node.

The laws stay ordinary Python; here, and only here, they are handed to a compiler. Compiled and interpreted
steps agree to the last bit. The object is kept in a cache under a digest of the laws' sources; making it
takes some seconds and Numba (`python -m forest_sim.compiled`), loading it milliseconds and LLVM alone.
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

import numpy as np

from forest_description import linkage, valve
from forest_description.machine import load_machine
from forest_sim import (
    actuator,
    end_stop,
    flat,
    friction,
    integrator,
    line,
    machine_code,
    manipulator,
    mechanics,
    pendulum,
    plant,
    spool,
    supply,
)
from forest_sim.equilibrium import equilibrium
from forest_sim.integrator import Simulation
from forest_sim.manipulator import Triple
from forest_sim.parameters import PlantParameters, plant_parameters

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
SELDOM = ("_two_edges", "pendulum_dynamics", "_second_order")

Advance = Callable[[Simulation, Triple, float, int, PlantParameters], Simulation]


@lru_cache(maxsize=1)
def compiled_advance() -> Advance:
    """Return `integrator.advance`, compiled.

    Raises:
        ModuleNotFoundError: there is no compiled code for this version, and numba is not installed.
    """
    code = _cached()
    if code is None:
        code = machine_code.translate(_kernel(), SELDOM)
        machine_code.write(_cache_file(), code)
    return _advance_with(machine_code.load(code))


def ready_advance() -> Advance | None:
    """Return the compiled `integrator.advance` if its code is there; None if it would have to be made."""
    try:
        return compiled_advance() if _cached() is not None else None
    except ModuleNotFoundError:
        return None


def _advance_with(kernel: machine_code.Kernel) -> Advance:
    """Return `integrator.advance` around a kernel that moves a flat state on in place."""
    simulation, p = _example()
    pack, unpack, pack_parameters = flat.packer(simulation), flat.unpacker(simulation), flat.packer(p)
    state, volts = np.empty(len(pack(simulation))), np.empty(3)
    known: dict[str, Any] = {"p": None, "row": np.empty(0)}  # parameters seldom change

    def advance(
        simulation: Simulation, voltages: Triple, h: float, count: int, p: PlantParameters
    ) -> Simulation:
        if known["p"] is not p:
            known.update(p=p, row=np.array(pack_parameters(p), dtype=np.float64))
        state[:] = pack(simulation)
        volts[:] = voltages
        status = kernel(state.ctypes.data, volts.ctypes.data, h, count, known["row"].ctypes.data)
        if status != 0:
            raise ArithmeticError(f"the compiled plant stopped with status {status}")
        moved: Simulation = unpack(state.tolist())
        return moved

    return advance


def _kernel() -> Callable[..., None]:
    """Return the function to compile: it unpacks state and parameters, steps, and packs the state again."""
    from numba.extending import register_jitable

    for module in LAWS:
        for _, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and function is not integrator.advance:
                register_jitable(error_model="numpy")(function)
    simulation, p = _example()
    names: dict[str, Any] = {"step": integrator.step}
    lines = [
        "def kernel(state, voltages, h, count, parameters):",
        f"    p = {flat.construction(p, 'parameters', names)}",
        f"    simulation = {flat.construction(simulation, 'state', names)}",
        "    held = (voltages[0], voltages[1], voltages[2])",
        "    for _ in range(count):",
        "        simulation = step(simulation, held, h, p)",
    ]
    for i, (path, _) in enumerate(flat.leaves(simulation, "simulation")):
        lines.append(f"    state[{i}] = {path}")
    exec("\n".join(lines), names)  # our own text, made of field names
    kernel: Callable[..., None] = names["kernel"]
    return kernel


@lru_cache(maxsize=1)
def _example() -> tuple[Simulation, PlantParameters]:
    """Return values of the types that all machines share."""
    p = plant_parameters(load_machine("c180_thesis"))
    return equilibrium((0.0, 0.5, -1.5), p), p


def _cached() -> bytes | None:
    try:
        return _cache_file().read_bytes()
    except OSError:
        return None


@lru_cache(maxsize=1)
def _cache_file() -> Path:
    """Return where this version's object code lies for this interpreter and processor."""
    digest = hashlib.sha256(f"{sys.version} {machine_code.processor()}".encode())
    for module in (*LAWS, flat, machine_code, sys.modules[__name__]):
        digest.update(Path(str(module.__file__)).read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "forest_sim" / f"{digest.hexdigest()[:24]}.o"


def main() -> None:
    """Make the object code if it is not there, and tell where it is."""
    compiled_advance()
    print(_cache_file())


if __name__ == "__main__":
    main()
