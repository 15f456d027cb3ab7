"""What the graph's topics would have said during a run: the sensors' reports and the simulator's truth.

The one place of offline runs that knows the sensors; columns as `forest_msgs_py.encoding.columns` has them.
"""

import numpy as np
from numpy.typing import NDArray

from forest_description.kinematics import tip_position, tip_velocity
from forest_description.machine import Machine
from forest_msgs_py import topics
from forest_msgs_py.topics import Topic
from forest_sim import sensors
from forest_sim.integrator import Simulation
from forest_sim.parameters import plant_parameters
from forest_sim.recording import restore
from forest_sim.simulation import Block

Floats = NDArray[np.float64]
Observed = dict[Topic, Floats]

OBSERVED = (
    topics.JOINT_STATES,
    topics.ACTUATOR_STATES,
    topics.PRESSURES,
    topics.FLOWS,
    topics.SUPPLY,
    topics.AUXILIARY,
    topics.GROUND_TRUTH_JOINT_STATES,
    topics.GROUND_TRUTH_TIP_POSE,
    topics.GROUND_TRUTH_TIP_TWIST,
    topics.VALVE_VOLTAGES,
)


class Observer:
    """Sensors along a run; they remember, so blocks come in order."""

    def __init__(self, machine: Machine, rate: float) -> None:
        self._plant, self._links = plant_parameters(machine), machine.manipulator.links
        self._period = 1.0 / rate
        self._estimate: sensors.SpeedEstimate | None = None

    def observe(self, block: Block) -> Observed:
        """Return the numbers of every topic, one row per row of the block."""
        rows = [self._sample(restore(row)) for row in block.states]
        observed = {
            topic: np.array(column, dtype=np.float64)
            for topic, column in zip(OBSERVED[:-1], zip(*rows, strict=True), strict=True)
        }
        observed[topics.VALVE_VOLTAGES] = block.voltages
        return observed

    def _sample(self, simulation: Simulation) -> tuple[tuple[float, ...], ...]:
        """Return one row of every topic but the voltages."""
        if self._estimate is None:
            self._estimate = sensors.at_rest(simulation, self._plant)
        self._estimate, seen = sensors.measure(simulation, self._estimate, self._plant, self._period)
        true = sensors.true_joints(simulation, self._plant)
        spools = (spool.position for spool in simulation.spools)
        return (
            _motion(seen.joints),
            _motion(seen.actuators),
            seen.pressures,
            seen.flows,
            (seen.supply_pressure, seen.supply_flow, seen.supply_saturation),
            (*spools, seen.case_drain_flow, 0.0),
            _motion(true),
            tip_position(true.position, self._links),
            tip_velocity(true.position, true.speed, self._links),
        )


def _motion(motion: sensors.Motion) -> tuple[float, ...]:
    return (*motion.position, *motion.speed, *motion.effort)
