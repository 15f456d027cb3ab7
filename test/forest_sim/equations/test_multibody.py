"""The mass matrix with a hanging head against dense algebra, and what a load on the tip does."""

import dataclasses

import numpy as np
import pytest

from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.mechanics.drives import Cushion
from forest_description.mechanics.load import Pendulum
from forest_sim.equations.multibody import HANGING_STILL, Inertia, mechanics, resisted, solve, times
from forest_sim.equations.plant import passive_force, supply_draw
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.port import port_pressure
from forest_sim.hydraulics.spool_dynamics import Spool
from forest_sim.simulation.disturbance import checked_tip_force
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.oil_temperature import dissipated_power
from forest_sim.solver.power_flows import AxisPower, PowerFlows, SupplyPower

C180 = load_machine("c180_hoses")
SMOOTH = 0.0  # [N] of dry friction
HANGING = dataclasses.replace(
    C180, manipulator=dataclasses.replace(C180.manipulator, pendulum=Pendulum(1.1, 150.0, 400.0))
)


def some_matrix(luck):
    """A positive matrix without two equal entries, but none between the head's axes; and it as an Inertia."""
    root = luck.normal(0.0, 1.0, (5, 5)) + 3.0 * np.eye(5)
    dense = root @ root.T
    dense[3, 4] = dense[4, 3] = 0.0
    coupling = tuple((dense[k, 3], dense[k, 4]) for k in range(3))
    upper = dense[0, 0], dense[0, 1], dense[0, 2], dense[1, 1], dense[1, 2], dense[2, 2]
    return dense, Inertia(*upper, coupling, dense[3, 3], dense[4, 4])


def test_products_and_solutions_are_those_of_the_dense_matrix():
    luck = np.random.default_rng(3)
    for _ in range(30):
        dense, inertia = some_matrix(luck)
        v = luck.normal(0.0, 1.0, 5)
        joints, head = times(inertia, tuple(v[:3]), tuple(v[3:]))
        assert (*joints, *head) == pytest.approx(dense @ v)
        joints, head = solve(inertia, tuple(v[:3]), tuple(v[3:]))
        assert (*joints, *head) == pytest.approx(np.linalg.solve(dense, v))


def test_resistance_and_the_heads_damping_are_added_where_they_act():
    """Damping acts on alpha - q2 - q3 and on beta: h b (n n' + e e')."""
    luck = np.random.default_rng(4)
    dense, inertia = some_matrix(luck)
    h, damping, resistance = 0.03, 7.0, (1.0, 2.0, 5.0)
    n, e = np.array([0.0, -1.0, -1.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 1.0])
    expected = dense + h * np.diag([*resistance, 0.0, 0.0])
    expected += h * damping * (np.outer(n, n) + np.outer(e, e))
    after, v = resisted(inertia, resistance, damping, h), luck.normal(0.0, 1.0, 5)
    joints, head = times(after, tuple(v[:3]), tuple(v[3:]))
    assert (*joints, *head) == pytest.approx(expected @ v)


@pytest.mark.parametrize("machine", [C180, HANGING], ids=["rigid", "hanging"])
def test_a_load_on_the_tip_pulls_every_joint_by_its_own_lever(machine):
    """Torque = dx_tip/dq . F; what the joints must hold falls by it."""
    p, luck, h = plant_parameters(machine), np.random.default_rng(5), 1e-6
    for _ in range(20):
        q = luck.uniform((-2.0, -0.6, -2.0), (2.0, 1.2, -0.9))
        force = luck.normal(0.0, 1e4, 3)
        tips = [
            tip_position(tuple(q + s * h * d), machine.manipulator.links) for d in np.eye(3) for s in (1, -1)
        ]
        torque = [np.subtract(tips[2 * k], tips[2 * k + 1]) @ force / (2.0 * h) for k in range(3)]
        still = (tuple(q), (0.0, 0.0, 0.0), HANGING_STILL)
        free, loaded = mechanics(*still, p), mechanics(*still, p._replace(tip_force=tuple(force)))
        assert np.subtract(free.bias, loaded.bias) == pytest.approx(torque, rel=1e-6, abs=1e-2)


@pytest.mark.parametrize(("share", "speed"), [(0.99, 0.2), (0.01, -0.2)])
def test_a_cushion_brakes_at_either_end(share, speed):
    boom = dataclasses.replace(C180.boom, cushion=Cushion(0.1, 5e6))
    axis = plant_parameters(dataclasses.replace(C180, boom=boom)).boom
    position = boom.retracted_length + share * boom.stroke
    depth = 1.0 - 0.01 * boom.stroke / 0.1
    force = passive_force(position, speed, SMOOTH, axis)
    assert force == pytest.approx(-np.sign(speed) * 5e6 * depth**2 * speed**2)
    assert passive_force(position, -speed, SMOOTH, axis) == 0.0  # out of it the piston moves freely


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_pump_feels_the_load_of_whichever_port_is_open_to_it(axis, way):
    p = plant_parameters(C180)
    rest = equilibrium((0.1, 0.4, -1.4), p).plant
    parts = list(rest)
    parts[axis] = parts[axis]._replace(pressure_1=6.1e6, pressure_2=4.3e6, flow_1=2e-4, flow_2=3e-4)
    state = type(rest)(*parts)
    spools = tuple(Spool(6.0 * way if k == axis else 0.0, 0.0) for k in range(3))
    ports = ports_at(spools, p)
    supply, one = state.supply.pressure, way > 0.0
    port, pressure = (ports[axis].port_1, 6.1e6) if one else (ports[axis].port_2, 4.3e6)
    fed = 2e-4 if one else -3e-4
    draw = supply_draw(state, ports)
    assert draw.load == pytest.approx(port_pressure(pressure, fed, port, supply))
    assert draw.load > 0.0
    assert draw.flow == pytest.approx(fed)


def test_the_heads_damping_acts_between_head_and_stick_and_on_its_own_swing():
    p, d = plant_parameters(HANGING), 400.0
    q, rates, head = (
        (0.3, 0.5, -1.3),
        (0.2, -0.4, 0.9),
        HANGING_STILL._replace(alpha_rate=0.7, beta_rate=-0.6),
    )
    damped, free = (
        mechanics(q, rates, head, p),
        mechanics(q, rates, head, p._replace(head=p.head._replace(damping=0.0))),
    )
    relative = 0.7 - (-0.4) - 0.9
    assert np.subtract(damped.bias, free.bias) == pytest.approx([0.0, -d * relative, -d * relative])
    assert np.subtract(damped.head_bias, free.head_bias) == pytest.approx([d * relative, d * -0.6])


def test_the_swings_stop_is_as_stiff_as_the_file_says_and_the_cylinders_as_theirs():
    p, stops = plant_parameters(C180), C180.end_stops
    limits = (C180.swing.lower_limit, C180.swing.upper_limit)
    for at, sign in zip(limits, (-1.0, 1.0), strict=True):
        force = passive_force(at + sign * 0.02, 0.0, SMOOTH, p.swing)
        assert force == pytest.approx(-sign * 0.02 * stops.swing_stiffness)
        moving = passive_force(at + sign * 0.02, sign * 0.1, SMOOTH, p.swing)
        assert moving - force == pytest.approx(-sign * 0.1 * stops.swing_damping)
    for axis, drive in ((p.boom, C180.boom), (p.stick, C180.stick)):
        force = passive_force(drive.retracted_length - 0.01, 0.0, SMOOTH, axis)
        assert force == pytest.approx(0.01 * stops.cylinder_stiffness)
        assert passive_force(drive.retracted_length - 0.01, -0.1, SMOOTH, axis) - force == pytest.approx(
            0.1 * stops.cylinder_damping
        )


@pytest.mark.parametrize("force", [(-2e6, 0.0, 0.0), (0.0, 2e6, 0.0), (0.0, 0.0, -1.1e6)])
def test_a_force_is_too_great_to_either_side(force):
    with pytest.raises(ValueError, match="allowed: 3 numbers"):
        checked_tip_force(force)


def test_what_an_end_stop_takes_does_not_warm_the_oil():
    still = AxisPower(*[0.0] * len(AxisPower._fields))
    pump = SupplyPower(
        engine=100.0, pump_friction=5.0, pump_leakage=4.0, main_relief=3.0, manifold=8.0, supply=80.0
    )
    swing = still._replace(stop=30.0, joint=-7.0, hose=2.0)
    boom, stick = still._replace(stop=-4.0, joint=11.0), still._replace(hose=-1.0)
    assert dissipated_power(PowerFlows(pump, swing, boom, stick)) == pytest.approx(
        100.0 - 8.0 - (30.0 - 4.0) - 4.0 - 1.0
    )
