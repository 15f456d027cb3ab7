"""The sensors of one machine along a run: their suite, the draws of chance, and what they remember.

`sensor_readings.report` runs as machine code where that has been made (`python -m
forest_sim.compiled`), and interpreted otherwise, with the same readings to the last bit.
"""

from functools import lru_cache

from forest_compile import compiled_step
from forest_compile.compiled_step import CompiledStep, Example
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel
from forest_description.geometry.kinematics import Links
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.sensor_readings import Report, Surroundings
from forest_sim.sensors.sensor_suite import EXACT_SUITE, NO_DRAWS, Suite, conditions, draw, noise_generator
from forest_sim.solver import plant_kernel
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation


class SensorRun:
    """Sensors that are asked again and again.

    Args:
        simulation: the machine at the beginning, standing still.
        plant: its parameters.
        links: of its kinematic chain.
        suite: of sensors.
        around: what they measure outside of the plant.
        run: name of the run, see `noise_generator`.
    """

    def __init__(
        self,
        simulation: Simulation,
        plant: PlantParameters,
        links: Links,
        suite: Suite,
        around: Surroundings,
        run: str = "",
    ) -> None:
        self._suite, self._links = suite, links
        is_random = suite.faults or any(channel.noise for channel in suite.channels)
        self._generator = noise_generator(suite, run) if is_random else None
        self._state = sensor_readings.at_rest(simulation, plant, suite, around)
        self._constants = sensor_readings.sensors(plant, suite, around), links
        self.at_rest = sensor_readings.report_at_rest(self._state, simulation, self._constants)
        kernel = KERNEL.ready()
        self._report = CompiledStep(kernel, _example()) if kernel else sensor_readings.report

    def set_plant(self, plant: PlantParameters, around: Surroundings) -> None:
        """From now on the plant, or what is around it, is another."""
        self._constants = self._constants[0]._replace(plant=plant, around=around), self._links

    def sample(self, simulation: Simulation, dt: float) -> Report:
        """Return what the sensors say of a machine, `dt` [s] after the last time, and what is true."""
        draws = draw(self._generator) if self._generator else NO_DRAWS
        if self._suite.faults:
            channels = conditions(self._suite, self._state.time + dt, draws.uniform)
            if channels != self._constants[0].channels:  # to lay all parameters out again takes longer
                self._constants = self._constants[0]._replace(channels=channels), self._links
        self._state, report = self._report(self._state, simulation, draws.normal, self._constants, dt)
        return report


@lru_cache(maxsize=1)
def _example() -> Example:
    """Return values of the types that all machines share."""
    machine = load_machine("c180")
    plant, links = plant_parameters(machine), machine.manipulator.links
    simulation, around = equilibrium((0.0, 0.5, -1.5), plant), sensor_readings.surroundings(machine)
    state = sensor_readings.at_rest(simulation, plant, EXACT_SUITE, around)
    known = sensor_readings.sensors(plant, EXACT_SUITE, around), links
    state, report = sensor_readings.report(state, simulation, NO_DRAWS.normal, known, PERIOD)
    return Example(state, (simulation, NO_DRAWS.normal), known, report)


def _entry() -> Entry:
    return compiled_step.entry(sensor_readings.report, _example(), plant_kernel.NOINLINE)


KERNEL = CachedKernel("sensors", _entry)
"""`sensor_readings.report` as machine code."""
