"""The loader crane in motion: at rest it stays, every axis goes both ways, and no jerk breaks the solver."""

import math
from functools import lru_cache

import numpy as np
import pytest

from forest_description.derived.actuator_kinematics import rated_speeds
from forest_description.derived.limits import joint_limits, pose_at, start_tip
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium

LOADER = load_machine("loader")
P = plant_parameters(LOADER)
START = pose_at(start_tip(LOADER), LOADER)
REACHED_OUT = (0.0, 0.1, -0.7)
SHUT = (0.0, 0.0, 0.0)
STEP = 1e-3
RATED = tuple(LOADER.valve_of(axis).rated_voltage for axis in range(3))
BAR = 1e5
EVERY_AXIS = pytest.mark.parametrize("axis", range(3), ids=("swing", "boom", "stick"))


def advance(simulation, voltages, steps=1):
    return compiled_advance()(simulation, voltages, STEP, steps, P)


def angles(simulation):
    return np.array([axis.angle for axis in simulation.plant[:3]])


def pressures(simulation):
    return np.array([p for axis in simulation.plant[:3] for p in (axis.pressure_1, axis.pressure_2)])


def on_axis(axis, volts):
    return tuple(volts if i == axis else 0.0 for i in range(3))


@pytest.mark.parametrize("pose", [START, REACHED_OUT, (2.0, 1.0, -2.2)], ids=["middle", "out", "folded"])
def test_it_stands_in_equilibrium_but_for_what_its_spools_leak(pose):
    rest = equilibrium(pose, P)
    soon = advance(rest, SHUT, 100)
    np.testing.assert_allclose(angles(soon), pose, atol=1e-5)
    later = advance(rest, SHUT, 10_000)
    np.testing.assert_allclose(angles(later), pose, atol=5e-4)  # 2 mm at the tip in 10 s
    assert later.plant.head[:2] == pytest.approx(rest.plant.head[:2], abs=1e-4)
    assert rest.plant.supply.pressure == pytest.approx(LOADER.pump.margin, rel=0.01)


# Joint rates from 1 to 1.3 s after a valve opened fully, from the middle of the strokes [rad/s].
SPEEDS = {(0, 1): 1.13, (0, -1): -1.13, (1, 1): 0.48, (1, -1): -0.39, (2, 1): 0.63, (2, -1): -0.54}


@pytest.mark.parametrize(("axis", "sign"), SPEEDS)
def test_every_axis_moves_both_ways_at_a_sensible_speed(axis, sign):
    started = advance(equilibrium(START, P), on_axis(axis, sign * RATED[axis]), 1000)
    moved = advance(started, on_axis(axis, sign * RATED[axis]), 300)
    rates = (angles(moved) - angles(started)) / 0.3
    assert rates[axis] == pytest.approx(SPEEDS[axis, sign], abs=0.02)
    others = [abs(rates[i]) for i in range(3) if i != axis]
    assert max(others) < 0.02


def test_rated_speeds_are_what_the_pump_and_the_open_valve_give():
    """The margin of the load-sensing pump, less its droop, or its full flow sets them; not its pressure."""
    for axis, linkage in ((1, P.boom_linkage), (2, P.stick_linkage)):
        started = advance(equilibrium(START, P), on_axis(axis, RATED[axis]), 1000)
        speed = started.plant[axis].rate * lever_arm(started.plant[axis].angle, linkage)
        assert speed == pytest.approx(rated_speeds(LOADER)[axis], rel=0.15)


@EVERY_AXIS
def test_oscillations_behind_shut_valves_are_slow_for_the_swing_and_faster_for_the_cylinders(axis):
    rest = equilibrium(REACHED_OUT, P)
    joints = list(rest.plant)
    joints[axis] = joints[axis]._replace(rate=0.05)
    simulation = rest._replace(plant=type(rest.plant)(*joints))
    rates = []
    for _ in range(2000):
        simulation = advance(simulation, SHUT)
        rates.append(simulation.plant[axis].rate)
    spectrum = np.abs(np.fft.rfft(rates, 8 * len(rates)))
    natural = np.fft.rfftfreq(8 * len(rates), STEP)[spectrum.argmax()]
    low, high = ((1.5, 4.0), (6.0, 20.0), (8.0, 25.0))[axis]
    assert low < natural < high
    assert np.abs(rates[-200:]).max() < 0.3 * np.abs(rates[:200]).max()


@lru_cache(maxsize=1)
def violent_session():
    """Return states every 10 ms of 20 s in which valves jump between shut and wide open all the time."""
    simulation, states = equilibrium(START, P), []
    for levels in np.random.default_rng(2).integers(-1, 2, (200, 3)).tolist():
        volts = tuple(level * rated for level, rated in zip(levels, RATED, strict=True))
        for _ in range(10):
            simulation = advance(simulation, volts, 10)
            states.append(simulation)
    return states


def test_no_stage_of_a_violent_session_fails():
    last = violent_session()[-1]
    assert last.events.unconverged_stages == 0
    assert last.events.relief_openings > 0  # it was violent
    assert np.all(np.isfinite([*angles(last), *pressures(last), *last.plant.head]))


def test_in_a_violent_session_end_stops_give_little_and_relief_valves_keep_the_pressure():
    low, high = np.array(joint_limits(LOADER)).T
    visited = np.array([angles(state) for state in violent_session()])
    assert np.ptp(visited, axis=0).min() > 0.2
    assert np.all(np.minimum(visited - low, high - visited) > -math.radians(0.5))
    felt = np.array([pressures(state) for state in violent_session()]) / BAR
    assert felt.min() > -1.0
    assert felt.max() < 240.0


@pytest.mark.parametrize("sign", [1, -1], ids=["extending", "retracting"])
@pytest.mark.parametrize("axis", [1, 2], ids=["boom", "stick"])
def test_full_speed_against_the_end_of_the_stroke_ends_at_the_stop(axis, sign):
    simulation = equilibrium(START, P)
    for _ in range(50):
        simulation = advance(simulation, on_axis(axis, sign * RATED[axis]), 200)
    low, high = joint_limits(LOADER)[axis]
    end = high if sign > 0 else low
    assert simulation.plant[axis].angle == pytest.approx(end, abs=math.radians(0.5))
    assert abs(simulation.plant[axis].rate) < 1e-3
    assert simulation.events.unconverged_stages == 0
