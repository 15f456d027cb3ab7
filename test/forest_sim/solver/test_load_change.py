"""Claims about a load that changes in mid-run: rest, impact, spring back, sway, and the energy of all."""

import dataclasses
import math

import numpy as np
import pytest
from springing_crane import SpringingCrane

from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.mechanics.drives import CylinderChambers
from forest_description.mechanics.load import Log, RotatorAndGrapple
from forest_sim.equations.multibody import HANGING_STILL, mechanics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.mechanics.manipulator import dynamics
from forest_sim.simulation.changing_plant import ChangingPlant
from forest_sim.simulation.load_schedule import Load, loaded, parse_loads
from forest_sim.simulation.open_loop import Run, whole
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.load_change import kinetic_energy
from forest_sim.solver.state_recording import STATE

C180 = load_machine("c180_hoses")
HEAD = RotatorAndGrapple(
    rotator_mass=100.0,
    rotator_centre=0.25,
    rotator_length=0.5,
    grapple_centre=0.55,
    grapple_inertia=90.0,
    grip=0.8,
    damping=0.0,
)
HANGING = dataclasses.replace(C180, manipulator=dataclasses.replace(C180.manipulator, pendulum=HEAD))
ROOMY = dataclasses.replace(
    C180,
    boom=dataclasses.replace(C180.boom, chambers=CylinderChambers(3e-4, 3e-4)),
    stick=dataclasses.replace(C180.stick, chambers=CylinderChambers(3e-4, 3e-4)),
)
START = (0.2, 0.5, -1.4)
LOG = Load(600.0, 4.0)


def quiet(times):
    return np.zeros((len(times), 3))


@pytest.mark.parametrize("machine", [C180, HANGING], ids=["fixed", "hanging"])
@pytest.mark.parametrize("angles", [START, (-1.0, -0.4, -2.0), (0.0, 1.1, -1.0)])
def test_a_log_adds_its_weight_times_the_lever_arm_to_each_axis(machine, angles):
    """Both hold it under or at the tip, the tip's x from a joint is the arm."""
    m, p = machine.manipulator, plant_parameters(machine)
    rest = (0.0, 0.0, 0.0), HANGING_STILL
    held = mechanics(angles, *rest, loaded(p, m, LOG)).bias
    empty = mechanics(angles, *rest, p).bias
    stick_arm = m.stick_length * math.cos(angles[1] + angles[2])
    arms = np.array([0.0, m.boom_length * math.cos(angles[1]) + stick_arm, stick_arm])
    np.testing.assert_allclose(np.subtract(held, empty), 600.0 * 9.81 * arms, rtol=1e-10, atol=1e-8)


def test_a_log_that_lies_still_joins_with_the_momentum_of_the_crane_alone():
    """Impulse on a point at the tip: M (u' - u) = -J^T m J u', J by differences of the kinematics."""
    plant, p = ChangingPlant(C180), plant_parameters(C180)
    rates = np.array([0.5, -0.3, 0.4])
    rest = equilibrium(START, p)
    axes = [axis._replace(rate=rate) for axis, rate in zip(rest.plant.axes, rates.tolist(), strict=True)]
    moving = rest._replace(plant=rest.plant._replace(swing=axes[0], boom=axes[1], stick=axes[2]))
    h, links = 1e-6, C180.manipulator.links
    jacobian = np.array(
        [
            np.subtract(tip_position(tuple(np.add(START, e)), links), tip_position(tuple(START - e), links))
            for e in h * np.eye(3)
        ]
    ).T / (2.0 * h)
    d = dynamics(START, (0.0, 0.0, 0.0), p.body)
    mass = np.array([[d.m_11, 0.0, 0.0], [0.0, d.m_22, d.m_23], [0.0, d.m_23, d.m_33]])
    with_log = mass + 600.0 * jacobian.T @ jacobian
    expected = np.linalg.solve(with_log, mass @ rates)
    change = plant.hold(Load(600.0, 0.0), moving)
    now = change.simulation.plant
    np.testing.assert_allclose([axis.rate for axis in now.axes], expected, rtol=1e-7)
    lost = 0.5 * rates @ mass @ rates - 0.5 * expected @ with_log @ expected
    assert change.joining == pytest.approx(lost, rel=1e-7)
    height = tip_position(START, links)[2]
    assert change.carried_off == pytest.approx(-600.0 * 9.81 * height, rel=1e-9)
    for before, after in zip(moving.plant.axes, now.axes, strict=True):
        assert after._replace(rate=before.rate) == before
    assert kinetic_energy(now, plant.p) < kinetic_energy(moving.plant, p)


@pytest.mark.parametrize("machine", [C180, HANGING], ids=["fixed", "hanging"])
def test_a_dropped_log_leaves_every_state_as_it_is(machine):
    plant = ChangingPlant(machine)
    simulation = plant.hold(LOG, equilibrium(START, plant.p)).simulation
    simulation = compiled_advance()(simulation, (4.0, 3.0, -3.0), 1e-3, 200, plant.p)
    change = plant.hold(Load(0.0), simulation)
    assert change.simulation == simulation
    assert change.joining == 0.0
    assert plant.p == plant_parameters(machine)


@pytest.mark.parametrize(("machine", "least"), [(C180, 0.2e-3), (ROOMY, 1.5e-3)], ids=["hoses", "chambers"])
def test_the_crane_springs_up_from_a_dropped_log_as_an_independent_integration_does(machine, least):
    with_log = dataclasses.replace(machine.manipulator, log=Log(400.0, 0.0, 0.0))
    carrying = dataclasses.replace(machine, manipulator=with_log)
    angles, until = (0.0, START[1], START[2]), 1.0
    run = whole(
        carrying, Voltages("none", quiet, until), angles, Run(until, 1000.0), parse_loads("0 kg from 0 s")
    )
    columns = [f"{axis}_{what}" for what in ("angle", "rate") for axis in ("boom", "stick")]
    columns += [f"{axis}_pressure_{port}" for axis in ("boom", "stick") for port in (1, 2)]
    scale = np.array([1.0] * 4 + [1e-6] * 4)
    ours = scale * run.states[:, [STATE.index(name) for name in columns]]
    assert ours[:, 4:].max() < 24.0  # no relief valve opens
    assert ours[:, 4:].min() > 0.0
    theirs = SpringingCrane(machine).run(ours[0], run.time)
    springs = np.ptp(theirs, axis=0)
    assert springs[0] > least  # rad
    assert ours[:, 0].max() > ours[0, 0] + 0.99 * springs[0]  # up, not down
    assert np.all(np.abs(ours - theirs).max(axis=0) < 0.02 * springs)


@pytest.mark.parametrize("angle", ["alpha", "beta"])
def test_head_and_log_sway_with_the_frequency_of_a_compound_pendulum(angle):
    plant = ChangingPlant(HANGING)
    held = plant.hold(LOG, equilibrium(START, plant.p)).simulation
    held = compiled_advance()(held, (0.0, 0.0, 0.0), 1e-3, 10, plant.p)  # a little old: it rings on its oil
    head = HANGING_STILL._replace(**{angle: 0.03})
    simulation = held._replace(plant=held.plant._replace(head=head))
    angles = []
    for _ in range(2500):
        simulation = compiled_advance()(simulation, (0.0, 0.0, 0.0), 1e-3, 4, plant.p)
        angles.append(getattr(simulation.plant.head, angle))
    course = np.array(angles)
    falls = np.flatnonzero((course[:-1] > 0.0) & (course[1:] <= 0.0))
    crossings = 4e-3 * (falls + course[falls] / (course[falls] - course[falls + 1]))
    moment = 100.0 * 0.25 + 600.0 * 1.05 + 600.0 * 1.3
    about_joint = 100.0 * 0.25**2 + 90.0 + 600.0 * 1.05**2 + 600.0 * 1.3**2
    if angle == "alpha":
        about_joint += 600.0 * 4.0**2 / 12.0
    period = np.ptp(crossings) / (len(crossings) - 1)
    assert len(crossings) >= 3
    assert period == pytest.approx(2.0 * math.pi * math.sqrt(about_joint / (9.81 * moment)), rel=0.02)
