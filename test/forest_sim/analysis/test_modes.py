"""Linearised modes are what the simulated machine does, and what small models by hand say."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from free_swings import rates_after

from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.mechanics.drives import Friction
from forest_description.mechanics.load import Pendulum
from forest_sim.analysis.friction_linearisation import without_dry_friction
from forest_sim.analysis.mode_map import mode_map
from forest_sim.analysis.modes import modes, operating_point, slow_modes, unguarded
from forest_sim.equations.plant import state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.mechanics.manipulator import dynamics
from forest_sim.simulation.open_loop import start_angles

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")
START = start_angles(C180)
SHUT = (0.0, 0.0, 0.0)


def ringing(machine, axis, seconds=4.0):
    """Frequency [Hz] and damping ratio of an axis' free swings after a small kick, valves shut."""
    h, rates = 2.5e-4, rates_after(machine, axis, 1e-4, seconds)
    falling = np.flatnonzero((rates[:-1] > 0.0) & (rates[1:] <= 0.0))[1:6]
    frequency = (len(falling) - 1) / ((falling[-1] - falling[0]) * h)
    peaks = [rates[a:b].max() for a, b in pairwise(falling)]
    decrement = math.log(peaks[0] / peaks[-1]) / (len(peaks) - 1)
    damping = decrement / math.hypot(2.0 * math.pi, decrement)
    return frequency / math.sqrt(1.0 - damping**2), damping


def test_the_swing_rings_as_its_mode_says():
    frequency, damping = ringing(C180, "swing")
    mode = slow_modes(modes(START, SHUT, plant_parameters(C180)))["swing"]
    assert mode.frequency == pytest.approx(frequency, rel=0.01)
    assert mode.damping == pytest.approx(damping, rel=0.02)


def test_the_boom_rings_as_its_mode_says():
    frequency, _ = ringing(C180, "boom")
    mode = slow_modes(modes(START, SHUT, plant_parameters(C180)))["boom"]
    assert mode.frequency == pytest.approx(frequency, rel=0.02)


def test_boom_and_stick_are_two_masses_on_the_springs_of_their_trapped_oil():
    """M q'' + K q = 0 with k = arm^2 (A_1^2/C_1 + A_2^2/C_2); gravity is a thousandth of it."""
    p = plant_parameters(THESIS)
    d = dynamics(START, SHUT, p.body)
    stiffness = [
        lever_arm(q, linkage) ** 2
        * sum(
            area**2 / line.capacitance
            for area, line in (
                (axis.actuator.displacement_1, axis.line_1),
                (axis.actuator.displacement_2, axis.line_2),
            )
        )
        for q, linkage, axis in ((START[1], p.boom_linkage, p.boom), (START[2], p.stick_linkage, p.stick))
    ]
    mass = np.array([[d.m_22, d.m_23], [d.m_23, d.m_33]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, np.diag(stiffness))))) / (
        2.0 * math.pi
    )
    slow = slow_modes(modes(START, SHUT, p))
    assert [slow["boom"].frequency, slow["stick"].frequency] == pytest.approx(expected, rel=0.02)


def test_participation_names_the_axis_and_sums_to_one():
    found = modes(START, SHUT, plant_parameters(C180))
    assert [mode.axis for mode in found] == ["swing", "boom", "stick"]
    for mode in found:
        assert sum(mode.axes) == pytest.approx(1.0)
        assert sum(mode.parts.values()) == pytest.approx(1.0)
        assert mode.kind == "links on oil"


def test_an_open_swing_valve_lets_its_lines_ring():
    found = modes(START, (10.0, 0.0, 0.0), plant_parameters(THESIS))
    lines = [mode for mode in found if mode.kind == "oil in hoses"]
    assert len(lines) == 2
    assert all(85.0 < mode.frequency < 95.0 and mode.axis == "swing" for mode in lines)


@pytest.mark.parametrize("machine", [THESIS, C180], ids=["thesis", "c180_hoses"])
def test_the_operating_point_of_open_valves_is_steady_but_for_the_angles(machine):
    p = unguarded(plant_parameters(machine))
    point = operating_point(START, (4.0, -3.0, 5.0), p)
    slopes = state_derivative(point.plant, ports_at(point.spools, p), p)
    for axis, slope in zip(point.plant[:3], slopes[:3], strict=True):
        assert abs(axis.rate) > 0.03
        # Against each state's own scale over a tenth of a second; the pose moves on, so forces do slowly.
        assert abs(slope.pressure_1) * 0.1 < 2e5
        assert abs(slope.flow_1) * 0.1 < 3e-5


def test_more_extension_makes_the_swing_slower():
    frequencies = [
        slow_modes(modes(start_angles(C180, (reach, 0.0, 1.0)), SHUT, plant_parameters(C180)))[
            "swing"
        ].frequency
        for reach in (4.6, 5.5, 6.5, 7.5)
    ]
    assert frequencies == sorted(frequencies, reverse=True)
    assert 2.2 < frequencies[-1] < frequencies[0] < 4.5


def test_a_friction_that_sticks_leaves_no_oscillation_of_its_axis():
    sticky = replace(C180, boom=replace(C180.boom, friction=Friction(4e3, 7e3, 5e-3, 1e-4)))
    assert slow_modes(modes(START, SHUT, plant_parameters(sticky)))["boom"] is None


def test_a_hanging_head_swings_as_a_pendulum_beside_the_cranes_own_modes():
    hanging = replace(C180.manipulator, pendulum=Pendulum(0.9, 60.0, 50.0))
    found = modes(START, SHUT, plant_parameters(replace(C180, manipulator=hanging)))
    swings = [mode for mode in found if mode.kind == "hanging head"]
    # A rigid pendulum on a fixed point: w^2 = m g l/(m l^2 + I); the crane under it gives way a little.
    mass = C180.manipulator.head_mass
    alone = math.sqrt(mass * 9.81 * 0.9 / (mass * 0.9**2 + 60.0)) / (2.0 * math.pi)
    assert len(swings) == 2
    for mode in swings:
        assert mode.frequency == pytest.approx(alone, rel=0.1)
    assert [mode.axis for mode in found if mode.kind == "links on oil"] == ["swing", "boom", "stick"]


def test_a_driven_pump_and_links_that_bend_have_shares_of_their_own():
    found = modes(START, SHUT, without_dry_friction(plant_parameters(load_machine("forwarder"))))
    boom = slow_modes(found)["boom"]
    assert boom.parts["bending"] > 0.1
    assert boom.parts["pump"] < 1e-6  # behind a shut valve
    assert [mode.axis for mode in found if mode.kind == "roots in links"] == ["stick", "boom"]
    assert [mode.parts["pump"] for mode in found if mode.kind == "oil and pump"] == [pytest.approx(1.0)]


def test_the_map_stays_inside_the_workspace():
    points = mode_map(C180, 0.8)
    assert len(points) > 40
    for point in points:
        start_angles(C180, (point.reach, 0.0, point.height))
        assert 2.0 < point.modes["swing"].frequency < point.modes["boom"].frequency
        assert point.modes["boom"].frequency < point.modes["stick"].frequency
    assert all(point.sliding is point.modes for point in points)
