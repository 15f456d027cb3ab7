"""The true course of the work: scipy's Radau at 1e-10 on the peers' right-hand side, kept in a cache.

Independent of ours in equations and method. LSODA at 1e-11 agrees with it to 1e-10 rad and 1e-6 MPa.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import work as benchmark
from forest_description.machine import load_machine
from forest_sim.equations.appendix_b import to_array
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.equilibrium import equilibrium
from work import Floats, Work

TOLERANCE = 1e-10
HERE = Path(__file__).resolve().parent
SOURCES = [HERE / name for name in ("peers/equations.py", "peers/segments.py", "reference.py")]


def start_state() -> Floats:
    """Return the equilibrium [SI] in which the work starts: held by trapped oil, valves shut."""
    return to_array(equilibrium(benchmark.START, plant_parameters(load_machine("c180_thesis"))).plant)


def cached(mode: str, seconds: float) -> Path:
    """Return the file with the reference's states, made by a process of its own if it is not there."""
    path = _path(benchmark.make(mode, seconds))
    if not path.exists():
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | {"NUMBA_CACHE_DIR": cache}
            subprocess.run([sys.executable, __file__, mode, str(seconds)], env=environment, check=True)
    return path


def compute(work: Work) -> Floats:
    """Return the states [SI] at every sample, shape (samples + 1, 18)."""
    from peers import scipy_bdf_numba  # needs numba, which the parent process can do without

    return scipy_bdf_numba.prepare(work, start_state(), TOLERANCE, method="Radau")().states


def _path(work: Work) -> Path:
    sums = hashlib.sha256(benchmark.digest(work).encode() + start_state().tobytes())
    sums.update(repr(load_machine("c180_thesis")).encode())
    for source in SOURCES:
        sums.update(source.read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "forest_benchmarks" / f"reference_{work.mode}_{sums.hexdigest()[:16]}.npy"


def main(mode: str, seconds: float) -> None:
    """Compute and store the reference."""
    work = benchmark.make(mode, seconds)
    path = _path(work)
    path.parent.mkdir(parents=True, exist_ok=True)
    states = compute(work)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        np.save(file, states)
    Path(file.name).replace(path)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
