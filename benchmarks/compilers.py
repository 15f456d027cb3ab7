"""What `forest_compile` takes and gives against Numba, on the same laws; prints a table.

    python benchmarks/compilers.py [--laws NAME ...] [--json FILE]

Each compiler gets the same loop around the same step, in a process of its own with nothing cached. Numba is
handed the laws as they are: each function, and all that it calls, by `njit`. How to read the table:
benchmarks/README.md.
"""

import argparse
import contextlib
import importlib.util
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from forest_compile import fingerprint, flat_layout, machine_code
from forest_compile.entry import Entry
from forest_compile.frontend import translate
from forest_control import compiled as control
from forest_control.pipeline import controller
from forest_control.valve import valve_driver
from forest_description.geometry.kinematics import nearest_pose
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors import sensor_readings, sensor_run
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import step

COMPILERS = {"ours": "forest_compile", "numba": "Numba"}
STEPS, REPEATS = 5000, 40
HEAD = (
    "| laws | functions | compiler | first step, s | of CPU | adds, MB | a step, µs | times ours |\n"
    "|---|---|---|---|---|---|---|---|"
)
Row = dict[str, Any]
Run = Callable[[int], tuple[float, ...]]


class Law(NamedTuple):
    """A step with what it is given."""

    step: FunctionType
    call: str  # of the step in the loop
    state: Any
    inputs: tuple[Any, ...]
    p: Any
    dt: float
    timed: bool = True


def plant() -> Law:
    """Return the plant's step: three axes with open valves, energy not accounted."""
    p = plant_parameters(load_machine("c180_hoses"))
    start = equilibrium((0.0, 0.5, -1.5), p)
    return Law(step, "state = step(state, inputs[0], dt, p)", start, ((3.0, -2.0, 2.5),), p, 1e-3)


def kinematics() -> Law:
    """Return the joint angles nearest to a pose, from the tip's position."""
    links = load_machine("c180_hoses").manipulator.links
    call = "state = step(inputs[0], state, p)"
    return Law(nearest_pose, call, (0.3, 0.5, -1.4), ((5.0, 1.0, 0.5),), links, 0.0)


def _stepping(step: Any, example: Any) -> Law:
    inputs = ", ".join(f"inputs[{i}]" for i in range(len(example.inputs)))
    call = f"state, output = step(state, {inputs}, p, dt)"
    # At rest, where the example is, the step does little: its time would say nothing.
    return Law(step, call, example.state, example.inputs, example.p, 0.005, timed=False)


LAWS = {
    "plant": plant,
    "kinematics": kinematics,
    "sensors": lambda: _stepping(sensor_readings.report, sensor_run._example()),
    "controller": lambda: _stepping(controller.step_with_telemetry, control._control()),
    "driver": lambda: _stepping(valve_driver.step, control._drive()),
}


def by_ours(law: Law) -> Run:
    """Return a function of a count of steps that gives the last state, laid out flat."""
    paths = [path for path, _ in flat_layout.leaves(law.state, "state")]
    lines = ["def kernel(row, given, parameters, dt, count):", "    for _ in range(count):"]
    lines += [f"        {law.call}", *(f"    row[{i}] = {path}" for i, path in enumerate(paths))]
    tuples = {"state": ("row", law.state), "inputs": ("given", law.inputs), "p": ("parameters", law.p)}
    entry = Entry("\n".join(lines), {"step": law.step}, "pppdi", tuples)
    code = machine_code.optimised(translate.llvm_ir(entry))
    try:
        kernel = machine_code.load_shared(machine_code.linked(code), entry.arguments)
    except OSError:
        kernel = machine_code.load(code, entry.arguments)
    start, given, p = (
        np.array(flat_layout.packer(item)(item), dtype=float) for item in (law.state, law.inputs, law.p)
    )

    def run(count: int) -> tuple[float, ...]:
        row = start.copy()
        kernel(row.ctypes.data, given.ctypes.data, p.ctypes.data, law.dt, count)
        return tuple(row.tolist())

    return run


def by_numba(law: Law) -> Run:
    """Return the same by Numba."""
    import numba

    lines = ["def loop(state, inputs, p, dt, count):", "    for _ in range(count):"]
    names: dict[str, Any] = {"step": _jitted(law.step, {})}
    exec("\n".join([*lines, f"        {law.call}", "    return state"]), names)  # noqa: S102  our own text
    loop, pack = numba.njit(names["loop"]), flat_layout.packer(law.state)
    return lambda count: pack(loop(law.state, law.inputs, law.p, law.dt, count))


def _jitted(value: Any, known: dict[Any, Any], names: frozenset[str] = frozenset()) -> Any:
    """Return a function compiled together with all that it calls; other values as they are."""
    import numba

    if isinstance(value, ModuleType):
        twin = ModuleType(value.__name__)
        for name in names & vars(value).keys():
            setattr(twin, name, _jitted(getattr(value, name), known))
        return value if value.__name__ == "math" else twin
    if not isinstance(value, FunctionType):
        return value
    if value not in known:
        known[value] = value  # a name may lead back, where it means a field
        code = value.__code__
        inner = {name for item in code.co_consts for name in getattr(item, "co_names", ())}
        used = frozenset(code.co_names) | inner
        scope = {n: _jitted(v, known, used) for n, v in value.__globals__.items() if n in used}
        twin = FunctionType(code, scope, value.__name__, value.__defaults__)
        known[value] = numba.njit(twin)
    return known[value]


def measure(name: str, compiler: str) -> Row:
    """Return what a compiler takes and gives, or the reason for which it refuses; in a process of its own."""
    law = LAWS[name]()
    row: Row = {"laws": name, "compiler": compiler, "functions": _count(law)}
    before, wall, cpu = _peak_mb(), time.perf_counter(), time.process_time()
    try:
        run = {"ours": by_ours, "numba": by_numba}[compiler](law)
        run(1)
    except Exception as error:  # noqa: BLE001  # whatever it says is what is told
        return row | {"refused": _reason(error)}
    row |= {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
    row["adds_mb"] = _peak_mb() - before
    row["state"] = run(100)
    if not law.timed:
        return row
    spent = {count: min(_seconds(run, count) for _ in range(REPEATS)) for count in (1, STEPS)}
    return row | {"us_per_step": 1e6 * (spent[STEPS] - spent[1]) / (STEPS - 1)}


def _count(law: Law) -> int:
    found = fingerprint.functions(Entry("", {"step": law.step}, "", {}, {}))
    return sum(function.__module__.startswith("forest_") for function in found)


def _peak_mb() -> float:
    """Return the most memory [MB] that this process has had."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def _seconds(run: Run, count: int) -> float:
    began = time.process_time()
    run(count)
    return time.process_time() - began


def _reason(error: Exception) -> str:
    """Return the line of an error that says most; Numba's have many."""
    lines = [re.sub(r"\x1b\[[0-9;]*m", "", line).strip() for line in str(error).splitlines()]
    said = [line for line in lines if line and not line.startswith(("During", "File", "-", "<", "^"))]
    telling = [
        line for line in said if re.search("Unknown attribute|not supported|Cannot unify|Invalid use", line)
    ]
    return f"{type(error).__name__}: {(telling or said or ['?'])[0].split('(')[0]}"


def apart(name: str, compiler: str) -> Row:
    """Return what `measure` does in a new process."""
    if importlib.util.find_spec("numba" if compiler == "numba" else "llvmlite") is None:
        return {"laws": name, "compiler": compiler, "functions": 0, "refused": "not installed"}
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(Path(__file__).resolve()), "--one", name, compiler]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    with contextlib.suppress(json.JSONDecodeError, IndexError):
        row: Row = json.loads(done.stdout.splitlines()[-1])
        return row
    return {"laws": name, "compiler": compiler, "functions": 0, "refused": f"exit code {done.returncode}"}


def table(rows: Iterable[Row]) -> Iterable[str]:
    """Return the rows as lines of Markdown."""
    ours: dict[str, Row] = {}
    for row in rows:
        head = f"| {row['laws']} | {row['functions']} | {COMPILERS[row['compiler']]} |"
        if "refused" in row:
            yield f"{head} refuses: {row['refused'].replace('|', '/')} | | | | |"
            continue
        if row["compiler"] == "ours":
            ours[row["laws"]] = row
        other, step = ours.get(row["laws"], row), row.get("us_per_step")
        times = "" if row is other else f"{row['cpu_s'] / other['cpu_s']:.0f} to compile"
        if times and step:
            times += f", {step / other['us_per_step']:.1f} to run"
        numbers = f"{row['wall_s']:.1f} | {row['cpu_s']:.1f} | {row['adds_mb']:.0f}"
        yield f"{head} {numbers} | {f'{step:.3f}' if step else ''} | {times} |"


def differences(rows: Iterable[Row]) -> Iterable[str]:
    """Return a sentence for each law that both compilers took: how far they are apart after 100 steps."""
    states: dict[str, list[float]] = {}
    for row in rows:
        state = row.get("state")
        other = states.setdefault(row["laws"], state) if state else None
        if state and other is not state and other:
            far = max(abs(a - b) / max(1.0, abs(b)) for a, b in zip(state, other, strict=True) if a == a)
            yield f"{row['laws']}: after 100 steps no number differs by more than {far:.0e} of itself"


def main() -> None:
    """Measure, print the table, and write the rows if asked to."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=list(LAWS), help="default: all")
    parser.add_argument("--json", type=Path, help="also write the rows there")
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(*options.one)))
        return
    rows = []
    print(HEAD)
    for name in options.laws:
        for compiler in COMPILERS:
            rows.append(apart(name, compiler))
            print(list(table(rows))[-1], flush=True)
    print(*differences(rows), sep="\n")
    if options.json:
        options.json.write_text(json.dumps({"rows": rows}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
