"""An experiment on a simulated machine: the scripted operator, the plant, the sensors, without a graph.

It is what the graph in lockstep does, much faster: row k is step k + 1, and with exact sensors voltages and
states are the same to the last bit, what is derived of them to rounding. With noise they are not: the
operator sees the true angles here, and the sensors draw in another order. The oil warms as it does in
`forest_sim.simulation.open_loop`; a bench's is kept at one temperature by its cooler.
"""

from __future__ import annotations

import numpy as np

from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_ident.experiments import excitation
from forest_ident.measurements.readings import PLACE, Columns, read, true_columns
from forest_ident.measurements.session import Session
from forest_msgs_py.types import PERIOD
from forest_sim.sensors.sensor_readings import surroundings
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.solver.compiled_plant import FlatPlant
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.oil_temperature import (
    UPDATE_PERIOD,
    dissipated_power,
    parameters_at,
    temperature_after,
)
from forest_sim.solver.plant_parameters import PlantParameters, plant_parameters
from forest_sim.solver.power_flows import power_flows

SUBSTEPS = 5
STANDING: Vec3 = (0.0, 0.0, 0.0)  # [V]
LOSS_SAMPLES = 10  # of the power that warms the oil, in an update of its temperature


def run(
    name: str,
    machine: Machine,
    programme: excitation.Programme,
    angles: Vec3,
    suite: Suite,
    bench: bool = False,
) -> Session:
    """Return the record of an experiment.

    Args:
        name: of the experiment.
        machine: the crane, or a circuit of `bench`.
        programme: what the operator does.
        angles: joint angles at the start [rad].
        suite: the sensors.
        bench: whether it is a circuit: second meter at hose 1's far end, oil at one temperature.
    """
    trace = _Trace(machine, angles, bench)
    trace.advance(STANDING)  # before the graph's first step
    state = excitation.START
    count = round(programme.duration / PERIOD)
    voltages = np.zeros((count, 3))
    for k in range(count):
        state, volts = excitation.step(state, trace.angles(), programme, PERIOD)
        voltages[k] = volts
        if k + 1 < count:
            trace.advance(volts)
    true = {channel: column[1:] for channel, column in trace.columns(machine).items()}
    readings = {
        channel: column
        for channel, column in read(true, suite, PERIOD, name).items()
        if not np.isnan(column).all()
    }
    facts = {}
    if not bench and "case_drain" in true:
        facts["case_drain_volume"] = float(np.sum(true["case_drain"]) * PERIOD)
    return Session(name, PERIOD * np.arange(count, dtype=np.float64), voltages, readings, facts)


class _Trace:
    """A machine under way, and all its states until now."""

    def __init__(self, machine: Machine, angles: Vec3, bench: bool) -> None:
        self._machine, self._bench = machine, bench
        p = plant_parameters(machine)
        self._oil = None if bench else machine.oil
        self._temperature = machine.oil.reference_temperature if machine.oil else 313.15
        self._flat = FlatPlant()
        self._flat.lay_out(equilibrium(angles, p))
        self._flat.set_parameters(p)
        self._rows = [self._flat.state.copy()]
        self._plants: list[tuple[int, PlantParameters, float]] = [(0, p, self._temperature)]
        self._losses: list[float] = []

    def angles(self) -> Vec3:
        """Return the joint angles [rad]."""
        s = self._flat.state
        return float(s[0]), float(s[6]), float(s[12])

    def advance(self, volts: Vec3) -> None:
        """Move on by a period."""
        self._flat.advance(volts, PERIOD / SUBSTEPS, SUBSTEPS)
        self._rows.append(self._flat.state.copy())
        if self._oil is not None:
            self._warm()

    def _warm(self) -> None:
        per_update, count = round(UPDATE_PERIOD / PERIOD), len(self._rows) - 1
        if self._oil is None or count % (per_update // LOSS_SAMPLES) != 0:
            return
        p = self._plants[-1][1]
        self._losses.append(dissipated_power(power_flows(self._flat.simulation, p)))
        if count % per_update != 0:
            return
        mean = sum(self._losses) / len(self._losses)
        self._losses.clear()
        self._temperature = temperature_after(self._temperature, mean, self._oil, UPDATE_PERIOD)
        p = parameters_at(self._machine, self._temperature)
        self._flat.set_parameters(p)
        self._plants.append((count + 1, p, self._temperature))

    def columns(self, machine: Machine) -> Columns:
        """Return the true value of every channel over the run."""
        states, around = np.array(self._rows), surroundings(machine)
        plants = [plant for plant in self._plants if plant[0] < len(states)]
        ends = [first for first, _, _ in plants[1:]] + [len(states)]
        parts = [
            true_columns(states[first:end], p, around._replace(temperatures=(t, t, t)), self._bench)
            for (first, p, t), end in zip(plants, ends, strict=True)
        ]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


assert PLACE["swing_angle"] == 0  # `_Trace.angles` counts on six columns per axis
assert PLACE["stick_angle"] == 12
