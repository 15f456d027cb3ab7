"""Claims about load feedback: whose valves give way, and by how much."""

import math
from dataclasses import replace

import numpy as np
import pytest
from unlike_ways import with_unlike_ways

from forest_control.servo.arm_feedforward import arm_inertia, arm_model
from forest_control.servo.swing_feedforward import inertia, swing_model
from forest_control.valve.load_estimate import STILL, Pressures, plausible
from forest_control.valve.load_feedback import DAMPING, load_feedback, moved_mass
from forest_control.valve.valve_driver import REST, step
from forest_control.valve.valve_driver_parameters import Settings, axis_drivers, parameters
from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine

FORWARDER = load_machine("forwarder")
UNHELD = replace(
    FORWARDER,
    boom=replace(FORWARDER.boom, holding_1=None),
    stick=replace(FORWARDER.stick, holding_1=None, holding_2=None),
)
P = with_unlike_ways(parameters(UNHELD, Settings()))
DT = 0.005


@pytest.mark.parametrize("name", ["c180", "forwarder", "loader"])
def test_what_moves_is_the_controllers_inertia_over_the_lever_arm_squared(name):
    machine = load_machine(name)
    _, boom, stick = joint_limits(machine)
    q = (0.0, 0.5 * sum(boom), 0.5 * sum(stick))
    m_22, _, m_33 = arm_inertia(q, arm_model(machine))
    arms = [lever_arm(q[axis], machine.linkages[axis - 1]) for axis in (1, 2)]
    assert moved_mass(machine, 1) == pytest.approx(m_22 / arms[0] ** 2, rel=1e-9)
    assert moved_mass(machine, 2) == pytest.approx(m_33 / arms[1] ** 2, rel=1e-9)
    assert moved_mass(machine, 0) == pytest.approx(inertia(q, swing_model(machine)), rel=0.03)


def test_a_mass_on_a_spring_of_oil_is_damped_by_the_stated_ratio():
    """m v' = k x, x' = -c k x - v: its poles have the damping ratio c sqrt(k m)/2."""
    mass, stiffness = moved_mass(FORWARDER, 1), 5e7
    c = load_feedback(FORWARDER, 1, stiffness)
    poles = np.linalg.eigvals([[0.0, stiffness / mass], [-1.0, -c * stiffness]])
    assert -poles.real / np.abs(poles) == pytest.approx([DAMPING, DAMPING])


def test_valves_give_way_whose_flow_heeds_no_load_and_no_others():
    assert all(axis.load_feedback > 0.0 for axis in axis_drivers(FORWARDER))
    for name in ("c180", "c180_hoses", "c180_thesis", "loader"):
        assert [axis.load_feedback for axis in axis_drivers(load_machine(name))] == [0.0] * 3


def pushed(command, push):
    """Return the spools [V] that are asked for before and after a push by port 1's pressures [Pa]."""
    base = 0.4 * P.supply_pressure
    state, volts = REST, []
    for added in [0.0] * 100 + [push]:
        pressures = Pressures((base + added,) * 3, (base,) * 3, P.supply_pressure)
        assert plausible(pressures, P)
        state, _ = step(state, (command,) * 3, pressures, STILL, P, DT)
        volts.append(state.voltages)
    return np.array(volts[-2]), np.array(volts[-1])


@pytest.mark.parametrize("command", [2.0, -2.0])
def test_a_load_that_grows_takes_speed_off_and_one_that_shrinks_adds_it(command):
    for push in (3e5, -3e5):
        before, after = pushed(command, push)
        assert (np.sign(after - before) == -math.copysign(1.0, push)).all()


@pytest.mark.parametrize("command", [2.0, -2.0])
@pytest.mark.parametrize("push", [3e5, -3e5])
def test_what_is_taken_off_is_the_feedback_s_share_of_what_the_load_has_grown_by(command, push):
    for i, axis in enumerate(P.axes):
        grown = axis.displacement_1 * push * math.exp(-P.load_bandwidth * DT)
        given = axis.load_feedback * grown / axis.rated_speed * axis.valve.forward.rated_voltage
        assert 0.0 < abs(given) < abs(command)
        less = pushed(command - given, 0.0)[0][i]
        assert pushed(command, push)[1][i] == pytest.approx(less, rel=1e-4)  # of a motor a little leaks


@pytest.mark.parametrize("push", [24e6, -9e6])
def test_it_never_turns_a_valve_round_nor_asks_for_more_than_twice_the_command(push):
    for command in (0.1, -0.1):
        _, after = pushed(command, push)
        twice = pushed(2.0 * command, 0.0)[0]
        assert (after * command >= 0.0).all()
        assert (np.abs(after) <= np.abs(twice) + 1e-9).all()


def test_a_load_that_rocks_moves_no_valve_that_is_held():
    before, after = pushed(0.0, 24e6)
    assert before.tolist() == after.tolist() == [0.0, 0.0, 0.0]
