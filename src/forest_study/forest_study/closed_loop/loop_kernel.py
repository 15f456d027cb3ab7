"""What the compiled loop is made of: `loop_core.period` over and over, on numbers that lie flat."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from forest_compile import flat_layout
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel
from forest_control import compiled as control_compiled
from forest_control.config import controller_settings
from forest_control.operator import levers
from forest_control.valve import valve_driver, valve_driver_parameters
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats, Vec3
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors import sensor_readings, sensor_suite
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.solver import plant_kernel
from forest_sim.solver.equilibrium import equilibrium
from forest_study.closed_loop import closed_loop, loop_core, path_guide
from forest_study.closed_loop.link_model import Reports
from forest_study.closed_loop.loop_core import Guarded, Knowledge, Loop
from forest_study.closed_loop.path_guide import Guide, Hand, levers_for

# What is seldom called stays a function; all else is written out: four seconds to compile, a fifth faster.
NOINLINE = (*plant_kernel.NOINLINE, *control_compiled.NOINLINE)
# state, knowledge, levers (4 a row: swing, boom, stick, enabled), normals, recorded, rows; of an operator who
# leads the reference: places (3 a period), hand and guide, the clock of each row; numbers given as it runs
ARGUMENTS = "pppppipppp"
HAPPENED = [path for path, _ in flat_layout.leaves(loop_core.NOTHING, "happened")]


def knowledge(
    machine: Machine,
    model: Machine,
    control: controller_settings.Settings,
    drive: valve_driver_parameters.Settings,
    suite: Suite,
    substeps: int = loop_core.SUBSTEPS,
) -> Knowledge:
    """Return all that stays in a run."""
    return Knowledge(
        sensors=sensor_readings.sensors(plant_parameters(machine), suite),
        links=machine.manipulator.links,
        control=controller_settings.parameters(model, control),
        drive=valve_driver_parameters.parameters(model, drive),
        guard=loop_core.guard_of(suite),
        substeps=substeps,
    )


def begin(k: Knowledge, start: Vec3, suite: Suite) -> Loop:
    """Return the loop as it first reports, having been at rest at joint angles [rad]."""
    rest = equilibrium(start, k.sensors.plant)
    sensors = sensor_readings.at_rest(rest, k.sensors.plant, suite)
    simulation = closed_loop.until_first_report(rest, k.sensors.plant)
    return Loop(
        simulation=simulation, sensors=sensors, control=Guarded(), drive=valve_driver.REST, reports=Reports()
    )


def pack(kind: str, value: Loop | Knowledge) -> Floats:
    """Return numbers laid out flat; all of a kind are of one shape."""
    if kind not in _packers:
        _packers[kind] = flat_layout.packer(value)
    return np.array(_packers[kind](value), dtype=np.float64)


_packers: dict[str, Callable[[Any], flat_layout.Row]] = {}


def entry() -> Entry:
    """Return what the loop's kernel is made of: levers and draws in, what happened out, a row a period."""
    k, loop = example()
    names: dict[str, Any] = {"period": loop_core.period, "Levers": levers.Levers}
    names |= {f.__name__: f for f in (Guide, Hand, path_guide.asked, path_guide.answered, levers_for)}
    after = [path for path, _ in flat_layout.leaves(loop, "after")]
    lines = [
        "def kernel(state, knowledge, levers, normals, recorded, rows, places, guide, clock, runtime):",
        "    last, every = int(guide[0]), int(guide[3])",
        "    hand = Hand(guide[1], guide[2], every, guide[4])",
        "    for row in range(int(guide[10]), rows):",
        f"        before = {flat_layout.construction(loop, 'state', names)}",
        "        spoken = row % every == 0",
        "        led = Guide(guide[5], guide[6], (guide[7], guide[8], guide[9]))",
        "        lever = Levers(levers[4 * row], levers[4 * row + 1], levers[4 * row + 2])",
        "        if last > 0:",
        "            if spoken:",
        "                lever = levers_for(asked(led, hand, places, last), hand)",
        "            else:",
        "                lever = Levers(levers[4 * row - 4], levers[4 * row - 3], levers[4 * row - 2])",
        "            levers[4 * row] = lever.swing",
        "            levers[4 * row + 1] = lever.boom",
        "            levers[4 * row + 2] = lever.stick",
        "            clock[row] = led.clock",
        "        held = levers[4 * row + 3] > 0.5",
        "        after, happened = period(before, lever, held, spoken, k, normals, row)",
        *(f"        state[{i}] = {path}" for i, path in enumerate(after)),
        *(f"        recorded[{len(HAPPENED)} * row + {i}] = {path}" for i, path in enumerate(HAPPENED)),
        "        guide[10] = row + 1",
        "        if last > 0:",
        "            led = answered(led, lever, happened.tip_wish, hand, places, last)",
        "            guide[5] = led.clock",
        "            guide[6] = led.beside",
        "            guide[7] = led.place[0]",
        "            guide[8] = led.place[1]",
        "            guide[9] = led.place[2]",
        "            if led.clock >= last:",
        "                break",
    ]
    tuples = {"k": ("knowledge", k)}
    return Entry(text="\n".join(lines), names=names, arguments=ARGUMENTS, tuples=tuples, noinline=NOINLINE)


@lru_cache(maxsize=1)
def example() -> tuple[Knowledge, Loop]:
    """Return values of the types that all runs share."""
    machine = load_machine("c180")
    suite = sensor_suite.sensor_suite(machine)
    k = knowledge(machine, machine, controller_settings.Settings(), valve_driver_parameters.Settings(), suite)
    return k, begin(k, (0.0, 0.5, -1.5), suite)


KERNEL = CachedKernel("loop", entry)
"""The compiled loop."""
