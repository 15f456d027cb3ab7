"""The monitor: a sample of everything that is there in, sums of residuals and the sensors' state out.

    readings -> residuals (every bin) -> sequential tests;   readings -> sensors (every window)

What the sums mean is told by `findings`.
"""

from typing import NamedTuple

from forest_ident.diagnosis import monitor_readings
from forest_ident.diagnosis.monitor_readings import Readings
from forest_ident.diagnosis.residual_parameters import Parameters as MachineNumbers
from forest_ident.diagnosis.residuals import COUNT as RESIDUALS
from forest_ident.diagnosis.residuals import Residuals, updated
from forest_ident.diagnosis.sensor_watch import UNSEEN, Sensor, heard, judged
from forest_ident.diagnosis.sequential_test import NEW, Limits, Test, tested

WINDOW = 5.0  # bins


class Parameters(NamedTuple):
    """The machine, and what is allowed to each residual of `residuals.NAMES`."""

    machine: MachineNumbers
    limits: tuple[Limits, ...]


class State(NamedTuple):
    """What the monitor remembers."""

    residuals: Residuals = Residuals()
    tests: tuple[Test, ...] = (NEW,) * RESIDUALS
    sensors: tuple[Sensor, ...] = (UNSEEN,) * monitor_readings.COUNT
    bins: float = 0.0  # of the window
    stood: int = 1  # 1: the machine has stood all the window


BEGIN = State()


def step(state: State, r: Readings, p: Parameters, dt: float) -> State:
    """Return the state after a sample, dt [s] after the last one."""
    found = updated(state.residuals, r, p.machine, dt)
    channels = monitor_readings.channels(r)
    sensors = tuple([heard(state.sensors[i], channels[i]) for i in range(monitor_readings.COUNT)])
    if found.ended == 0:
        return state._replace(residuals=found, sensors=sensors)
    values = found.values
    tests = tuple([tested(state.tests[i], values[i], p.limits[i]) for i in range(RESIDUALS)])
    stood, bins = state.stood * found.stands, state.bins + 1.0
    if bins < WINDOW:
        return State(found, tests, sensors, bins, stood)
    stands = stood == 1
    sensors = tuple([judged(sensors[i], stands) for i in range(monitor_readings.COUNT)])
    return State(found, tests, sensors, 0.0, 1)


def quiet(state: State) -> State:
    """Return a state that keeps what it has learnt, and no alarm."""
    return state._replace(tests=tuple(test._replace(high=0.0, low=0.0) for test in state.tests))
