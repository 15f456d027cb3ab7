"""The machine code of the plant's steps: what it is made of, and where it is kept.

The laws stay ordinary Python; here, and only here, they are handed to a compiler. Making the
machine code takes some ten seconds (`python -m forest_sim.compiled`). Loading it
(`forest_compile.kernel_cache`) takes some milliseconds. `compiled_plant` calls it.
"""

from functools import lru_cache

from forest_compile import flat_layout
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel
from forest_description.hydraulics import valve_characteristic
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_sim.equations import plant
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.hydraulics import command_history, port, spool_dynamics, supply
from forest_sim.mechanics import pendulum
from forest_sim.midpoint import compensator_step, holding_step, pushed_spools, tank_step
from forest_sim.solver import conserved_oil, integrator, power_flows
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.stage import axis_stage, drive_stage, elastic_stage, implicit_stage, stage_equations

# What is seldom called, or only with the energy account: inlined, it would make the whole larger.
NOINLINE = (
    port._two_edges,
    pendulum.pendulum_dynamics,
    spool_dynamics._second_order,
    spool_dynamics._driven_spool,
    command_history.after_dead_time,
    holding_step.lifts_after,
    compensator_step.openings_after,
    pushed_spools.pushed,
    tank_step.tank_at_stage,
    tank_step.returned,
    tank_step._as_volumes_fill,
    supply.flow_after,
    axis_stage._solve_with_chambers,
    axis_stage._solve_with_holding,
    axis_stage._tangents,
    valve_characteristic.curved_opening,
    valve_characteristic.overlap_leakage,
    implicit_stage._iterate_further,
    stage_equations._equations_at_again,
    implicit_stage._iterate_elastic,
    stage_equations._equations_at_elastic,
    power_flows.power_flows,
    power_flows._axis_power,
    power_flows._stopped_in,
    plant._axis_derivative,
    conserved_oil._contents,
    conserved_oil._settled,
    drive_stage.solve_drive,
    drive_stage.drive_after,
    elastic_stage.first_root_rates,
    elastic_stage.root_angles,
    elastic_stage.solve_links,
    elastic_stage.through_links,
    elastic_stage.root_corrections,
    elastic_stage.roots_after,
    power_flows._bending,
)
# state, voltages and their stride, length and count of each row's steps and their stride, rows, recorded (0:
# nothing, 1: states, 2: energies, too), parameters, states, energies
ARGUMENTS = "ppippiiippp"
NAMES = "state, voltages, stride, steps, counts, schedules, rows, recorded, parameters, states, energies"


def entry() -> Entry:
    """Return what the kernel is made of: it steps a machine that lies flat, and records it if asked to."""
    simulation, p = example()
    none = power_flows.power_flows(simulation, p)
    names = {
        "step_by_stages": integrator.step_by_stages,
        "parts": integrator.parts,
        "power_flows": power_flows.power_flows,
        "stopped_energy": power_flows.stopped_energy,
        "FIRST": integrator.WEIGHTS[0],
        "SECOND": integrator.WEIGHTS[1],
    }
    return Entry(
        text=_text(simulation, none),
        names=names,
        arguments=ARGUMENTS,
        tuples={"simulation": ("state", simulation), "p": ("parameters", p)},
        noinline=NOINLINE,
    )


def _text(simulation: Simulation, powers: power_flows.PowerFlows) -> str:
    """Return the kernel's source; the examples tell which numbers a state and its powers have."""
    state = [path for path, _ in flat_layout.leaves(simulation, "simulation")]
    flows = [path for path, _ in flat_layout.leaves(powers, "")]
    lines = [
        f"def kernel({NAMES}):",
        "    i, divided = 0, parts(p)",
        "    for row in range(rows):",
        "        h = steps[schedules * row] / divided",
        "        for _ in range(int(counts[schedules * row])):",
        "            held = (voltages[i], voltages[i + 1], voltages[i + 2])",
        "            i += stride",
        "            for _ in range(divided):",
        "                taken = step_by_stages(simulation, held, h, p)",
        "                if recorded > 1:",
        "                    early, late = power_flows(taken.early, p), power_flows(taken.late, p)",
        "                    stopped = stopped_energy(simulation.plant, taken.early, taken.late, h, p)",
        f"                    e = row * {len(flows) + len(AXES)}",
        *(
            f"                    energies[e + {i}] += h * (FIRST * early{path} + SECOND * late{path})"
            for i, path in enumerate(flows)
        ),
        *(f"                    energies[e + {len(flows) + i}] += stopped[{i}]" for i in range(len(AXES))),
        "                simulation = taken.after",
        "        if recorded:",
        f"            s = row * {len(state)}",
        *(f"            states[s + {i}] = {path}" for i, path in enumerate(state)),
        *(f"    state[{i}] = {path}" for i, path in enumerate(state)),
    ]
    return "\n".join(lines)


@lru_cache(maxsize=1)
def example() -> tuple[Simulation, PlantParameters]:
    """Return values of the types that all machines share."""
    p = plant_parameters(load_machine("c180_thesis"))
    return equilibrium((0.0, 0.5, -1.5), p), p


KERNEL = CachedKernel("plant", entry)
"""The kernel, which moves a flat machine in place."""
