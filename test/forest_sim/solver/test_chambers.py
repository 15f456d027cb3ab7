"""Claims about a crane with oil in its cylinders: frequencies, conservation, convergence, two volumes."""

import dataclasses
import math

import numpy as np
import pytest
from full_machine import rigid
from two_volumes import CHAMBER_1, CHAMBER_2, opened_and_shut

from forest_description.geometry.linkage import length_and_arm
from forest_description.hydraulics.pump import IdealPump
from forest_description.machine import load_machine
from forest_sim.analysis.modes import SHUT, modes, slow_modes
from forest_sim.equations.multibody import HANGING_STILL, mechanics
from forest_sim.equations.plant import transmissions
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.oil_volume import content
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.solver import state_recording
from forest_sim.solver.compiled_plant import compiled_advance, compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import ENERGY, STATE

HANGING, C180 = rigid(load_machine("c180")), load_machine("c180_hoses")
REAL = dataclasses.replace(
    HANGING,
    boom=dataclasses.replace(HANGING.boom, friction=None),
    stick=dataclasses.replace(HANGING.stick, friction=None),
    manipulator=dataclasses.replace(HANGING.manipulator, pendulum=None),
)
P = plant_parameters(REAL)
POSE = (0.0, 0.4, -1.4)
CLEAN = dataclasses.replace(REAL, oil=dataclasses.replace(REAL.oil, air=None))
SMOOTH = dataclasses.replace(REAL.valve, hysteresis=None, dead_time=None, spool_slew_limit=None)
# Valves that follow at once and hold no load, a supply that stands still, no port valves: what two
# volumes are compared on.
PLAIN = dataclasses.replace(
    CLEAN,
    pump=IdealPump(REAL.pump.supply_pressure),
    tank_line=None,
    port_valves=None,
    valve=dataclasses.replace(SMOOTH, spool_bandwidth=None),
    boom=dataclasses.replace(REAL.boom, holding_1=None),
    stick=dataclasses.replace(REAL.stick, holding_1=None, holding_2=None),
)


def recorded(machine, voltages, step, rows=400, period=5e-3):
    """States [rows, 95] and energies of a run from the usual start, and both ends."""
    p, per_row = plant_parameters(machine), round(period / step)
    states, energies = np.zeros((rows, len(STATE))), np.zeros((rows, len(ENERGY)))
    times = (np.arange(rows * per_row) + 0.5) * step
    first = equilibrium(POSE, p)
    table = np.ascontiguousarray(voltages(times))
    last = compiled_record()(first, table, step, p, states, energies)
    return states, energies, first, last


def modulus(pressure):
    """Bulk modulus [Pa] of REAL's oil, -v/(dv/dP), from the room that oil and isothermal bubbles take."""

    def room(p):
        share = 1.0 - 3.0 * (p / 3e6) ** 2 + 2.0 * (p / 3e6) ** 3 if p < 3e6 else 0.0
        return 1.6e9 / (1.6e9 + p) + 0.005 * share * 101225.0 / (p + 101225.0)

    return -room(pressure) / (room(pressure + 50.0) - room(pressure - 50.0)) * 100.0


def frequencies_by_hand(machine, yields):
    """Boom and stick [Hz]: eigenvalues of M^-1 J' k J, k = A^2/(V/beta + C) of both sides."""
    p = plant_parameters(machine)
    rest, m = equilibrium(POSE, p).plant, mechanics(POSE, (0.0, 0.0, 0.0), HANGING_STILL, p).inertia
    springs = []
    for axis, drive, state in ((1, machine.boom, rest.boom), (2, machine.stick, rest.stick)):
        length, arm = length_and_arm(math.cos(state.angle), math.sin(state.angle), drive.linkage)
        stroke = length - drive.retracted_length
        head = drive.chambers.head_dead_volume + drive.head_area * stroke
        rod = drive.chambers.rod_dead_volume + drive.rod_area * (drive.stroke - stroke)
        head = head / yields(state.pressure_1) + machine.line(axis, 1).capacitance
        rod = rod / yields(state.pressure_2) + machine.line(axis, 2).capacitance
        springs.append(arm**2 * (drive.head_area**2 / head + drive.rod_area**2 / rod))
    mass = np.array([[m.m_22, m.m_23], [m.m_23, m.m_33]])
    return np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, np.diag(springs))))) / (2.0 * math.pi)


@pytest.mark.parametrize(
    ("machine", "yields"), [(CLEAN, lambda _: 1.6e9), (REAL, modulus)], ids=["clean", "with air"]
)
def test_the_slow_modes_are_the_masses_on_the_springs_of_their_oil(machine, yields):
    found = slow_modes(modes(POSE, SHUT, plant_parameters(machine)))
    by_hand = frequencies_by_hand(machine, yields)
    assert [found["boom"].frequency, found["stick"].frequency] == pytest.approx(by_hand.tolist(), rel=0.02)


def test_the_oil_of_the_chambers_takes_the_boom_from_ten_hertz_to_less_than_four():
    thesis, clean, real = (
        slow_modes(modes(POSE, SHUT, plant_parameters(machine))) for machine in (C180, CLEAN, REAL)
    )
    assert thesis["boom"].frequency == pytest.approx(9.8, abs=0.1)
    assert clean["boom"].frequency == pytest.approx(3.7, abs=0.1)
    assert clean["stick"].frequency == pytest.approx(12.4, abs=0.3)
    assert real["boom"].frequency == pytest.approx(3.55, abs=0.05)


def test_trapped_oil_stays_trapped_while_the_crane_swings_on_it():
    """Behind shut valves the content is what it was, over 5 s of an oscillation of 1 degree."""
    p = plant_parameters(dataclasses.replace(REAL, port_valves=None))
    start = equilibrium(POSE, p)
    boom = start.plant.boom._replace(rate=0.3)
    start = start._replace(plant=start.plant._replace(boom=boom))
    end = compiled_advance()(start, (0.0, 0.0, 0.0), 1e-3, 5000, p)
    assert abs(end.plant.boom.rate) > 0.01

    def held(simulation):
        plant = simulation.plant
        _, boom, stick = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
        return [
            content(pressure, t.position, oil).oil
            for axis, state, t in ((p.boom, plant.boom, boom), (p.stick, plant.stick, stick))
            for pressure, oil in ((state.pressure_1, axis.oil_1), (state.pressure_2, axis.oil_2))
        ]

    assert held(end) == pytest.approx(held(start), rel=1e-9)


@pytest.mark.parametrize("machine", [REAL, HANGING], ids=["fixed head", "hanging head"])
def test_the_error_falls_with_the_square_of_the_step(machine):
    def sines(t):
        return np.column_stack(
            [5.0 * np.sin(2.0 * t), 4.0 * np.sin(3.0 * t + 1.0), 4.0 * np.sin(2.5 * t + 2.0)]
        )

    machine = dataclasses.replace(machine, valve=SMOOTH)
    angles = [STATE.index(f"{axis}_angle") for axis in ("swing", "boom", "stick")]
    fine, *coarser = (recorded(machine, sines, step)[0][:, angles] for step in (6.25e-5, 2.5e-4, 5e-4, 1e-3))
    errors = [float(np.abs(states - fine).max()) for states in coarser]
    assert errors[2] < 5e-5
    assert errors[0] < errors[2] / 2.5**2


@pytest.mark.parametrize("name", ["steps", "random"])
def test_the_energy_closes_by_what_the_states_hold_at_both_ends(name):
    rng = np.random.default_rng(8)
    levels = rng.uniform(-10.0, 10.0, (100, 3))
    given = {
        "steps": voltage_profiles.steps(5.0).at,
        "random": lambda t: levels[np.minimum((t / 0.15).astype(int), 99)],
    }[name]
    _, energies, first, last = recorded(REAL, given, 1e-3, rows=3000)
    total = with_stored_energy(account(energies.sum(axis=0)), first, last, P)
    assert abs(unaccounted(total)) < 1e-3 * float(total.engine)


def test_compiled_and_interpreted_steps_agree_to_the_last_bit():
    table = np.repeat(np.random.default_rng(2).uniform(-10.0, 10.0, (6, 3)), 20, axis=0)
    ends = []
    for record in (compiled_record(), state_recording.record):
        states, energies = np.zeros((24, len(STATE))), np.zeros((24, len(ENERGY)))
        record(equilibrium(POSE, P), table, 1e-3, P, states, energies)
        ends.append((states, energies))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert np.array_equal(ends[0][1], ends[1][1])


# Axis and voltage; how far one volume may be from two: of the way, and of the pressures' range.
CASES = ((1, -6.0, 0.004, 0.01), (2, 6.0, 0.01, 0.05))


@pytest.mark.parametrize(("axis", "volts", "of_way", "of_pressure"), CASES, ids=["boom", "stick"])
def test_one_volume_of_hose_and_chamber_moves_as_two_with_the_hoses_resistance_between(
    axis, volts, of_way, of_pressure
):
    ours, expected = opened_and_shut(PLAIN, POSE, axis, volts)
    way = np.ptp(expected[:, 0])
    assert np.abs(ours[:, 0] - expected[:, 0]).max() < of_way * way
    for mine, theirs in ((2, CHAMBER_1), (3, CHAMBER_2)):
        error = np.abs(ours[:, mine] - expected[:, theirs]).max()
        assert error < of_pressure * np.ptp(expected[:, theirs])
