"""Claims about links that give way: beam theory, closed forms, another integration, sensors, energy."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from full_machine import advance
from scipy.integrate import cumulative_trapezoid, solve_ivp
from scipy.optimize import brentq

from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.mechanics.elasticity_parameters import Elasticity
from forest_msgs_py.interfaces import topics
from forest_sim.analysis.modes import modes
from forest_sim.equations.elastic_links import RIGID_ROOTS
from forest_sim.equations.multibody import HANGING_STILL, mechanics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_readings import NOMINAL, deflections, true_joints, true_values
from forest_sim.sensors.sensor_suite import EXACT_SUITE
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.simulation.sensor_log import further_topics
from forest_sim.simulation.simulated_machine import SimulatedMachine
from forest_sim.solver import integrator
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import ENERGY, STATE

C180 = load_machine("c180_hoses")
REAL = load_machine(Path(__file__).parents[3] / "docs/studies/elastic_links.yaml")
LINKS = C180.manipulator.links
SHUT = (0.0, 0.0, 0.0)
LEVEL, HANGING = (0.0, 0.9, -0.9), (0.0, 0.0, -0.5 * math.pi)  # the stick; the boom, its stick plumb
RIGIDITY = 2.4e7  # E I [N m^2]
POSE = (0.0, 0.4, -1.4)


def elastic(machine=C180, **given):
    """A machine with links that give way: the axis' name and its elasticity."""
    drives = {axis: dataclasses.replace(getattr(machine, axis), elasticity=e) for axis, e in given.items()}
    return dataclasses.replace(machine, **drives)


def beam_tip(force, length, rigidity):
    """Deflection [m] of a cantilever's tip, by integrating its curvature M/(E I) twice."""
    x = np.linspace(0.0, length, 2001)
    slope = cumulative_trapezoid(force * (length - x) / rigidity, x, initial=0.0)
    return float(np.trapezoid(slope, x))


@pytest.mark.parametrize(("axis", "pose"), [("boom", HANGING), ("stick", LEVEL)])
def test_a_force_bends_a_link_as_it_bends_a_beam(axis, pose):
    """A level cantilever under a force at its tip, pushed until it rests."""
    length, force = getattr(C180.manipulator, f"{axis}_length"), 4e3
    machine = elastic(**{axis: Elasticity(3.0 * RIGIDITY / length, damping=1e6, root_inertia=80.0)})
    p = plant_parameters(machine)
    begin = equilibrium(pose, p)
    pushed = advance(begin, SHUT, 1e-3, 4000, p._replace(tip_force=(0.0, 0.0, -force)))
    place = ("swing", "boom", "stick").index(axis)
    more = deflections(pushed, p)[place] - deflections(begin, p)[place]
    assert -length * more == pytest.approx(beam_tip(force, length, RIGIDITY), rel=0.02)
    assert deflections(pushed, p)[3 - place] == 0.0  # the other link is rigid


def beam_with_mass(beam, tip, length, rigidity):
    """First frequency [Hz] of a clamped uniform beam [kg] with a mass at its tip [kg], exact."""

    def characteristic(b):
        flexed = 1.0 + math.cos(b) * math.cosh(b)
        return flexed + tip / beam * b * (math.cos(b) * math.sinh(b) - math.sin(b) * math.cosh(b))

    b = brentq(characteristic, 0.05, 1.87)
    return (b / length) ** 2 * math.sqrt(rigidity * length / beam) / (2.0 * math.pi)


def uniform_stick(capacitance, damping=0.0):
    """The parameters of a crane of no weight whose stick is a uniform beam of 400 kg, 2 t at its tip.

    Its boom is held by hoses that hardly yield, its stick by hoses of a capacitance [m^3/Pa].
    """
    length, beam = C180.manipulator.stick_length, 400.0
    links = dataclasses.replace(
        C180.manipulator,
        gravity=0.0,
        stick_mass=beam,
        stick_x=0.5 * length,
        stick_y=0.0,
        stick_xx=1.0,
        stick_yy=beam * length**2 / 12.0,
        stick_zz=beam * length**2 / 12.0,
        head_mass=5.0 * beam,
    )
    link = Elasticity(3.0 * RIGIDITY / length, damping, root_inertia=1.0)
    p = plant_parameters(dataclasses.replace(elastic(stick=link), manipulator=links))
    of = {"boom": 1e-18, "stick": capacitance}
    axes = {
        axis: getattr(p, axis)._replace(
            line_1=getattr(p, axis).line_1._replace(capacitance=c),
            line_2=getattr(p, axis).line_2._replace(capacitance=c),
        )
        for axis, c in of.items()
    }
    return p._replace(**axes), length, beam


def stick_mode(p):
    """The slowest mode in which the stick takes the greatest part."""
    return next(mode for mode in modes(LEVEL, SHUT, p) if mode.axis == "stick")


def test_a_clamped_link_with_a_mass_at_its_tip_has_the_beams_first_frequency():
    p, length, beam = uniform_stick(capacitance=1e-18)
    mode = stick_mode(p)
    assert mode.frequency == pytest.approx(beam_with_mass(beam, 5.0 * beam, length, RIGIDITY), rel=0.02)
    assert mode.kind == "links bending"
    assert mode.parts["bending"] == pytest.approx(0.5, abs=0.01)  # all of the energy that is not kinetic


def test_bending_and_the_cylinders_oil_are_springs_in_series():
    p, length, beam = uniform_stick(capacitance=2e-12)
    areas = p.stick.actuator.displacement_1, p.stick.actuator.displacement_2
    oil = lever_arm(LEVEL[2], p.stick_linkage) ** 2 * sum(area**2 / 2e-12 for area in areas)
    bending, inertia = p.elastic.stick.stiffness, (beam / 3.0 + 5.0 * beam) * length**2
    expected = math.sqrt(1.0 / (1.0 / oil + 1.0 / bending) / inertia) / (2.0 * math.pi)
    mode = stick_mode(p)
    assert mode.frequency == pytest.approx(expected, rel=0.02)
    assert mode.parts["bending"] / mode.parts["oil"] == pytest.approx(oil / bending, rel=0.02)


COLUMN = Elasticity(stiffness=6e6, damping=2e4, root_inertia=300.0)
TWISTING = dataclasses.replace(elastic(swing=COLUMN), port_valves=None, end_stops=None)


def twisting(_, y, inertia, line, swing):
    """A crane on a column that twists, on a motor behind shut hoses, written apart."""
    q, u, theta, w, p_1, p_2 = y
    torque = COLUMN.stiffness * (theta - q) + COLUMN.damping * (w - u)
    d = swing.gear_ratio * swing.motor_displacement
    inner, outer = 1.0 / swing.internal_leakage_resistance, 1.0 / swing.external_leakage_resistance
    q_1 = d * w + inner * (p_1 - p_2) + outer * p_1
    q_2 = d * w + inner * (p_1 - p_2) - outer * p_2
    motor = d * (p_1 - p_2) - swing.damping * w
    return [u, torque / inertia, w, (motor - torque) / COLUMN.root_inertia, -q_1 / line.capacitance,
            q_2 / line.capacitance]  # fmt: skip


def test_a_crane_thrown_on_its_column_swings_as_an_independent_integration_does():
    """The hoses' resistance, 1.5 % of the damping, is left out there: within 2 % of the way."""
    p, start = plant_parameters(TWISTING), 0.05
    begin = equilibrium(POSE, p)
    plant = begin.plant._replace(swing=begin.plant.swing._replace(rate=start))
    now, ways = begin._replace(plant=plant), []
    for _ in range(1500):
        now = advance(now, SHUT, 1e-3, 1, p)
        ways.append((now.plant.swing.angle, now.plant.roots.swing.angle))
    inertia = mechanics(POSE, SHUT, HANGING_STILL, p).inertia.m_11
    truth = solve_ivp(
        twisting, (0.0, 1.5), [0.0, start, 0.0, 0.0, 0.0, 0.0], method="Radau", rtol=1e-8, atol=1e-10,
        t_eval=1e-3 * np.arange(1, 1501), args=(inertia, TWISTING.line(0, 1), TWISTING.swing),
    )  # fmt: skip
    ours = np.array(ways)
    for column, theirs in ((0, truth.y[0]), (1, truth.y[2])):
        assert np.max(np.abs(ours[:, column] - theirs)) < 0.02 * np.ptp(theirs)
    assert np.ptp(ours[:, 0] - ours[:, 1]) > 0.3 * np.ptp(ours[:, 0])  # much of the way is the column's


def test_at_rest_the_links_hang_below_their_joints_and_stay():
    p = plant_parameters(REAL)
    begin = equilibrium(POSE, p)
    end = advance(begin, SHUT, 1e-3, 1000, p)
    bent = deflections(begin, p)
    assert bent[1] < -1e-3
    assert bent[2] < -1e-3
    assert deflections(end, p) == pytest.approx(bent, abs=1e-9)
    assert [axis.angle for axis in begin.plant.axes] == list(POSE)


def test_sensors_have_the_joint_and_the_tip_the_link():
    p = plant_parameters(REAL)
    now = advance(equilibrium(POSE, p), (2.0, -3.0, 3.0), 1e-3, 137, p)
    read, roots = true_values(now, p, NOMINAL), now.plant.roots
    assert read[:3] == tuple(root.angle for root in roots)
    true = true_joints(now, p).position
    assert true == tuple(axis.angle for axis in now.plant.axes)
    believed, tip = (np.array(tip_position(angles, LINKS)) for angles in (read[:3], true))
    assert 2e-3 < np.linalg.norm(tip - believed) < 0.05


def test_the_simulator_tells_the_deflections_of_links_that_bend_and_of_no_others():
    assert topics.GROUND_TRUTH_DEFLECTIONS not in further_topics(C180, has_loads=False)
    running = SimulatedMachine(REAL, POSE, EXACT_SUITE, period=0.005)
    told = further_topics(REAL, has_loads=False)[topics.GROUND_TRUTH_DEFLECTIONS](running)
    report = running.at_rest
    assert np.subtract(report.joints.position, report.seen.joints.position) == pytest.approx(told, abs=1e-12)
    assert told[1] < -1e-3


def slammed(machine, seconds, step=1e-3):
    """The account of a run of voltages that jump every 0.1 s, and the machine after it."""
    p, rng = plant_parameters(machine), np.random.default_rng(8)
    volts = np.repeat(rng.uniform(-10.0, 10.0, (round(seconds / 0.1), 3)), round(0.1 / step), axis=0)
    begin, count = equilibrium(POSE, p), round(seconds * 100)
    states, energies = np.zeros((count, len(STATE))), np.zeros((count, len(ENERGY)))
    end = compiled_record()(begin, volts, step, p, states, energies)
    return with_stored_energy(account(np.sum(energies, axis=0)), begin, end, p), end


def test_the_energy_account_closes_under_slams_with_the_links_losses_of_their_own():
    total, end = slammed(REAL, 20.0)
    assert abs(unaccounted(total)) < 0.005 * total.engine
    assert total.bending > 0.0
    assert end.events.unconverged_stages == 0


def test_compiled_steps_are_the_interpreted_ones_to_the_last_bit():
    p = plant_parameters(REAL)
    one = two = equilibrium(POSE, p)
    for v in ((3.0, -2.0, 2.5), SHUT, (-4.0, 0.0, 0.0)):
        one, two = advance(one, v, 1e-3, 100, p), integrator.advance(two, v, 1e-3, 100, p)
        assert one == two


def test_a_stiff_link_is_a_rigid_one():
    stiff = Elasticity(stiffness=1e11, damping=1e7, root_inertia=0.01)
    plain, bending = plant_parameters(C180), plant_parameters(elastic(swing=stiff, boom=stiff, stick=stiff))
    one, two = (
        advance(equilibrium(POSE, p), (3.0, -2.0, 2.5), 1e-3, 1000, p).plant for p in (plain, bending)
    )
    assert one.roots == RIGID_ROOTS
    for ours, theirs in zip(one.axes, two.axes, strict=True):
        assert ours.angle == pytest.approx(theirs.angle, abs=1e-5)
