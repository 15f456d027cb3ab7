"""What components cost that a machine has, and those that it lacks.

A component that `c180_thesis` lacks is neutral numbers in one kernel for all machines. Its cost is measured
against a kernel in which these numbers are taken for granted, so that LLVM cuts the component's code out.
What a component costs that `c180` or `forwarder` has, is measured on the one kernel: against the machine
without it.

Kernels and machines take turns, half a second of the work at a time, and the fastest of each half second
counts, so that neighbours on the machine disturb little.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

import work as benchmark
from forest_compile import flat_layout, machine_code
from forest_compile.entry import Entry
from forest_compile.frontend import translate
from forest_description.machine import load_machine
from forest_sim.equations.elastic_links import RIGID_LINKS
from forest_sim.equations.plant_parameters import DriveLaws, PlantParameters, plant_parameters
from forest_sim.hydraulics.compensator import NO_COMPENSATOR
from forest_sim.hydraulics.load_holding import NO_HOLDING
from forest_sim.hydraulics.pump_drive import NO_DRIVE
from forest_sim.hydraulics.tank_line import NO_LINE
from forest_sim.mechanics.bristles import NO_BRISTLES
from forest_sim.mechanics.friction import FRICTIONLESS
from forest_sim.mechanics.gear import NO_GEAR
from forest_sim.solver import plant_kernel
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import STATE
from work import SAMPLE, Floats

COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "relief and anti-cavitation valves": (".guard.",),
    "pump with limits": (".supply.",),
    "hanging head": (".head.",),
    "force on the tip": (".tip_force[",),
    "end stops": (".stop.",),
    "cushions": (".cushion.",),
    "dry friction": (".friction.",),
    "spool lag": (".lag.",),
    "curved valve": (".curve.",),
    "spool leakage": (".law.leakage.", ".law.edge_ratio."),
}
PLAIN = {"play": 0.0, "slew": math.inf, "dead_time": 0.0, "jet": 0.0}  # of a spool
WITHOUT: Mapping[str, Callable[[PlantParameters], PlantParameters]] = {
    "bending links": lambda p: p._replace(elastic=RIGID_LINKS),
    "load-holding valves": lambda p: p.with_axes(holds=0, holding_1=NO_HOLDING, holding_2=NO_HOLDING),
    "seals' friction": lambda p: p.with_axes(friction=FRICTIONLESS),
    "gear play, bearing friction": lambda p: p._replace(drive=DriveLaws(0, NO_GEAR, NO_BRISTLES)),
    "tank line": lambda p: p._replace(tank_line=NO_LINE),
    "swash plate, engine": lambda p: p._replace(supply=p.supply._replace(drive=NO_DRIVE)),
    "hysteresis, dead time, slew limit, flow forces": lambda p: _with_lags(p, **PLAIN),
    "compensators": lambda p: _with_valves(p, compensator=NO_COMPENSATOR),
    "hanging head": lambda p: p._replace(head=p.head._replace(mass=0.0)),
}
FULL = ("c180", "forwarder")  # machines with all that are there
STEPS = 5  # in a sample: 1 ms
PIECE = 100  # samples
HEAD = "| what | ns a step | costs |\n|---|---|---|"
FULL_HEAD = (
    "| without | " + " | ".join(f"`{name}`, ns a step | costs" for name in FULL) + " |\n|---|---|---|---|---|"
)
Row = dict[str, Any]


class Runner(NamedTuple):
    """A kernel with a machine that goes through the work again and again."""

    kernel: machine_code.Kernel
    parameters: Floats
    starts: list[Floats]  # states at each piece's beginning
    best: list[float]  # seconds of each piece


def kernel_without(parts: Sequence[str]) -> machine_code.Kernel:
    """Return the kernel with the parameters of some components taken for granted."""
    if not parts:
        return plant_kernel.KERNEL.kernel()
    entry, _ = entry_without(parts)
    return machine_code.load(machine_code.optimised(translate.llvm_ir(entry)), entry.arguments)


def entry_without(parts: Sequence[str]) -> tuple[Entry, str]:
    """Return what the kernel without some components is made of, and the expression of its parameters."""
    entry = plant_kernel.entry()
    _, p = entry.tuples["p"]
    names = dict(entry.names)
    constant = _with_constants(p, "p", tuple(parts), names)
    head, *body = entry.text.splitlines()
    return entry._replace(text="\n".join([head, f"    p = {constant}", *body]), names=names), constant


def _with_constants(value: Any, path: str, parts: tuple[str, ...], names: dict[str, Any]) -> str:
    """Return an expression for parameters some of which are constants; `names` is given what it needs."""
    if not isinstance(value, tuple):
        if not any(part in f"{path}." for part in parts):
            return path
        names[name := f"CONSTANT_{len(names)}"] = value
        return name
    fields = getattr(value, "_fields", None)
    paths = [f"{path}.{fields[i]}" if fields else f"{path}[{i}]" for i in range(len(value))]
    pieces = [_with_constants(item, inner, parts, names) for item, inner in zip(value, paths, strict=True)]
    if not fields:
        return f"({', '.join(pieces)},)"
    names[name := type(value).__name__] = type(value)
    return f"{name}({', '.join(pieces)})"


def measure(seconds: float, repeats: int) -> list[Row]:
    """Return rows for the whole kernel, for it without each component and without all, and `c180_hoses`."""
    voltages = np.ascontiguousarray(benchmark.step_voltages(benchmark.make("open", seconds), STEPS))
    every = [part for parts in COMPONENTS.values() for part in parts]
    whole = kernel_without(())
    thesis_p, hoses_p = (plant_parameters(load_machine(name)) for name in ("c180_thesis", "c180_hoses"))
    runners = {
        "c180_thesis": _runner(whole, thesis_p, voltages),
        **{n: _runner(kernel_without(parts), thesis_p, voltages) for n, parts in COMPONENTS.items()},
        "all of them": _runner(kernel_without(every), thesis_p, voltages),
        "c180_hoses": _runner(whole, hoses_p, voltages),
    }
    per_step = _in_turns(runners, voltages, repeats)
    thesis = per_step["c180_thesis"]
    return [
        {"what": name, "ns_per_step": ns, "ratio": ns / thesis if name == "c180_hoses" else thesis / ns}
        for name, ns in per_step.items()
    ]


def measure_full(seconds: float, repeats: int) -> list[Row]:
    """Return rows for `FULL` machines, and for them without each component and without all of `WITHOUT`."""
    voltages = np.ascontiguousarray(benchmark.step_voltages(benchmark.make("open", seconds), STEPS))
    runners = {}
    for name in FULL:
        bare = whole = plant_parameters(load_machine(name))
        runners[name, "nothing"] = _runner(plant_kernel.KERNEL.kernel(), whole, voltages)
        for what, less in WITHOUT.items():
            bare = less(bare)
            if less(whole) != whole:
                runners[name, what] = _runner(plant_kernel.KERNEL.kernel(), less(whole), voltages)
        runners[name, "all of these"] = _runner(plant_kernel.KERNEL.kernel(), bare, voltages)
    per_step = _in_turns(runners, voltages, repeats)
    return [
        {"machine": name, "without": what, "ns_per_step": ns, "costs_ns": per_step[name, "nothing"] - ns}
        for (name, what), ns in per_step.items()
    ]


def _with_valves(p: PlantParameters, **changes: Any) -> PlantParameters:
    one, two, three = (valve._replace(**changes) for valve in p.valves)
    return p._replace(valves=(one, two, three))


def _with_lags(p: PlantParameters, **changes: Any) -> PlantParameters:
    one, two, three = (valve._replace(lag=valve.lag._replace(**changes)) for valve in p.valves)
    return p._replace(valves=(one, two, three))


def _in_turns(runners: Mapping[Any, Runner], voltages: Floats, repeats: int) -> dict[Any, float]:
    """Return each runner's time of a step [ns]."""
    for _ in range(repeats):
        for piece in range(len(voltages) // (PIECE * STEPS)):
            for runner in runners.values():
                spent = _run(runner, piece, voltages)
                runner.best[piece] = min(runner.best[piece], spent)
    return {name: 1e9 * sum(r.best) / len(voltages) for name, r in runners.items()}


def _runner(kernel: machine_code.Kernel, p: PlantParameters, voltages: Floats) -> Runner:
    start = equilibrium(benchmark.START, p)
    state = np.array(flat_layout.packer(start)(start))
    runner = Runner(kernel, np.array(flat_layout.packer(p)(p)), [state], [])
    for piece in range(len(voltages) // (PIECE * STEPS)):
        runner.best.append(np.inf)
        _run(runner, piece, voltages, runner.starts.append)
    return runner


def _run(
    runner: Runner, piece: int, voltages: Floats, then: Callable[[Floats], None] = lambda _: None
) -> float:
    """Return the processor time [s] of a piece of the work."""
    state, record = runner.starts[piece].copy(), np.empty((PIECE, len(STATE)))
    steps, counts = np.full(PIECE, SAMPLE / STEPS), np.full(PIECE, float(STEPS))
    table = voltages[piece * PIECE * STEPS :]
    rows = [row.ctypes.data for row in (state, table, steps, counts, runner.parameters, record)]
    began = time.thread_time()
    runner.kernel(rows[0], rows[1], 3, rows[2], rows[3], 1, PIECE, 1, rows[4], rows[5], rows[5])
    spent = time.thread_time() - began
    then(state)
    return spent


def table(rows: Iterable[Row]) -> Iterable[str]:
    """Return the rows as lines of Markdown."""
    for row in rows:
        if row["what"] == "c180_thesis":
            what, cost = "`c180_thesis`", ""
        elif row["what"] == "c180_hoses":
            what, cost = (
                "`c180_hoses`, with relief, spool lag, end stops, pump",
                f"{row['ratio']:.2f} × the first",
            )
        else:
            what, cost = f"the same, cut out: {row['what']}", f"{100.0 * (row['ratio'] - 1.0):+.1f} %"
        yield f"| {what} | {row['ns_per_step']:.0f} | {cost} |"


def full_table(rows: Iterable[Row]) -> Iterable[str]:
    """Return the rows of `measure_full` as lines of Markdown."""
    cells = {(row["machine"], row["without"]): row for row in rows}
    for what in ("nothing", *WITHOUT, "all of these"):
        line = f"| {what} |"
        for name in FULL:
            row = cells.get((name, what))
            line += f" {row['ns_per_step']:.0f} | {row['costs_ns']:.0f} |" if row else " | |"
        yield line
