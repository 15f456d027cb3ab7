"""Claims about the power balance: what flows into a part is lost there, stored there or handed on."""

from dataclasses import replace

import numpy as np
import pytest
from energies import kinetic_energy, pendulum_kinetic_energy, pendulum_potential_energy, potential_energy
from full_machine import pack, unpack

from forest_description.geometry.kinematics import inverse_kinematics, tip_velocity
from forest_description.machine import load_machine
from forest_description.mechanics.drives import Cushion, Friction
from forest_description.mechanics.load import Pendulum
from forest_sim.equations.plant import state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.power_flows import power_flows

THESIS, C180, REAL = (load_machine(name) for name in ("c180_thesis", "c180_hoses", "c180"))
LEAKY = replace(C180.valve, deadband_voltage=-0.3, leakage_conductance=1e-13, port_2_area=0.7)
RUBBING = replace(
    C180.boom, friction=Friction(4e3, 7e3, 5e-3, 1e-3), cushion=Cushion(0.1, 5e6), flow_regime="laminar"
)
# A pump far too weak: the load checks shut and open all the time.
CHECKED = replace(C180, valve=replace(LEAKY, load_check="ideal"), pump=replace(C180.pump, displacement=1e-6))
EVERYTHING = replace(C180, valve=LEAKY, boom=RUBBING, swing=replace(C180.swing, flow_regime="turbulent"))
HANGING = replace(
    C180,
    manipulator=replace(
        C180.manipulator, platform_tilt=0.15, pendulum=Pendulum(length=1.1, inertia=150.0, damping=400.0)
    ),
)
MACHINES = [
    pytest.param(THESIS, id="thesis"),
    pytest.param(C180, id="c180_hoses"),
    pytest.param(EVERYTHING, id="everything"),
    pytest.param(CHECKED, id="load checks"),
    pytest.param(REAL, id="c180"),
    pytest.param(load_machine("forwarder"), id="forwarder"),
    pytest.param(replace(REAL, valve=LEAKY, boom=replace(REAL.boom, flow_regime="laminar")), id="leaking"),
]


def violent_states(machine, seconds=6.0):
    """States of a session with random steps of all three voltages, and the machine's parameters."""
    rng, p = np.random.default_rng(5), plant_parameters(machine)
    advance = compiled_advance()
    simulation = equilibrium(inverse_kinematics((5.5, 0.0, 1.0), machine.manipulator.links), p)
    for _ in range(round(seconds / 0.3)):
        voltages = tuple(rng.uniform(-10.0, 10.0, 3).tolist())
        for _ in range(20):
            simulation = advance(simulation, voltages, 1e-3, 15, p)
            yield simulation, p


def gap(*terms):
    """What is left of a balance, as a share of the power that flows through it."""
    return abs(sum(terms)) / max(1.0, sum(abs(term) for term in terms))


@pytest.mark.parametrize("machine", MACHINES)
def test_every_part_hands_on_what_it_neither_loses_nor_stores(machine):
    for simulation, p in violent_states(machine):
        flows = power_flows(simulation, p)
        pump = flows.pump
        lost = pump.pump_friction + pump.pump_leakage + pump.main_relief
        assert gap(pump.engine, -lost, -pump.manifold, -pump.flywheel, -pump.supply) < 1e-9
        for a in (flows.swing, flows.boom, flows.stick):
            assert gap(a.supply, -a.throttling, -a.inlets, -a.returned) < 1e-9
            lost = (
                a.port_valves
                + a.relieved
                + a.resistance
                + a.holding
                + a.compression
                + a.leakage
                + a.damping
                + a.dry_friction
                + a.cushion
                + a.gear
                + a.bending
            )
            assert gap(a.inlets, -a.hose, -lost, -a.stop, -a.elastic, -a.joint) < 1e-9


@pytest.mark.parametrize("machine", MACHINES)
def mechanical_energy(state, p):
    """Kinetic and potential energy of crane and hanging head [J]."""
    q = state.swing.angle, state.boom.angle, state.stick.angle
    u = state.swing.rate, state.boom.rate, state.stick.rate
    angles, rates = (state.head.alpha, state.head.beta), (state.head.alpha_rate, state.head.beta_rate)
    energy = kinetic_energy(q, u, p.body) + potential_energy(q, p.body)
    if p.head.mass > 0.0:
        energy += pendulum_kinetic_energy(q, u, angles, rates, p.head, p.body)
        energy += pendulum_potential_energy(q, angles, p.head, p.body)
    return energy


def moved(state, rate, time):
    """A state after a time on a straight line."""
    return unpack(pack(state) + time * pack(rate))


@pytest.mark.parametrize("machine", [*MACHINES, pytest.param(HANGING, id="hanging head")])
def test_the_links_store_what_the_joints_and_the_outer_force_give_them(machine):
    force, h = (3e3, -2e3, -5e3), 1e-4
    for k, (simulation, p) in enumerate(violent_states(machine, 3.0)):
        if k % 10 != 5:  # not the first, in which hardly anything moves
            continue
        p = p._replace(tip_force=force)
        state, flows = simulation.plant, power_flows(simulation, p)
        rate = state_derivative(state, ports_at(simulation.spools, p), p)
        energies = [mechanical_energy(moved(state, rate, n * h), p) for n in (-2, -1, 1, 2)]
        stored = float(np.dot([1.0, -8.0, 8.0, -1.0], energies)) / (12.0 * h)
        q = state.swing.angle, state.boom.angle, state.stick.angle
        u = state.swing.rate, state.boom.rate, state.stick.rate
        outer = np.dot(force, tip_velocity(q, u, machine.manipulator.links))
        relative = state.head.alpha_rate - u[1] - u[2]
        damped = p.head.damping * (relative**2 + state.head.beta_rate**2) if p.head.mass else 0.0
        joints = flows.swing.joint, flows.boom.joint, flows.stick.joint
        assert gap(-stored, *joints, outer, -damped) < 1e-9


@pytest.mark.parametrize("machine", MACHINES)
def test_what_is_called_a_loss_never_gives_power_back(machine):
    for simulation, p in violent_states(machine, 3.0):
        flows = power_flows(simulation, p)
        losses = [flows.pump.pump_friction, flows.pump.pump_leakage, flows.pump.main_relief]
        for a in (flows.swing, flows.boom, flows.stick):
            losses += [
                a.throttling,
                a.port_valves,
                a.resistance,
                a.leakage,
                a.damping,
                a.dry_friction,
                a.cushion,
                a.gear,
                a.bending,
            ]
        # A turbulent hose's loss counts the flow that moves the load, not what leaks behind it.
        assert min(losses) >= -1e-6 * abs(flows.pump.engine)


def test_nothing_flows_in_a_machine_at_rest_but_what_the_pump_itself_needs():
    p = plant_parameters(C180)
    rest = equilibrium((0.0, 0.5, -1.5), p)
    flows = power_flows(rest, p)
    assert flows.pump.engine == pytest.approx(flows.pump.pump_friction + flows.pump.pump_leakage)
    assert all(abs(value) < 1e-9 for axis in flows[1:] for value in axis)
