"""One run: a healthy machine at work, a fault that begins in it, and the monitor's rows."""

from typing import NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.valve import valve_driver_parameters
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.diagnosis import monitor, residual_limits, residual_parameters
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.sensors.sensor_readings import Surroundings
from forest_sim.simulation.load_schedule import Load, loaded
from forest_sim.solver.load_change import changed_load
from forest_study.closed_loop import loop_kernel, model_mismatch
from forest_study.closed_loop.loop_core import Knowledge, Loop
from forest_study.closed_loop.path_guide import Hand
from forest_study.diagnosis import monitored_loop
from forest_study.diagnosis.faults import Injected
from forest_study.diagnosis.population import Day, day, sensed
from forest_study.tracking.tracking import noisy

SPEED = 1.0  # [m/s] of the tip at full deflection
STEPS = 127.0  # of the joystick's converter
WARMING = 60.0  # [s] between two temperatures of the oil


class Run(NamedTuple):
    """What the monitor said, a row a second."""

    rows: Floats  # [N, monitored_loop.COLUMNS]
    begins: float  # [s] of the fault; infinite: none


def monitored(machine: Machine, seed: int, duration: float, fault: Injected, begins: float) -> Run:
    """Return a run.

    Args:
        machine: that controller, driver and monitor believe.
        seed: of the true machine and its work.
        duration: [s].
        fault: what goes wrong.
        begins: when [s]; a fault of the machine file, or of the oil's temperature, is there from the start.
    """
    begins = 0.0 if fault.from_start else begins
    one = day(machine, seed, duration)
    true, suite = fault.true_machine(machine), noisy(sensed(machine, one.rate), seed, static_errors=True)
    world = _World(true, one, fault, begins, duration)
    control = controller_settings.Settings(tip_speed=SPEED)
    drive = valve_driver_parameters.Settings()
    k = loop_kernel.knowledge(machine, machine, control, drive, suite)
    k = world.known(0, k)
    loop = loop_kernel.begin(k, one.start, suite)
    told = monitor.Parameters(residual_parameters.parameters(machine), residual_limits.LIMITS)
    setting = monitored_loop.Setting(loop, k, told, Hand(SPEED, steps=STEPS))
    normals = monitored_loop.draws(suite, len(one.work))
    changes = {row: world.change(row) for row in world.rows()}
    return Run(monitored_loop.run(setting, one.work, normals, changes), begins)


class _World:
    """What the machine is at a time: its oil, its log, its fault."""

    def __init__(self, true: Machine, one: Day, fault: Injected, begins: float, duration: float) -> None:
        self._true, self._day, self._fault = true, one, fault
        self._begins, self._duration = round(min(begins, duration) / PERIOD), duration
        self._crane = model_mismatch.drawn(true, one.off).manipulator
        self._channels = None

    def rows(self) -> list[int]:
        """Return the rows before which something changes."""
        warm = range(0, round(self._duration / PERIOD), round(WARMING / PERIOD))
        rows = {*warm, *(row for row, _ in self._day.logs), self._begins}
        return sorted(row for row in rows if 0 < row < len(self._day.work))

    def _temperature(self, row: int) -> float:
        if self._fault.temperature is not None:
            return self._fault.temperature
        share, (first, last) = row / len(self._day.work), self._day.oil
        return first + share * (last - first)

    def plant(self, row: int) -> PlantParameters:
        """Return the plant's parameters from a row on."""
        off = self._day.off._replace(oil=self._temperature(row))
        mass = next((mass for at, mass in reversed(self._day.logs) if at <= row), 0.0)
        plant = loaded(model_mismatch.applied(self._true, off), self._crane, Load(mass))
        return self._fault.plant(plant) if row >= self._begins else plant

    def known(self, row: int, k: Knowledge) -> Knowledge:
        """Return what stays of the loop from a row on."""
        channels = self._fault.channels(k.sensors.channels) if row == self._begins else k.sensors.channels
        around = Surroundings(temperatures=(self._temperature(row),) * 3)
        plant = self.plant(row)
        return k._replace(sensors=k.sensors._replace(plant=plant, channels=channels, around=around))

    def change(self, row: int) -> monitored_loop.Change:
        """Return what happens to loop and knowledge before a row."""

        def changed(loop: Loop, k: Knowledge) -> tuple[Loop, Knowledge]:
            after = self.known(row, k)
            simulation = changed_load(loop.simulation, k.sensors.plant, after.sensors.plant).simulation
            return loop._replace(simulation=simulation), after

        return changed


def begins_at(seed: int, duration: float) -> float:
    """Return when a seed's fault begins [s]: between half and 60 % of a run."""
    return duration * (0.5 + 0.1 * float(np.random.default_rng([seed, 12]).random()))
