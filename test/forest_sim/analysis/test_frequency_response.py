"""A joint's answer to its spool: as the simulated machine answers a small oscillation in motion."""

import math
from dataclasses import replace

import numpy as np
import pytest

from forest_description.derived.limits import start_tip
from forest_description.machine import load_machine
from forest_sim.analysis.frequency_response import response_of, spool_response
from forest_sim.analysis.modes import operating_point, unguarded
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.spool_dynamics import CENTRED, SpoolLag, spool_after
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.compiled_plant import fastest_record
from forest_sim.solver.state_recording import ENERGY, STATE
from forest_sim.solver.step_schedule import even

STEP = 1e-3  # [s]
AT_ONCE = SpoolLag(math.inf, 0.0)


def answered(machine, angles, axis, volts, rate, frequency, amplitude=0.02, cycles=24):
    """Return the joint's rate over its spool, amplitude and phase, when it comes through the pose.

    It is half the difference of two runs: what the motion itself changes cancels.
    """
    p = unguarded(plant_parameters(machine))
    p = p._replace(valves=tuple(valve._replace(lag=AT_ONCE) for valve in p.valves))
    spools = tuple(volts if place == axis else 0.0 for place in range(3))
    count = round(cycles / frequency / STEP)
    before = rate * STEP * (count - 0.5 / frequency / STEP)
    begun = tuple(angle - before * (place == axis) for place, angle in enumerate(angles))
    point = operating_point(begun, spools, p)
    time = STEP * np.arange(count)
    rates = []
    for sign in (1.0, -1.0):
        given = np.tile(spools, (count, 1))
        given[:, axis] += sign * amplitude * np.sin(2.0 * np.pi * frequency * (time + 0.5 * STEP))
        states = np.zeros((count, len(STATE)))
        fastest_record()(point, given, even(STEP, count, 1), p, states, np.zeros((count, len(ENERGY))))
        rates.append(states[:, STATE.index(f"{('swing', 'boom', 'stick')[axis]}_root_rate")])
    wave = 0.5 * (rates[0] - rates[1])
    last = slice(count - round(1.0 / frequency / STEP), count)  # a whole cycle, the start's transient gone
    turning = np.exp(-2j * np.pi * frequency * (time[last] + STEP))
    return 2j * np.mean(wave[last] * turning) / amplitude


@pytest.mark.parametrize(("axis", "volts"), [(0, 4.0), (1, 2.5), (2, -3.0)])
@pytest.mark.parametrize("frequency", [8.0, 20.0])
def test_the_simulated_machine_answers_so(axis, volts, frequency):
    """The boom moves slowly: what rings on from poses that it has left is not in the linear answer."""
    hanging = load_machine("c180")  # a head that hangs sways on for longer than is measured
    machine = replace(hanging, manipulator=replace(hanging.manipulator, pendulum=None))
    angles = start_angles(machine, start_tip(machine))
    rate, told, *_ = response_of(angles, axis, volts, plant_parameters(machine), np.array([frequency]))
    assert rate * volts > 0.0
    measured = answered(machine, angles, axis, volts, rate, frequency)
    assert abs(measured - told[0]) < 0.03 * abs(told[0])


@pytest.mark.parametrize(("axis", "frequency"), [(0, 8.0), (1, 8.0), (1, 20.0)])
def test_a_machine_with_compensators_and_bending_answers_so(axis, frequency):
    """Compensators follow the oscillation; sensors sit at the links' roots. Frozen ones are far off."""
    hanging = load_machine("forwarder")
    machine = replace(hanging, manipulator=replace(hanging.manipulator, pendulum=None))
    angles, p = start_angles(machine, start_tip(machine)), plant_parameters(machine)
    rate, told, *_ = response_of(angles, axis, 4.0, p, np.array([frequency]))
    measured = answered(machine, angles, axis, 4.0, rate, frequency, cycles=round(1.5 * frequency))
    assert abs(measured - told[0]) < 0.03 * abs(told[0])


def test_a_shut_valve_has_no_answer():
    machine = load_machine("c180_hoses")
    with pytest.raises(ValueError, match="allowed: more than its deadband"):
        response_of((0.0, 0.5, -1.5), 1, 0.0, plant_parameters(machine), np.array([1.0]))


def test_a_dead_time_turns_the_phase_alone():
    frequency = np.array([1.0, 12.0, 40.0])
    late, lag = (spool_response(SpoolLag(60.0, 0.7, dead_time=t), frequency) for t in (0.008, 0.0))
    assert late / lag == pytest.approx(np.exp(-2j * np.pi * frequency * 0.008))


@pytest.mark.parametrize("lag", [SpoolLag(60.0, 0.0), SpoolLag(60.0, 0.7)])
def test_a_spool_answers_as_its_law_does(lag):
    frequency, step = 12.0, 1e-5
    spool, seen = CENTRED, []
    times = step * np.arange(round(2.0 / step))
    for time in times.tolist():
        spool = spool_after(spool, math.sin(2.0 * math.pi * frequency * (time + 0.5 * step)), step, lag)
        seen.append(spool.position)
    last = slice(-round(4.0 / frequency / step), None)
    measured = 2j * np.mean(np.array(seen)[last] * np.exp(-2j * np.pi * frequency * (times[last] + step)))
    assert abs(measured - spool_response(lag, np.array([frequency]))[0]) < 1e-3
    assert spool_response(AT_ONCE, np.array([frequency]))[0] == 1.0
