"""The parameters of a machine under way: its oil warms, its load changes, and it is disturbed."""

from forest_description.machine import Machine
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.simulation.disturbance import UNDISTURBED, Disturbance, disturbed
from forest_sim.simulation.load_schedule import Load, loaded, own_load
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.load_change import LoadChange, changed_load
from forest_sim.solver.oil_temperature import parameters_at


class ChangingPlant:
    """What the plant's equations need, kept up to date.

    Args:
        machine: whose parameters they are.
        disturbance: that acts from the start.
    """

    def __init__(self, machine: Machine, disturbance: Disturbance = UNDISTURBED) -> None:
        self._machine, self._disturbance = machine, disturbance
        self._alone = plant_parameters(machine)
        self.load = own_load(machine.manipulator)
        """The log that the head holds."""
        self.p = self._parameters()
        """The parameters."""

    def warm(self, temperature: float) -> None:
        """Take the parameters of a temperature of the oil [K]."""
        self._alone = parameters_at(self._machine, temperature)
        self.p = self._parameters()

    def disturb(self, disturbance: Disturbance) -> None:
        """Take another disturbance."""
        self._disturbance = disturbance
        self.p = self._parameters()

    def hold(self, load: Load, simulation: Simulation) -> LoadChange:
        """Take another log into the head; return what that does to the machine."""
        before, self.load = self.p, load
        self.p = self._parameters()
        return changed_load(simulation, before, self.p)

    def _parameters(self) -> PlantParameters:
        return disturbed(loaded(self._alone, self._machine.manipulator, self.load), self._disturbance)
