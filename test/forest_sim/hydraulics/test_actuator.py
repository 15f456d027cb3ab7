"""Claims about cylinder and motor: the reduced law is that of the elements it was reduced from."""

import dataclasses

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_sim.hydraulics.actuator import (
    actuator_force,
    cylinder,
    inlet_flow,
    motor,
    outlet_flow,
    port_pressures,
)

MACHINE = load_machine("c180_hoses")
SWING = MACHINE.swing
D = SWING.gear_ratio * SWING.motor_displacement
LINES = [(MACHINE.line(axis, 1), MACHINE.line(axis, 2)) for axis in range(3)]
MOTOR = motor(SWING, *LINES[0])
# Hoses as unlike as can be, and a motor that leaks a hundred times as much: no end may stand for the other.
WORN = dataclasses.replace(SWING, internal_leakage_resistance=7e9, external_leakage_resistance=2e10)
UNLIKE = LINES[0][0]._replace(resistance=3e8), LINES[0][1]._replace(resistance=2e9)
ROUGH = UNLIKE[0]._replace(resistance=4e11), UNLIKE[1]._replace(resistance=9e10)
WORN_MOTOR = motor(WORN, *UNLIKE)
each_motor = pytest.mark.parametrize(
    ("drive", "lines", "actuator"),
    [(SWING, LINES[0], MOTOR), (WORN, UNLIKE, WORN_MOTOR)],
    ids=["c180_hoses", "worn"],
)
CYLINDERS = [
    (drive, LINES[i], cylinder(drive, *LINES[i])) for i, drive in enumerate((MACHINE.boom, MACHINE.stick), 1)
]
each_cylinder = pytest.mark.parametrize(("drive", "lines", "actuator"), CYLINDERS, ids=["boom", "stick"])
each_actuator = pytest.mark.parametrize(
    "actuator", [MOTOR, WORN_MOTOR, CYLINDERS[0][2], CYLINDERS[1][2]], ids=["swing", "worn", "boom", "stick"]
)


def states(seed, count=100):
    """Speeds [m/s; rad/s] and two pressures [Pa], over all that a crane meets."""
    return np.random.default_rng(seed).uniform((-1.0, 0.0, 0.0), (1.0, 3e7, 3e7), (count, 3)).tolist()


def motor_nodes(speed, pressure_1, pressure_2, drive, lines):
    """Solve the motor's two inner nodes by nodal analysis, conductance by conductance."""
    hoses = [1.0 / line.resistance for line in lines]
    internal, external = 1.0 / drive.internal_leakage_resistance, 1.0 / drive.external_leakage_resistance
    conductances = np.diag(hoses) + np.diag([external] * 2) + internal * np.array([[1.0, -1.0], [-1.0, 1.0]])
    sources = [hoses[0] * pressure_1 - D * speed, hoses[1] * pressure_2 + D * speed]
    return np.linalg.solve(conductances, sources)


@each_cylinder
def test_a_cylinder_takes_and_gives_the_volume_that_its_piston_sweeps(drive, lines, actuator):
    for speed, p_1, p_2 in states(1):
        assert inlet_flow(speed, p_1, p_2, actuator) == pytest.approx(drive.head_area * speed, rel=1e-12)
        assert outlet_flow(speed, p_1, p_2, actuator) == pytest.approx(drive.rod_area * speed, rel=1e-12)


@each_cylinder
def test_a_cylinders_ports_are_behind_the_turbulent_hoses(drive, lines, actuator):
    for speed, p_1, p_2 in states(2):
        one, two = port_pressures(speed, p_1, p_2, actuator)
        drops = [
            line.resistance * (area * speed) ** 2 * np.sign(speed)
            for line, area in zip(lines, (drive.head_area, drive.rod_area), strict=True)
        ]
        assert one == pytest.approx(p_1 - drops[0], rel=1e-12)
        assert two == pytest.approx(p_2 + drops[1], rel=1e-12)


@each_cylinder
def test_a_cylinders_force_is_its_ports_pressures_on_its_areas_less_viscous_friction(drive, lines, actuator):
    for speed, p_1, p_2 in states(3):
        one, two = port_pressures(speed, p_1, p_2, actuator)
        force = drive.head_area * one - drive.rod_area * two - drive.damping * speed
        assert actuator_force(speed, p_1, p_2, actuator) == pytest.approx(force, rel=1e-9, abs=1e-3)


@each_motor
def test_the_motors_ports_are_the_inner_nodes_of_its_network(drive, lines, actuator):
    for speed, p_1, p_2 in states(4):
        nodes = motor_nodes(speed, p_1, p_2, drive, lines)
        assert port_pressures(speed, p_1, p_2, actuator) == pytest.approx(nodes, rel=1e-9, abs=1.0)


@each_motor
def test_the_motors_flows_are_those_through_its_hoses(drive, lines, actuator):
    for speed, p_1, p_2 in states(5):
        one, two = motor_nodes(speed, p_1, p_2, drive, lines)
        through = (p_1 - one) / lines[0].resistance, (two - p_2) / lines[1].resistance
        assert inlet_flow(speed, p_1, p_2, actuator) == pytest.approx(through[0], rel=1e-6, abs=1e-10)
        assert outlet_flow(speed, p_1, p_2, actuator) == pytest.approx(through[1], rel=1e-6, abs=1e-10)


@each_motor
def test_the_motors_torque_is_its_ports_difference_times_displacement_less_damping(drive, lines, actuator):
    for speed, p_1, p_2 in states(6):
        one, two = motor_nodes(speed, p_1, p_2, drive, lines)
        torque = D * (one - two) - SWING.damping * speed
        assert actuator_force(speed, p_1, p_2, actuator) == pytest.approx(torque, rel=1e-9, abs=1e-3)


@each_motor
def test_what_the_motor_takes_and_does_not_give_goes_to_the_case_drain(drive, lines, actuator):
    for speed, p_1, p_2 in states(7):
        drain = sum(motor_nodes(speed, p_1, p_2, drive, lines)) / drive.external_leakage_resistance
        lost = inlet_flow(speed, p_1, p_2, actuator) - outlet_flow(speed, p_1, p_2, actuator)
        assert lost == pytest.approx(drain, rel=1e-6, abs=1e-12)


def test_a_worn_motor_behind_turbulent_hoses_leaks_by_the_pressures_at_its_own_ports():
    """What a hose takes off is R D^2 u|u|: of the flow that turns the motor, either way."""
    rough = motor(dataclasses.replace(WORN, flow_regime="turbulent"), *ROUGH)
    inside, outside = 1.0 / WORN.internal_leakage_resistance, 1.0 / WORN.external_leakage_resistance
    for speed, p_1, p_2 in states(9):
        one = p_1 - ROUGH[0].resistance * D * D * speed * abs(speed)
        two = p_2 + ROUGH[1].resistance * D * D * speed * abs(speed)
        assert port_pressures(speed, p_1, p_2, rough) == pytest.approx((one, two), rel=1e-12)
        across = D * speed + (one - two) * inside
        assert inlet_flow(speed, p_1, p_2, rough) == pytest.approx(
            across + one * outside, rel=1e-9, abs=1e-12
        )
        assert outlet_flow(speed, p_1, p_2, rough) == pytest.approx(
            across - two * outside, rel=1e-9, abs=1e-12
        )
        torque = D * (one - two) - WORN.damping * speed
        assert actuator_force(speed, p_1, p_2, rough) == pytest.approx(torque, rel=1e-9, abs=1e-3)


@each_actuator
def test_an_actuator_never_gives_more_power_than_it_takes(actuator):
    for speed, p_1, p_2 in states(8, 300):
        hydraulic = p_1 * inlet_flow(speed, p_1, p_2, actuator) - p_2 * outlet_flow(speed, p_1, p_2, actuator)
        mechanical = actuator_force(speed, p_1, p_2, actuator) * speed
        assert hydraulic - mechanical >= -1e-9 * abs(hydraulic)
    assert actuator_force(0.3, 0.0, 0.0, actuator) < 0.0 < actuator_force(-0.3, 0.0, 0.0, actuator)
