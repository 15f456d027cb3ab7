"""What the energy account leaves open: every shipped machine, all its components on, driven hard.

| input | is |
|---|---|
| random | a voltage of every valve every 0.2 s, anywhere within the rated one |
| slams | all valves full, then shut, every 0.4 s, their directions drawn |
| squares | full to and fro, at a frequency that rises from 1 to 10 Hz |
| logs | as random, with logs of up to 800 kg that are grasped and dropped every 1.5 s |

The account is kept by power flows at the stages, apart from what the step conserves.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

from forest_description.config.source_tree import shipped_machines
from forest_description.machine import load_machine
from forest_description.types import Floats
from forest_sim.simulation.changing_plant import ChangingPlant
from forest_sim.simulation.energy_account import Account, account, unaccounted, with_stored_energy
from forest_sim.simulation.load_schedule import Load
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import ENERGY, STATE

STEP = 1e-3  # [s]
STREAM = 5  # of what is drawn
BLOCK = 1.5  # [s] that are recorded at once, and that a log is held
GREATEST_LOG = 800.0  # [kg]


def random(time: Floats, draw: np.random.Generator) -> Floats:
    """Return voltages over the rated one, [N, 3]."""
    held = np.floor(time / 0.2).astype(int)
    voltages: Floats = draw.uniform(-1.0, 1.0, (held[-1] + 1, 3))[held]
    return voltages


def slams(time: Floats, draw: np.random.Generator) -> Floats:
    """Return voltages over the rated one, [N, 3]."""
    held = np.floor(time / 0.4).astype(int)
    open_now = (np.mod(time, 0.4) < 0.2)[:, np.newaxis]
    voltages: Floats = draw.choice([-1.0, 1.0], (held[-1] + 1, 3))[held] * open_now
    return voltages


def squares(time: Floats, draw: np.random.Generator) -> Floats:
    """Return voltages over the rated one, [N, 3]."""
    turns = time + 4.5 * time**2 / time[-1]  # from 1 to 10 Hz
    phases = draw.uniform(0.0, 1.0, 3)
    voltages: Floats = np.sign(np.sin(2.0 * np.pi * (turns[:, np.newaxis] + phases)))
    return voltages


def logs(time: Floats, draw: np.random.Generator) -> Floats:
    """Return voltages over the rated one, [N, 3]; `run` grasps and drops the logs."""
    return random(time, draw)


INPUTS: tuple[Callable[[Floats, np.random.Generator], Floats], ...] = (random, slams, squares, logs)


def run(
    name: str, shape: Callable[[Floats, np.random.Generator], Floats], seconds: float
) -> tuple[Account, int]:
    """Return the account of a machine under an input, and how many stages did not converge."""
    machine = load_machine(name)
    plant, draw, steps = ChangingPlant(machine), np.random.default_rng(STREAM), round(seconds / STEP)
    rated = [machine.valve_of(axis).rated_voltage for axis in range(3)]
    volts = shape(STEP * np.arange(steps), draw) * rated
    begin = end = equilibrium(start_angles(machine), plant.p)
    passed = np.zeros(len(ENERGY))
    for count, block in enumerate(np.array_split(volts, max(1, round(seconds / BLOCK)))):
        if shape is logs:
            held = draw.uniform(0.0, GREATEST_LOG) * (count % 2)
            end = plant.hold(Load(held), end).simulation
        states, energies = np.zeros((1, len(STATE))), np.zeros((1, len(ENERGY)))
        end = compiled_record()(end, block, STEP, plant.p, states, energies)
        passed += energies[0]
    return with_stored_energy(account(passed), begin, end, plant.p), end.events.unconverged_stages


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("machines", nargs="*", default=shipped_machines())
    parser.add_argument("--seconds", type=float, default=600.0)
    options = parser.parse_args()
    print(
        "| machine | input | engine, MJ | stopped, % | unaccounted, % | failed stages |\n" + "|---" * 6 + "|"
    )
    for name in options.machines:
        for shape in INPUTS:
            total, failed = run(name, shape, options.seconds)
            stopped, left = (100.0 * float(e / total.engine) for e in (total.stopped, unaccounted(total)))
            cells = (f"{1e-6 * total.engine:.1f}", f"{stopped:.2f}", f"{left:.3f}", failed)
            print("| " + " | ".join(map(str, (Path(name).stem, shape.__name__, *cells))) + " |", flush=True)


if __name__ == "__main__":
    main()
