"""The controller's and the valve driver's step as machine code, for their nodes.

Compiled and interpreted steps agree to the last bit; compiled ones take a tenth of the time and touch little
of what a waking process finds cold. `python -m forest_control.compiled` makes the code, in some seconds; a
node takes it if it is there, and runs interpreted otherwise.
"""

import sys
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from forest_compile import compiled_step, kernel_cache
from forest_compile.compiled_step import CompiledStep, Example
from forest_compile.kernel_cache import CachedKernel
from forest_control.config import controller_settings
from forest_control.limits import workspace
from forest_control.operator import levers, operator_profile
from forest_control.pipeline import bumpless_transfer, control_state, controller, motion_command, stop_profile
from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_description.geometry import kinematics
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD

Step = Callable[..., tuple[Any, Any]]

# What is seldom called stays a function; all else is inlined.
NOINLINE = (
    *(motion_command.stop_command, bumpless_transfer.taken_over, kinematics.nearest_pose),
    *(stop_profile.velocity_left,),
    *(workspace.wall_scaling, workspace.slide, operator_profile.position_mode_velocity),
)


def controller_step() -> Step:
    """Return `controller.step_with_telemetry`, compiled if its code is there."""
    kernel = CONTROLLER.ready()
    return CompiledStep(kernel, _control()) if kernel else controller.step_with_telemetry


def driver_step() -> Step:
    """Return `valve_driver.step`, compiled if its code is there."""
    kernel = DRIVER.ready()
    return CompiledStep(kernel, _drive()) if kernel else valve_driver.step


@lru_cache(maxsize=1)
def _control() -> Example:
    """Return values of the types that all machines share."""
    p = controller_settings.parameters(load_machine("c180"), controller_settings.Settings())
    inputs = control_state.Inputs((0.0, 0.5, -1.5), (0.0, 0.0, 0.0), levers.REST, False)
    state, telemetry = controller.step_with_telemetry(control_state.REST, inputs, p, PERIOD)
    return Example(state, (inputs,), p, telemetry)


@lru_cache(maxsize=1)
def _drive() -> Example:
    p = valve_driver_parameters.parameters(load_machine("c180"), valve_driver_parameters.Settings())
    inputs = (0.0, 0.0, 0.0), load_estimate.UNSEEN, load_estimate.STILL
    state, voltages = valve_driver.step(valve_driver.REST, *inputs, p, PERIOD)
    return Example(state, inputs, p, voltages)


CONTROLLER = CachedKernel(
    "controller", lambda: compiled_step.entry(controller.step_with_telemetry, _control(), NOINLINE)
)
DRIVER = CachedKernel("valve-driver", lambda: compiled_step.entry(valve_driver.step, _drive(), NOINLINE))


def main() -> None:
    """Make the machine code if it is not there, and tell where it is."""
    sys.exit(kernel_cache.make(CONTROLLER, DRIVER))


if __name__ == "__main__":
    main()
