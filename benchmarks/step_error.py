"""The error of a step: every shipped machine at four steps, against steps of 62.5 us over 8 s.

| input | is |
|---|---|
| levers | voltages that sweep at 0.3 to 0.5 Hz over 60 % of the rated ones |
| drawn levers | the same with amplitudes, frequencies and phases drawn: 30 to 90 %, 0.25 to 0.6 Hz |
| jumps | voltages that jump every 0.4 s, to any within a share of the rated ones |
"""

import argparse
import math
from collections.abc import Callable

import numpy as np

from forest_description.config.source_tree import shipped_machines
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import STATE
from forest_sim.solver.step_schedule import even

SECONDS, HELD = 8.0, 0.02  # [s] of a run; of each voltage
FINE, STEPS = 6.25e-5, (2.5e-3, 1e-3, 5e-4, 2.5e-4)  # [s]
SEEDS = 8  # of drawn levers and of jumps, of which the worst counts
START = (0.0, 0.4, -1.4)  # [rad]
ANGLES = [STATE.index(f"{axis}_angle") for axis in ("swing", "boom", "stick")]


def levers(time: Floats) -> Floats:
    """Return voltages over the rated one, [N, 3]."""
    hertz, phase = np.array([0.31, 0.43, 0.53]), np.array([0.2, 1.5, 2.9])
    swept: Floats = 0.6 * np.sin(2.0 * math.pi * hertz * time[:, np.newaxis] + phase)
    return swept


def drawn_levers(stream: int) -> Callable[[Floats], Floats]:
    """Return voltages over the rated one, [N, 3], as a function of the time."""
    rng = np.random.default_rng(100 + stream)
    hertz, phase, share = (rng.uniform(*span, 3) for span in ((0.25, 0.6), (0.0, 2.0 * math.pi), (0.3, 0.9)))

    def at(time: Floats) -> Floats:
        swept: Floats = share * np.sin(2.0 * math.pi * hertz * time[:, np.newaxis] + phase)
        return swept

    return at


def jumps(share: float, stream: int) -> Callable[[Floats], Floats]:
    """Return voltages over the rated one, [N, 3], as a function of the time."""

    def at(time: Floats) -> Floats:
        held = np.floor(time / 0.4 + 1e-9).astype(int)
        voltages: Floats = np.random.default_rng(stream).uniform(-share, share, (held[-1] + 1, 3))[held]
        return voltages

    return at


INPUTS = {
    "levers": (levers,),
    "drawn levers": tuple(drawn_levers(stream) for stream in range(SEEDS)),
    "jumps, 60 %": tuple(jumps(0.6, stream) for stream in range(SEEDS)),
    "jumps, 100 %": tuple(jumps(1.0, stream) for stream in range(SEEDS)),
}


def angles(machine: Machine, shape: Callable[[Floats], Floats], step: float) -> Floats:
    """Return the joints' angles every `HELD` [rad], [N, 3]."""
    p, rated = plant_parameters(machine), [machine.valve_of(axis).rated_voltage for axis in range(3)]
    rows, per = round(SECONDS / HELD), round(HELD / step)
    volts = np.repeat(shape(HELD * np.arange(rows)) * rated, per, axis=0)
    states = np.zeros((rows, len(STATE)))
    compiled_record()(equilibrium(START, p), volts, even(step, rows, per), p, states, None)
    found: Floats = states[:, ANGLES]
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("machines", nargs="*", default=shipped_machines())
    options = parser.parse_args()
    head = " | ".join(f"{1e3 * step:g} ms, rad" for step in STEPS)
    print(f"| machine | input | {head} |\n|---|---|{'---|' * len(STEPS)}")
    for name in options.machines:
        machine = load_machine(name)
        for told, shapes in INPUTS.items():
            truth = [angles(machine, shape, FINE) for shape in shapes]
            worst = [
                max(
                    float(np.abs(angles(machine, shape, step) - there).max())
                    for shape, there in zip(shapes, truth, strict=True)
                )
                for step in STEPS
            ]
            print(f"| {machine.name} | {told} | " + " | ".join(f"{e:.1e}" for e in worst) + " |", flush=True)


if __name__ == "__main__":
    main()
