"""Claims about the swing's drive in the plant: it holds, breaks away, rattles, and its energy closes."""

import dataclasses
import math

import numpy as np
import pytest
from full_machine import advance
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from forest_description.machine import load_machine
from forest_sim.equations.multibody import HANGING_STILL, mechanics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.mechanics.end_stop import end_stop_force
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.solver import integrator, state_recording
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import ENERGY, STATE
from forest_sim.stage.drive_stage import Contact, meshed_rate

REAL = load_machine("c180")
POSE = (0.0, 0.4, -1.4)
SHUT = (0.0, 0.0, 0.0)


def with_drive(machine=REAL, **changes):
    return dataclasses.replace(machine, swing=dataclasses.replace(machine.swing, **changes))


def tilted(torque, machine=REAL):
    """The crane across a slope that loads its swing with a torque [N m]."""

    def placed(tilt):
        links = dataclasses.replace(machine.manipulator, platform_tilt=tilt)
        return dataclasses.replace(machine, manipulator=links)

    def excess(tilt):
        return abs(mechanics(POSE, SHUT, HANGING_STILL, plant_parameters(placed(tilt))).bias[0]) - torque

    return placed(brentq(excess, 0.0, 0.5, xtol=1e-12))


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_below_its_breakaway_a_bearing_holds_the_crane_on_a_slope_for_ever(share):
    """The motor leaks and lets the bearing take the load; then there is no creep in two minutes."""
    p = plant_parameters(tilted(share * REAL.swing.friction.breakaway_torque))
    settled = advance(equilibrium(POSE, p), SHUT, 2e-3, 100_000, p)
    end = advance(settled, SHUT, 2e-3, 60_000, p)
    assert abs(end.plant.swing.angle - settled.plant.swing.angle) < 2e-13
    assert abs(end.plant.swing.rate) < 1e-15
    assert end.events.unconverged_stages == 0


def test_above_its_breakaway_the_crane_turns_downhill():
    p = plant_parameters(tilted(1.05 * REAL.swing.friction.breakaway_torque))
    taken = advance(equilibrium(POSE, p), SHUT, 2e-3, 50_000, p)  # by the teeth, whose motor leaks
    end = advance(taken, SHUT, 2e-3, 50_000, p)
    assert abs(end.plant.swing.angle) > abs(taken.plant.swing.angle) + 1e-3


def pushed(p, force):
    """The drive at rest after a force [N] across the crane has pushed for 4 s."""
    p = p._replace(tip_force=(0.0, force, 0.0))
    plant = advance(equilibrium(POSE, p), SHUT, 1e-3, 4000, p).plant
    return plant.drive.motor_angle - plant.swing.angle


def test_the_joint_is_free_for_twice_b_and_what_the_teeth_yield():
    """Two closed forms: the hysteresis is 2 b wide without load, and 2 T/k wider with a torque T."""
    machine = with_drive(friction=None, elasticity=None)
    gear, p = machine.swing.backlash, plant_parameters(machine)
    links = machine.manipulator
    reach = links.base_offset + links.boom_length * math.cos(0.4) + links.stick_length * math.cos(0.4 - 1.4)
    for force in (50.0, 400.0):
        width = pushed(p, -force) - pushed(p, force)
        expected = gear.free_way + 2.0 * force * reach / gear.stiffness
        assert width == pytest.approx(expected, rel=0.02)


PLAIN = dataclasses.replace(
    with_drive(load_machine("c180_hoses"), backlash=REAL.swing.backlash), port_valves=None, end_stops=None
)


def rattling(_, y, inertia, line, swing, gear):
    """Two inertias, teeth with play, and shut hoses, written apart: joint, motor, both pressures."""
    q, u, w_angle, w, p_1, p_2 = y
    half, twist, speed = 0.5 * gear.free_way, w_angle - q, w - u
    torque = 0.0
    if abs(twist) > half:
        depth, closing = abs(twist) - half, math.copysign(1.0, twist) * speed
        grip = min(1.0, gear.stiffness * depth / (0.05 * gear.damping))
        torque = math.copysign(max(0.0, gear.stiffness * depth + grip * gear.damping * closing), twist)
    d = swing.gear_ratio * swing.motor_displacement
    inner, outer = 1.0 / swing.internal_leakage_resistance, 1.0 / swing.external_leakage_resistance
    q_1 = d * w + inner * (p_1 - p_2) + outer * p_1
    q_2 = d * w + inner * (p_1 - p_2) - outer * p_2
    motor = gear.motor_inertia * swing.gear_ratio**2
    return [
        u,
        torque / inertia,
        w,
        (d * (p_1 - p_2) - swing.damping * w - torque) / motor,
        -q_1 / line.capacitance,
        q_2 / line.capacitance,
    ]


def test_a_stage_finds_the_motors_rate_between_free_and_touching_teeth():
    """Against the root of the same balance; plain Newton jumps between no contact and a full grip."""
    random, teeth = np.random.default_rng(2), plant_parameters(REAL).drive.gear.teeth
    step, touched = 2.9e-4, 0
    for _ in range(300):
        free, rate, guess = random.uniform(-2.0, 2.0, 3)
        twist = random.uniform(-1.5, 1.5) * teeth.upper
        c = Contact(twist, rate, 10.0 ** random.uniform(-6.5, -4.0), step, teeth)
        found = meshed_rate(free, guess, c)
        force = end_stop_force(twist + step * found, found - rate, teeth)
        assert abs(found - c.give * force - free) < 1e-7
        touched += force != 0.0
    assert touched > 50


def test_a_crane_thrown_through_its_play_rattles_as_an_independent_integration_does():
    """The hoses' resistance, 1.5 % of the damping, is left out there: within 2 % of the way."""
    p, start = plant_parameters(PLAIN), 0.05
    begin = equilibrium(POSE, p)
    plant = begin.plant._replace(swing=begin.plant.swing._replace(rate=start))
    now, ways = begin._replace(plant=plant), []
    for _ in range(1500):
        now = advance(now, SHUT, 1e-3, 1, p)
        ways.append((now.plant.swing.angle, now.plant.drive.motor_angle))
    inertia = mechanics(POSE, SHUT, HANGING_STILL, p).inertia.m_11
    truth = solve_ivp(
        rattling, (0.0, 1.5), [0.0, start, 0.0, 0.0, 0.0, 0.0], method="Radau", rtol=1e-8, atol=1e-10,
        t_eval=1e-3 * np.arange(1, 1501), args=(inertia, PLAIN.line(0, 1), PLAIN.swing, PLAIN.swing.backlash),
        max_step=1e-3,
    )  # fmt: skip
    ours = np.array(ways)
    assert np.ptp(np.sign(ours[:, 1] - ours[:, 0])) == 2.0  # both flanks were hit
    for column, theirs in ((0, truth.y[0]), (1, truth.y[2])):
        assert np.max(np.abs(ours[:, column] - theirs)) < 0.02 * np.ptp(theirs)


def random_run(machine, seconds, step=1e-3):
    """The account of a run under a random voltage every 0.2 s, and the machine after it."""
    p, rng = plant_parameters(machine), np.random.default_rng(5)
    volts = np.repeat(rng.uniform(-9.0, 9.0, (round(seconds / 0.2), 3)), round(0.2 / step), axis=0)
    begin, count = equilibrium(POSE, p), round(seconds * 100)
    states, energies = np.zeros((count, len(STATE))), np.zeros((count, len(ENERGY)))
    end = compiled_record()(begin, volts, step, p, states, energies)
    return with_stored_energy(account(np.sum(energies, axis=0)), begin, end, p), end


def test_the_energy_account_closes_with_the_gears_losses_of_their_own():
    total, end = random_run(REAL, 20.0)
    assert abs(unaccounted(total)) < 0.005 * total.engine
    assert total.gear > 0.0
    assert end.events.unconverged_stages == 0
    smooth, _ = random_run(with_drive(friction=None), 20.0)
    assert total.friction > smooth.friction


def test_compiled_steps_are_the_interpreted_ones_to_the_last_bit():
    p, volts = plant_parameters(tilted(500.0)), (3.0, -2.0, 2.5)
    one = two = equilibrium(POSE, p)
    for v in (volts, SHUT, (-4.0, 0.0, 0.0)):
        one, two = advance(one, v, 1e-3, 150, p), integrator.advance(two, v, 1e-3, 150, p)
        assert one == two


def test_sensors_have_the_joint_and_the_oil_the_motor():
    from forest_sim.equations.plant import motor_side
    from forest_sim.sensors.sensor_readings import true_joints

    p = plant_parameters(REAL)
    now = advance(equilibrium(POSE, p), (2.0, 0.0, 0.0), 1e-3, 137, p)
    motor = motor_side(now.plant, p)
    assert true_joints(now, p).position[0] == now.plant.swing.angle != motor.angle
    row = np.zeros(len(STATE))
    state_recording.store(now, row)
    assert row[STATE.index("drive_motor_rate")] == motor.rate
