"""The controller's and the valve driver's step as machine code, for their nodes.

Compiled and interpreted steps agree to the last bit; compiled ones take a tenth of the time and touch little
of what a waking process finds cold. `python -m forest_control.compiled` makes the code, in some seconds; a
node takes it if it is there, and runs interpreted otherwise.
"""

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from forest_compile.compiled_step import ARGUMENTS, CompiledStep, Example, kernel_text
from forest_compile.kept import Kept, can_compile
from forest_control import (
    capacity,
    control_state,
    controller,
    coordination,
    execution,
    governor,
    hand,
    handover,
    inching,
    levers,
    plausibility,
    position_source,
    schemes,
    settings,
    singularity,
    stopping,
    swing_load,
    valve_adaptation,
    valve_driver,
    valve_flow,
    valve_hold,
    valve_inverse,
    valve_knowledge,
    valve_reach,
    wish,
    workspace,
)
from forest_description import actuation, kinematics, linkage, valve
from forest_description.machine import load_machine

Step = Callable[..., tuple[Any, Any]]

LAWS: tuple[ModuleType, ...] = (
    *(actuation, kinematics, linkage, valve),
    *(capacity, control_state, controller, coordination, execution, governor, hand, handover),
    *(inching, levers),
    *(plausibility, position_source, schemes, settings, singularity, stopping),
    *(swing_load, valve_adaptation, valve_driver, valve_flow, valve_hold, valve_inverse, valve_knowledge),
    *(valve_reach, wish, workspace),
)
# What is seldom called stays a function; all else is written out.
APART = ("_stopping", "taken_over", "nearest_pose", "share", "slid", "tip_following")


def controller_step() -> Step:
    """Return `controller.told`, compiled if its code is there."""
    return CompiledStep(CONTROLLER.kernel(), _control()) if CONTROLLER.is_ready else controller.told


def driver_step() -> Step:
    """Return `valve_driver.step_seen`, compiled if its code is there."""
    return CompiledStep(DRIVER.kernel(), _drive()) if DRIVER.is_ready else valve_driver.step_seen


def _control() -> Example:
    """Return values of the types that all machines share."""
    p = controller.parameters(load_machine("c180"), controller.Settings())
    inputs = controller.Inputs((0.0, 0.5, -1.5), (0.0, 0.0, 0.0), levers.REST, False)
    state, told = controller.told(controller.REST, inputs, p, 0.005)
    return Example(state, (inputs,), p, told)


def _drive() -> Example:
    p = valve_driver.parameters(load_machine("c180"), valve_driver.Settings())
    inputs = (0.0, 0.0, 0.0), valve_driver.UNSEEN, valve_driver.STILL
    state, voltages = valve_driver.step_seen(valve_driver.REST, *inputs, p, 0.005)
    return Example(state, inputs, p, voltages)


def _kept(name: str, step: Step, example: Callable[[], Example]) -> Kept:
    sources = *LAWS, sys.modules[__name__], sys.modules[kernel_text.__module__]
    return Kept(name, sources, lambda: kernel_text(step, example(), APART), ARGUMENTS)


CONTROLLER = _kept("controller", controller.told, _control)
DRIVER = _kept("valve-driver", valve_driver.step_seen, _drive)


def main() -> None:
    """Make the machine code if it is not there, and tell where it is."""
    if not can_compile():
        sys.exit("llvmlite is not installed: the nodes run interpreted")
    for kept in (CONTROLLER, DRIVER):
        kept.kernel()
        print(kept.file)


if __name__ == "__main__":
    main()
