"""Records of everyday work, simulated: a hand on the levers, a closed loop, a crane that may have drifted.

A hand works in bursts, with pauses between them. The voltages are those of the closed loop; then the crane is
driven by them once more, with its sensors' errors and with logs that it grasps and drops.
"""

import numpy as np

from forest_ident.measurements.readings import read, true_columns
from forest_ident.measurements.session import Session
from forest_msgs_py.types import PERIOD
from forest_sim.sensors.sensor_readings import surroundings
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.open_loop import Run, blocks, start_angles
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver.oil_temperature import parameters_at
from forest_study.demo.synthetic_operator import RATE, hand_levers
from forest_study.notebook import closed_loop

DRIFTED = """based_on: c180_hoses
description: a crane of which three numbers have drifted
swing:
  damping: {value: 29956.8, unit: N*m*s/rad, source: "drifted: 20 % more"}
boom:
  valve:
    deadband_voltage: {value: 1.15, unit: V, source: "drifted: 15 % more"}
pump:
  supply_pressure: {value: 2640, unit: psi, source: "drifted: 12 % less"}
"""
BURST, PAUSE = (4.0, 12.0), (0.8, 2.5)  # [s]


def levers(seed, seconds):
    """Return deflections of bursts of work, a row a period."""
    generator, rows = np.random.default_rng([seed, 7]), [np.zeros((round(1.0 / PERIOD), 3))]
    while sum(len(part) for part in rows) < seconds / PERIOD:
        _, burst = hand_levers(int(generator.integers(2**31)), generator.uniform(*BURST))
        rows += [np.repeat(burst, round(1.0 / RATE / PERIOD), axis=0)]
        rows += [np.zeros((round(generator.uniform(*PAUSE) / PERIOD), 3))]
    return np.vstack(rows)[: round(seconds / PERIOD)]


def everyday_work(machine, model, seed, seconds, loads=(), units=1):
    """Return the record of a machine that is driven by a controller which believes in a model.

    The seed is that of the hand and of noise, units that of the sensors' static errors.
    """
    volts = closed_loop(machine, model=model).drive(levers(seed, seconds), seed=units)["voltages"]
    return driven(machine, volts, seed, loads, units)


def driven(machine, volts, seed, loads=(), units=1):
    """Return the record of a machine under voltages, a row a period."""
    last = len(volts) - 1

    def at(times):
        return volts[np.minimum((times / PERIOD + 1e-6).astype(int), last)]

    parts = [
        (block, parameters_at(machine, float(block.temperature[0])))
        for block in blocks(
            machine,
            Voltages("work", at, last * PERIOD),
            start_angles(machine),
            Run(last * PERIOD),
            loads=loads,
        )
    ]
    columns = []
    for block, p in parts:
        around = surroundings(machine)._replace(temperatures=(float(block.temperature[0]),) * 3)
        columns.append(true_columns(block.states, p, around))
    true = {name: np.concatenate([part[name] for part in columns]) for name in columns[0]}
    sampled = read(true, sensor_suite(machine, noise=True, seed=units), PERIOD, f"work {seed}")
    readings = {name: column for name, column in sampled.items() if not np.isnan(column).all()}
    return Session("motion", PERIOD * np.arange(len(volts)), np.asarray(volts), readings)
