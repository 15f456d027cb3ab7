"""GNU Octave's ode15s (SUNDIALS IDA); the program is written with the numbers of `equations` in it."""

import re
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.io import loadmat, savemat

from peers import Run
from peers.equations import NUMBERS, SCALE, SHUT_OPENING, SHUT_RATE
from work import SAMPLE, Floats, Work

PROGRAM = Path(__file__).with_name("octave_ode15s.m")


def program() -> str:
    """Return the Octave program; every @name@ becomes its number."""
    numbers = NUMBERS | {"shut_rate": SHUT_RATE, "shut_opening": SHUT_OPENING, "sample": SAMPLE}
    return re.sub(r"@(\w+)@", lambda match: f"({numbers[match[1]]!r})", PROGRAM.read_text())


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work; Octave's start is not in its CPU time."""
    data = {
        "start": (start / SCALE)[:, None],
        "ends": np.array([(s.first, s.last) for s in work.segments], dtype=float),
        "waves": np.array([s.wave for s in work.segments]),
        "tolerance": tolerance,
    }

    def integrate() -> Run:
        with tempfile.TemporaryDirectory() as folder:
            savemat(f"{folder}/work.mat", data)
            Path(folder, "run_work.m").write_text(program())
            subprocess.run(["octave-cli", "--norc", "--quiet", "run_work.m"], cwd=folder, check=True)
            result = loadmat(f"{folder}/result.mat")
        return Run(result["states"] * SCALE, result["cpu"].item())

    return integrate
