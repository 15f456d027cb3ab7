"""Claims about load-holding valves: when they open, what they hold, how fast a load comes down."""

import dataclasses
import math

import numpy as np
import pytest
from full_machine import rigid
from held_volumes import HeldVolumes
from scipy.integrate import solve_ivp
from two_volumes import CHAMBER_1, CHAMBER_2

from forest_description.hydraulics.load_holding_parameters import (
    CounterbalanceValve,
    PilotCheckValve,
    RuptureValve,
)
from forest_description.hydraulics.pump import IdealPump
from forest_description.hydraulics.valve_characteristic import edges
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.load_holding import Lifts, holding_valve, lift_after, restriction
from forest_sim.hydraulics.spool_dynamics import Spool
from forest_sim.hydraulics.supply import SupplyState
from forest_sim.midpoint.holding_step import lifts_after
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.solver import state_recording
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.power_flows import power_flows
from forest_sim.solver.state_recording import ENERGY, STATE

REAL, C180 = load_machine("c180"), load_machine("c180_hoses")
RIGID = rigid(REAL)
VALVE = REAL.boom.holding_1
MPA = 1e6
POSE = (0.0, 0.4, -1.4)
PILOT_CHECK = PilotCheckValve(2e5, 4.0, 1e5, 1e6, 1.5e11, 5e10, 0.01)
RUPTURE = RuptureValve(2e-3, 5e10, 0.01)
# Edges of port 1 that let the boom's oil out faster than the pump fills its other side.
WIDE = dataclasses.replace(REAL.valve, minimum_resistance=1e10, port_2_area=0.05)


def crane(boom, valve=REAL.valve, head_mass=700.0):
    """Rigid c180 with at most one load-holding valve, at the boom's head side; free seals, other pump."""
    return dataclasses.replace(
        RIGID,
        pump=C180.pump,
        tank_line=None,
        valve=valve,
        boom=dataclasses.replace(RIGID.boom, holding_1=boom, friction=None),
        stick=dataclasses.replace(RIGID.stick, holding_1=None, holding_2=None, friction=None),
        manipulator=dataclasses.replace(REAL.manipulator, head_mass=head_mass),
    )


class Course:
    """A run of steps of 1 ms under voltages of the boom [V], a row every 5 ms."""

    def __init__(self, machine, volts, pose=POSE, record=None):
        p, rows = plant_parameters(machine), len(volts) // 5
        table = np.zeros((len(volts), 3))
        table[:, 1] = volts
        self.states, self.energies = np.zeros((rows, len(STATE))), np.zeros((rows, len(ENERGY)))
        first = equilibrium(pose, p)
        last = (record or compiled_record())(first, table, 1e-3, p, self.states, self.energies)
        self.failed = last.events.unconverged_stages
        self.account = with_stored_energy(account(self.energies.sum(axis=0)), first, last, p)

    def __getattr__(self, name):
        return self.states[:, STATE.index(f"boom_{name}")]


def held_voltage(volts, before=0.2, time=1.3, after=0.5):
    return np.repeat([0.0, volts, 0.0], [round(1e3 * t) for t in (before, time, after)])


def settled(valve, load, pilot, lift):
    return lift_after(lift, load, pilot, 0.0, 10.0, holding_valve(valve))


@pytest.mark.parametrize("pilot", [0.0, 2.0 * MPA, 5.5 * MPA])
def test_load_and_pilot_crack_a_counterbalance_valve_at_its_setting_and_reseat_it_below(pilot):
    cracks = VALVE.setting - VALVE.pilot_ratio * pilot
    assert settled(VALVE, cracks - 1.0, pilot, 0.0) == 0.0
    assert settled(VALVE, cracks + 0.2 * MPA, pilot, 0.0) == pytest.approx(0.2 * MPA / VALVE.opening_range)
    assert settled(VALVE, cracks + 1.01 * VALVE.opening_range, pilot, 0.0) == pytest.approx(1.0)
    assert settled(VALVE, cracks - 0.9 * VALVE.hysteresis, pilot, 0.02) > 0.0
    assert settled(VALVE, cracks - 1.001 * VALVE.hysteresis, pilot, 1.0) == pytest.approx(0.0, abs=1e-12)


def test_the_load_shuts_a_pilot_check_valve_and_its_pilot_opens_it():
    for load in (1.0 * MPA, 14.0 * MPA):
        opens = (load + PILOT_CHECK.setting) / PILOT_CHECK.pilot_ratio
        assert settled(PILOT_CHECK, load, opens - 1.0, 0.0) == 0.0
        assert settled(PILOT_CHECK, load, opens + 0.125 * MPA, 0.0) == pytest.approx(0.5)


def test_a_poppet_is_spring_damper_and_friction():
    """Beside an integration of its law under pressures that rise and fall; parts of a step are the whole."""
    v, held = holding_valve(VALVE), 5e-3
    loads = VALVE.setting + MPA * np.array([1.0, 4.0, 3.6, 2.9, 6.0, 0.5, -0.5, -3.0, 2.0])
    ours = theirs = parts = 0.0
    for load in loads:
        rising = (load - VALVE.setting) / VALVE.opening_range
        falling = rising + VALVE.hysteresis / VALVE.opening_range

        def slope(_, z, rising=rising, falling=falling):
            pulled = max(rising - z[0], 0.0) + min(falling - z[0], 0.0)
            return [pulled / VALVE.response_time if 0.0 < z[0] + 1e-3 * pulled < 1.0 else 0.0]

        theirs = solve_ivp(slope, (0.0, held), [theirs], rtol=1e-9, atol=1e-9, max_step=1e-5).y[0, -1]
        ours = lift_after(ours, load, 0.0, 0.0, held, v)
        for share in (0.3, 0.7):
            parts = lift_after(parts, load, 0.0, 0.0, share * held, v)
        assert ours == pytest.approx(theirs, abs=2e-3)
        assert parts == pytest.approx(ours, abs=1e-12)


def test_a_valve_at_half_lift_has_four_times_its_least_resistance_and_a_shut_one_does_not_leak():
    v = holding_valve(VALVE)
    assert restriction(0.5, v) == pytest.approx((VALVE.check_resistance, 4.0 * VALVE.minimum_resistance))
    assert restriction(0.0, v).outward == math.inf
    assert restriction(0.0, holding_valve(None)) == (0.0, 0.0)


def test_a_boom_sinks_on_a_leaking_spool_and_not_behind_a_counterbalance_valve():
    """What leaks into the rod side presses the boom down at first, and is a pilot pressure, too."""
    leaking = dataclasses.replace(REAL.valve, leakage_conductance=2e-12)
    high = dataclasses.replace(VALVE, setting=24.0 * MPA, pilot_ratio=0.5)
    free, held = (
        Course(crane(valve, leaking, head_mass=500.0), np.zeros(20_000), pose=(0.0, 0.8, -0.9))
        for valve in (None, high)
    )
    assert math.degrees(free.angle[2000] - free.angle[-1]) > 0.3
    assert math.degrees(held.angle[2000] - held.angle[-1]) < 0.01
    assert np.all(held.flow_1 >= 0.0)
    assert np.all(held.flow_1[2000:] == 0.0)


def test_lowering_is_limited_to_what_the_pump_fills():
    """Without the valve the boom runs away from its pump, whose side is a vacuum then."""
    free, held = (Course(crane(valve, WIDE), held_voltage(-6.0)) for valve in (None, VALVE))
    lowering = slice(80, 300)
    assert free.pressure_2[lowering].min() < 0.0
    assert held.pressure_2[lowering].min() > 0.1 * MPA
    rates = [math.degrees(-run.rate[lowering].mean()) for run in (free, held)]
    assert rates[0] > 3.0 * rates[1] > 0.0
    p = plant_parameters(crane(VALVE, WIDE))
    lengths = [
        math.sqrt(link.a**2 + link.b**2 - 2.0 * link.a * link.b * math.cos(angle + link.offset))
        for link in [_Link(p.boom_linkage)]
        for angle in held.angle[[80, 299]]
    ]
    swept = p.boom.actuator.displacement_2 * (lengths[0] - lengths[1])
    filled = -np.trapezoid(held.flow_2[80:300], dx=5e-3)
    assert swept == pytest.approx(filled, rel=0.05)  # the rest is pressed


class _Link:
    """The triangle of a cylinder, by names of its own."""

    def __init__(self, linkage):
        self.a, self.b, self.offset = linkage[:3]


def test_a_rupture_valve_lets_the_boom_down_below_its_flow_and_shuts_above_it():
    below, above = (Course(crane(RUPTURE, WIDE), held_voltage(volts)) for volts in (-1.5, -3.0))
    assert -below.flow_1.min() < RUPTURE.closing_flow
    assert np.all(below.lift_one == 1.0)
    assert math.degrees(below.angle[40] - below.angle[299]) > 4.0
    shut = int(np.argmax(above.lift_one == 0.0))
    assert 0 < shut < 60
    assert np.all(above.lift_one[shut:] == 0.0)
    assert np.all(above.flow_1[shut:] == 0.0)
    assert math.degrees(np.ptp(above.angle[250:])) < 0.5
    assert abs(unaccounted(above.account)) < 5e-3 * float(above.account.engine)


def test_raising_opens_a_rupture_valve_again():
    volts = np.concatenate([held_voltage(-3.0), np.repeat(5.0, 400), held_voltage(-1.5, time=0.4)])
    run = Course(crane(RUPTURE, WIDE), volts)
    assert run.lift_one[390] == 0.0
    assert run.lift_one[-1] == 1.0
    assert run.rate[470:480].max() > 0.0


def test_a_pilot_check_valve_holds_and_is_opened_by_lowering():
    run = Course(crane(PILOT_CHECK), held_voltage(-4.0))
    assert np.all(run.lift_one[:40] == 0.0)
    assert run.lift_one[60:300].min() > 0.0
    assert math.degrees(run.angle[0] - run.angle[299]) > 5.0


@pytest.mark.parametrize(("position", "flow"), [(6.0, 1e-3), (0.0, 0.0)])
def test_a_pilot_line_ends_behind_the_compensator_or_in_the_tank_line(position, flow):
    """Both valves of a stick, far from the pump's 20 MPa; a shut spool leaves them the tank line."""
    machine = load_machine("forwarder")
    p, tank, load = plant_parameters(machine), 0.6 * MPA, 9.0 * MPA
    tight = p.valves[2].law._replace(leakage=0.0)
    p = p._replace(valves=(*p.valves[:2], p.valves[2]._replace(law=tight)))
    rest = equilibrium(POSE, p)
    stick = rest.plant.stick._replace(pressure_1=load, pressure_2=26.0 * MPA, flow_1=flow, flow_2=flow)
    plant = rest.plant._replace(supply=SupplyState(20.0 * MPA, 20.0 * MPA), stick=stick)
    spools, lifts = (*rest.spools[:2], Spool(position, 0.0)), Lifts(0.2, 0.0, 0.05)
    after = lifts_after(plant, (lifts, lifts, lifts), spools, tank, 1e-3, p)[2]
    hose, check = machine.line(2, 1).resistance, machine.stick.holding_1.check_resistance
    ahead = load + (hose + check) * flow**2 if flow else tank
    back = tank + edges(position, tight).tank_2 * flow**2 if flow else tank
    assert after.one == pytest.approx(lift_after(0.2, load, back, flow, 1e-3, p.stick.holding_1))
    assert after.two == pytest.approx(lift_after(0.0, 26.0 * MPA, ahead, -flow, 1e-3, p.stick.holding_2))
    assert after.two > 0.0


def test_a_boom_comes_down_as_one_whose_valve_stands_between_two_volumes():
    """The whole way within 2 %: `held_volumes` has the hose's oil before the valve."""
    valve = dataclasses.replace(REAL.valve, hysteresis=None, dead_time=None, spool_slew_limit=None)
    narrow = dataclasses.replace(VALVE, minimum_resistance=2e12, setting=14.0 * MPA)
    machine = dataclasses.replace(
        crane(narrow, dataclasses.replace(valve, spool_bandwidth=None)),
        oil=dataclasses.replace(REAL.oil, air=None),
        pump=IdealPump(REAL.pump.supply_pressure),
        port_valves=None,
    )
    times = np.arange(0.0, 0.4001, 5e-3)
    expected = HeldVolumes(machine).run_held(POSE, (0.0, -6.0, 0.0), times)
    boom, lift = expected[1:, :-1].reshape(-1, 3, 8)[:, 1], expected[1:, -1]
    ours = Course(machine, np.full(400, -6.0))
    assert lift[20:].max() > 0.1
    assert np.abs(ours.angle - boom[:, 0]).max() < 0.02 * np.ptp(boom[:, 0])
    assert np.abs(ours.pressure_1 - boom[:, CHAMBER_1]).max() < 0.05 * np.ptp(boom[:, CHAMBER_1])
    assert np.abs(ours.pressure_2 - boom[:, CHAMBER_2]).max() < 0.05 * np.ptp(boom[:, CHAMBER_2])


def test_interpreted_and_compiled_valves_are_the_same_to_the_last_bit():
    levels = np.random.default_rng(7).uniform(-9.0, 9.0, 6)
    swing = dataclasses.replace(REAL.swing, holding_1=RUPTURE, holding_2=PILOT_CHECK)
    machine = dataclasses.replace(REAL, swing=swing)
    p, table = (
        plant_parameters(machine),
        np.repeat(np.column_stack([levels, -levels, levels[::-1]]), 50, axis=0),
    )
    rows = []
    for record in (compiled_record(), state_recording.record):
        states, energies = np.zeros((60, len(STATE))), np.zeros((60, len(ENERGY)))
        record(equilibrium(POSE, p), table, 1e-3, p, states, energies)
        rows.append((states, energies))
    assert np.array_equal(rows[0][0], rows[1][0])
    assert np.array_equal(rows[0][1], rows[1][1])
    assert np.all(np.isfinite(rows[0][0]))
    assert np.ptp(rows[0][0][:, STATE.index("boom_lift_one")]) > 0.5


def test_oil_that_a_shutting_valve_stops_loses_no_more_than_it_has():
    """A valve that has shut on a flow stops it at the next step; until then its resistance is infinite."""
    p = plant_parameters(REAL)
    rest = equilibrium(POSE, p)
    moving = rest.plant._replace(boom=rest.plant.boom._replace(flow_1=-1e-4))
    assert power_flows(rest._replace(plant=moving), p).boom.holding == 0.0


def test_energy_closes_with_every_valve_at_work_on_a_slam():
    levels = np.random.default_rng(9).uniform(-10.0, 10.0, 60)
    run = Course(REAL, np.repeat(levels, 200))
    assert run.failed == 0
    assert abs(unaccounted(run.account)) < 2e-3 * float(run.account.engine)


@pytest.mark.parametrize(
    "valve", [VALVE, dataclasses.replace(VALVE, pilot_ratio=5.0, hysteresis=0.0, response_time=0.002)]
)
def test_the_fastest_valve_stays_stable_on_a_load_that_runs_ahead(valve):
    assert isinstance(valve, CounterbalanceValve)
    run = Course(crane(valve, WIDE), held_voltage(-8.0, time=3.0))
    assert run.failed == 0
    assert np.abs(run.pressure_1).max() < 30.0 * MPA
    assert np.abs(np.degrees(run.rate)).max() < 45.0
