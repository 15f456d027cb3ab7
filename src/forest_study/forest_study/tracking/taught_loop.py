"""Taught work in the closed loop without ROS: a path is driven, taught, and played by the real controller.

What the player says in a period counts in the next one, as in the live graph. Places are those of the true
tip.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from forest_control.config import controller_settings
from forest_control.operator.levers import REST
from forest_control.taught.player import Output, Phase
from forest_control.taught.taught_work import Seen, TaughtWork
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors.sensor_suite import Suite, sensor_suite
from forest_study.closed_loop.closed_loop import ClosedLoop, Operator
from forest_study.closed_loop.loop_core import Happened

FAST = partial(ClosedLoop, fast=True)


class TaughtLoop:
    """Machine, controller, driver and taught work between periods.

    Args:
        machine: what is simulated, and what controller and driver believe.
        start: where the tip is at rest [m].
        folder: of the cycles.
        settings: of the controller; the plan knows the defaults.
        suite: sensors; default: the machine's, exact.
        plant: what is simulated instead of the machine's own parameters.
        make: the loop of its cores.
    """

    def __init__(
        self,
        machine: Machine,
        start: Vec3,
        folder: Path,
        settings: controller_settings.Settings | None = None,
        suite: Suite | None = None,
        plant: PlantParameters | None = None,
        make: Callable[..., ClosedLoop] = FAST,
    ) -> None:
        planned = controller_settings.parameters(machine, controller_settings.Settings())
        in_force = planned if settings is None else controller_settings.parameters(machine, settings)
        drive = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
        believed = plant_parameters(machine) if plant is None else plant
        sensors = sensor_suite(machine) if suite is None else suite
        self.loop = make(believed, in_force, drive, pose_at(start, machine), sensors)
        self.work, self._links = TaughtWork(folder, planned), machine.manipulator.links
        self.time, self.events = 0.0, list[str]()
        self.tips: list[Vec3] = []
        self.phases: list[Phase] = []
        self.period(Operator(REST))

    @property
    def phase(self) -> Phase:
        """What the player is about."""
        return self.work.phase

    def period(self, operator: Operator | None, pressed: bool = False, silent: bool = False) -> Happened:
        """Return what happened in a period; pressed: the one button; silent: the player is not heard."""
        if (telemetry := self.loop.telemetry) is not None and not silent:
            levers = operator.levers if operator else REST
            centred, watch = max(map(abs, levers)) <= 0.05, self.loop.controller.guard.permission.joystick
            seen = Seen(telemetry.tip, 1.0 + self.time, watch.armed, centred, pressed)
            self._hear(self.work.advance(seen, PERIOD))
        happened = self.loop.period(operator)
        self.time += PERIOD
        self.tips.append(tip_position(happened.angles, self._links))
        self.phases.append(self.phase)
        return happened

    def drive(self, operator: Operator | None, seconds: float) -> None:
        """Let the operator do the same for some time [s]."""
        for _ in range(round(seconds / PERIOD)):
            self.period(operator)

    def until(self, phase: Phase, most: float) -> None:
        """Hold the deadman until the player is in a phase.

        Raises:
            TimeoutError: it is not within `most` [s].
        """
        for _ in range(round(most / PERIOD)):
            if self.phase == phase:
                return
            self.period(Operator(REST))
        raise TimeoutError(f"no {phase.name} within {most:g} s: {self.events}")

    def _hear(self, output: Output) -> None:
        if output.event:
            self.events.append(output.event)
        if output.command is not None:
            self.loop.controller.hear_taught(self.work.run, output.command, self.time)
