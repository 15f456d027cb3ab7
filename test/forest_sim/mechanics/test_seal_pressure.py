"""Claims about seals that the chambers press: friction by the pressures, stick-slip, small oscillations."""

import dataclasses

import numpy as np
import pytest
from full_machine import START, advance, full_machine, pack, reference, rigid
from two_volumes import CHAMBER_1, CHAMBER_2, opened_and_shut

from forest_description.hydraulics.pump import IdealPump
from forest_description.machine import load_machine
from forest_description.mechanics.drives import Friction
from forest_sim.analysis.friction_linearisation import axes_with_friction, with_pressed_seals
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.command_history import held
from forest_sim.mechanics.friction import friction, friction_force, pressed
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import spools_after

SHIPPED = rigid(load_machine("c180"))
# With the sharper kinks of thin lips, which make them stick and slip at these speeds.
SEALS = dataclasses.replace(SHIPPED.boom.friction, stribeck_speed=0.005, smoothing_speed=5e-4)
REAL = dataclasses.replace(
    SHIPPED,
    boom=dataclasses.replace(SHIPPED.boom, friction=SEALS),
    stick=dataclasses.replace(SHIPPED.stick, friction=SEALS),
)
POSE = (0.0, 0.4, -1.4)
# Valves that follow at once and hold no load, a supply that stands still, no air, a head at the tip.
PLAIN = dataclasses.replace(
    REAL,
    oil=dataclasses.replace(REAL.oil, air=None),
    pump=IdealPump(REAL.pump.supply_pressure),
    port_valves=None,
    valve=dataclasses.replace(
        REAL.valve, hysteresis=None, dead_time=None, spool_slew_limit=None, spool_bandwidth=None
    ),
    boom=dataclasses.replace(REAL.boom, holding_1=None),
    stick=dataclasses.replace(REAL.stick, holding_1=None, holding_2=None),
    tank_line=None,
    manipulator=dataclasses.replace(REAL.manipulator, pendulum=None),
)


def with_seals(seals, machine=PLAIN):
    return dataclasses.replace(
        machine,
        boom=dataclasses.replace(machine.boom, friction=seals),
        stick=dataclasses.replace(machine.stick, friction=seals),
    )


def test_both_pressures_add_and_breaking_away_keeps_its_share():
    at = pressed(friction(SEALS), 12e6, 3e6)
    assert friction_force(1.0, at) == pytest.approx(2.7e3 + 4e-4 * 15e6, rel=1e-6)
    smooth = pressed(friction(dataclasses.replace(SEALS, smoothing_speed=1e-6)), 12e6, 3e6)
    assert friction_force(5e-5, smooth) == pytest.approx((2.7e3 + 4e-4 * 15e6) * 4.0 / 2.7, rel=1e-3)


def test_under_tank_pressure_a_lip_keeps_its_preload():
    assert pressed(friction(SEALS), -1e5, -1e5) == friction(SEALS)._replace(pressure_share=0.0)
    preload = friction(dataclasses.replace(SEALS, pressure_coefficient=None))
    assert pressed(preload, 2e7, 2e7) == preload


@pytest.mark.parametrize("volts", [6.0, -6.0], ids=["up", "down"])
def test_a_cylinder_moves_and_rings_as_one_whose_friction_is_written_apart(volts):
    """Without what the pressures add, head side's pressures would be off by over 3 %."""
    ours, expected = opened_and_shut(PLAIN, POSE, 1, volts)
    assert np.abs(ours[:, 0] - expected[:, 0]).max() < 0.01 * np.ptp(expected[:, 0])
    for mine, theirs in ((2, CHAMBER_1), (3, CHAMBER_2)):
        assert np.abs(ours[:, mine] - expected[:, theirs]).max() < 0.02 * np.ptp(expected[:, theirs])


def slow(machine, volts, seconds):
    """The boom's rate [rad/s] and pressures [Pa] every ms under a held voltage [V], [N, 3]."""
    p, rows = plant_parameters(machine), []
    now = equilibrium(POSE, p)
    for _ in range(round(1e3 * seconds)):
        now = advance(now, (0.0, volts, 0.0), 1e-3, 1, p)
        boom = now.plant.boom
        rows.append((boom.rate, boom.pressure_1, boom.pressure_2))
    assert now.events.unconverged_stages == 0
    return np.array(rows)


def test_pressed_seals_let_a_slow_boom_stick_and_slip_and_unpressed_ones_do_not():
    spread = []
    for seals in (SEALS, dataclasses.replace(SEALS, pressure_coefficient=None)):
        rates = slow(with_seals(seals), 1.3, 4.0)[3000:, 0]
        spread.append((rates.min() / rates.mean(), rates.max() / rates.mean()))
    assert spread[0][0] < 0.25
    assert spread[0][1] > 1.6
    assert 0.8 < spread[1][0] < spread[1][1] < 1.2


def test_steps_converge_with_order_two():
    machine, volts = rigid(full_machine("compensated")), (3.0, 2.5, -3.5)
    seals = Friction(4e3, 7e3, 0.02, 2e-3, 4e-4)
    p = plant_parameters(with_seals(seals, machine))
    begin = advance(equilibrium(START, p), volts, 1e-3, 250, p)
    begin = begin._replace(spools=spools_after(begin.spools, held(volts), 100.0, p))
    truth = reference(begin, p, 0.2)
    errors = [np.linalg.norm(pack(advance(begin, volts, 0.2 / n, n, p).plant) - truth) for n in (200, 400)]
    assert errors[0] < 2e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_the_amplitudes_of_large_oscillations_are_those_at_the_pressures_of_the_pose():
    p = plant_parameters(REAL)
    state = equilibrium(POSE, p).plant
    told = axes_with_friction(with_pressed_seals(p, state))
    by_hand = dataclasses.replace(
        SEALS,
        coulomb_force=SEALS.coulomb_force + 4e-4 * (state.boom.pressure_1 + state.boom.pressure_2),
        breakaway_force=4.0 / 2.7 * (2.7e3 + 4e-4 * (state.boom.pressure_1 + state.boom.pressure_2)),
        pressure_coefficient=None,
    )
    assert told["boom"] == pytest.approx(axes_with_friction(plant_parameters(with_seals(by_hand)))["boom"])
    assert told["boom"].large > 2.0 * axes_with_friction(p)["boom"].large
