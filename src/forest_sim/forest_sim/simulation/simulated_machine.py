"""A machine that runs on and on: plant, oil and sensors together, one sampling period at a time.

What the simulator node wraps. Faults, load and the force on the tip may change between two periods.
"""

import math

from forest_description.derived.passive_joints import head_joint_positions
from forest_description.derived.tip_over import Margins, tip_over_margins
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.sensor_readings import Report
from forest_sim.sensors.sensor_run import SensorRun
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.simulation.changing_plant import ChangingPlant
from forest_sim.simulation.disturbance import Disturbance
from forest_sim.simulation.load_schedule import Load, Loads, by_period
from forest_sim.solver.compiled_plant import ready_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Events, advance
from forest_sim.solver.oil_temperature import WarmingOil

STEP = 1e-3  # [s] of the integrator


class SimulatedMachine:
    """State of plant, oil and sensors."""

    def __init__(
        self,
        machine: Machine,
        angles: Vec3,
        suite: Suite,
        period: float,
        warms: bool = True,
        rig: bool = False,
        run: str = "",
        loads: Loads = (),
    ) -> None:
        """Start at rest at the joint angles [rad].

        Args:
            machine: what is simulated.
            angles: [rad].
            suite: of sensors.
            period: [s], a whole number of steps.
            warms: its oil does, if it is described.
            rig: it is a test rig, see `sensors.Surroundings`.
            run: name of the run, see `noise_generator`.
            loads: logs that its head grasps and drops.
        """
        self.machine, self._period = machine, period
        self._changes, self._periods = by_period(loads, 1.0 / period), 0
        self._substeps = round(period / STEP)
        compiled = ready_advance()
        self.is_compiled = compiled is not None
        self._advance = compiled or advance
        self._plant = ChangingPlant(machine)
        self._simulation = equilibrium(angles, self._plant.p)
        self._around = sensor_readings.surroundings(machine)._replace(rig=rig)
        links = machine.manipulator.links
        self._sensors = SensorRun(self._simulation, self._plant.p, links, suite, self._around, run)
        self._oil = WarmingOil(machine.oil, period) if machine.oil and warms else None

    @property
    def events(self) -> Events:
        """What has been counted since the start."""
        return self._simulation.events

    @property
    def head_joints(self) -> tuple[float, ...]:
        """Position [rad] and rate [rad/s] of a hanging head's joints, and NaN for their efforts."""
        plant = self._simulation.plant
        head, angles = plant.head, (plant.swing.angle, plant.boom.angle, plant.stick.angle)
        rates = head.alpha_rate - plant.boom.rate - plant.stick.rate, head.beta_rate
        return (*head_joint_positions(angles, (head.alpha, head.beta)), *rates, math.nan, math.nan)

    @property
    def deflections(self) -> Vec3:
        """By how much the links are ahead of their joints [rad]."""
        return sensor_readings.deflections(self._simulation, self._plant.p)

    @property
    def pump(self) -> tuple[float, float]:
        """The pump's displacement over its greatest [1], and the engine's speed [rad/s]."""
        return sensor_readings.pump(self._simulation, self._plant.p)

    @property
    def tank_line(self) -> tuple[float]:
        """Pressure behind the valves [Pa]."""
        return (self._simulation.midpoint.tank.pressure,)

    @property
    def compensators(self) -> Vec3:
        """Openings of the valves' pressure compensators [1]; NaN for a valve without one."""
        return sensor_readings.compensators(self._simulation, self._plant.p)

    @property
    def tip_over(self) -> Margins:
        """How far a vehicle is from tipping over; of a machine with a chassis [1]."""
        assert self.machine.chassis is not None
        plant, m = self._simulation.plant, self.machine.manipulator
        angles = plant.swing.angle, plant.boom.angle, plant.stick.angle
        return tip_over_margins(self.machine.chassis, m, angles, self.load.mass)

    @property
    def at_rest(self) -> Report:
        """What the sensors said before the first step, and the truth."""
        return self._sensors.at_rest

    def disturb(self, disturbance: Disturbance) -> None:
        """Let spools be stuck and a force act on the tip, from now on."""
        self._plant.disturb(disturbance)
        self._sensors.set_plant(self._plant.p, self._around)

    @property
    def load(self) -> Load:
        """The log that the head holds."""
        return self._plant.load

    def hold(self, load: Load) -> None:
        """Let the head hold another log, from now on: what is heavier joins, what is lighter was dropped."""
        self._simulation = self._plant.hold(load, self._simulation).simulation
        self._sensors.set_plant(self._plant.p, self._around)

    def step(self, voltages: Vec3) -> Report:
        """Move on by a period under held voltages [V]; return what the sensors say then, and the truth."""
        if self._periods in self._changes:
            self.hold(self._changes[self._periods])
        self._periods += 1
        self._simulation = self._advance(self._simulation, voltages, STEP, self._substeps, self._plant.p)
        report = self._sensors.sample(self._simulation, self._period)
        if self._oil is not None and self._oil.has_warmed(lambda: self._simulation, self._plant.p):
            self._warm(self._oil.temperature)  # for the periods to come
        return report

    def _warm(self, temperature: float) -> None:
        """Take the parameters of a temperature of the oil [K]."""
        self._plant.warm(temperature)
        self._around = self._around._replace(temperatures=(temperature,) * 3)
        self._sensors.set_plant(self._plant.p, self._around)
