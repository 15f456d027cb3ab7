"""Claims about logs in a running machine's head: the schedule, its energy, and that runs repeat."""

import dataclasses
import re

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, RotatorAndGrapple
from forest_msgs_py.interfaces import topics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_suite import EXACT_SUITE
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.simulation.link_account import LinkBalance
from forest_sim.simulation.load_schedule import Load, LoadEvent, own_load, parse_loads
from forest_sim.simulation.open_loop import Run, whole
from forest_sim.simulation.sensor_log import SensorLog
from forest_sim.simulation.simulated_machine import SimulatedMachine
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver.state_recording import restore

C180 = load_machine("c180_hoses")
HEAD = RotatorAndGrapple(100.0, 0.25, 0.5, 0.55, 90.0, 0.8, 400.0)
HANGING = dataclasses.replace(C180, manipulator=dataclasses.replace(C180.manipulator, pendulum=HEAD))
START = (0.2, 0.5, -1.4)
TEXT = "500 kg from 0.5 s; 0 kg from 1.2 s; 300 kg, 6 m from 1.6 s; 700 kg, 5 m from 2.1 s; 0 kg from 2.7 s"


def wild(times):
    """Random voltages, another every 0.2 s."""
    levels = np.random.default_rng(7).uniform(-7.0, 7.0, (40, 3))
    return levels[np.floor(np.asarray(times) / 0.2 + 1e-9).astype(int)]


def test_a_schedule_tells_masses_lengths_and_times():
    assert parse_loads("") == ()
    assert parse_loads("500 kg from 2 s; 0 kg from 6.5 s\n80KG, 2.5m from 7 s;") == (
        LoadEvent(2.0, Load(500.0, 4.0)),
        LoadEvent(6.5, Load(0.0, 4.0)),
        LoadEvent(7.0, Load(80.0, 2.5)),
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("half a ton from 2 s", "'half a ton from 2 s' is no load; allowed: MASS kg from TIME s"),
        ("500 lb from 2 s", "'500 lb from 2 s' is no load; allowed"),
        ("500 kg at 2 s", "is no load; allowed"),
        ("-5 kg from 2 s", "'-5 kg from 2 s': -5 kg; allowed: 0 .. 10000 kg"),
        ("5e6 kg from 2 s", "5e6 kg; allowed: 0 .. 10000 kg"),
        ("5..0 kg from 2 s", "5..0 kg; allowed: 0 .. 10000 kg"),
        ("500 kg, 90 m from 2 s", "90 m; allowed: 0 .. 30 m"),
        ("500 kg from -1 s", "-1 s; allowed: 0 .. 604800 s"),
        ("5 kg from 3 s; 0 kg from 3 s", "0 kg from 3 s comes after 3 s; allowed: times that rise"),
    ],
)
def test_a_schedule_that_cannot_be_is_answered_with_what_is_allowed(text, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        parse_loads(text)


@pytest.mark.parametrize("machine", [C180, HANGING], ids=["fixed", "hanging"])
def test_no_energy_is_lost_or_made_where_logs_are_grasped_and_dropped_in_wild_motion(machine):
    run = whole(machine, Voltages("wild", wild, 4.0), START, Run(4.0, 1000.0), parse_loads(TEXT))
    balance = LinkBalance(machine, (0.0, 0.0, 0.0))
    balance.add(run._replace(**{name: column[:1] for name, column in run._asdict().items()}))
    balance.add(run._replace(**{name: column[1:] for name, column in run._asdict().items()}))
    links = balance.result()
    first, last = restore(run.states[0]), restore(run.states[-1])
    oil = with_stored_energy(account(run.energies.sum(axis=0)), first, last, plant_parameters(machine))
    assert links.joining > 20.0  # J
    assert (links.sway > 20.0) == (machine is HANGING)
    assert abs(links.carried_off) > 1e3
    assert abs(unaccounted(oil)) < 0.005 * oil.engine
    assert abs(links.unaccounted) < 0.005 * oil.engine
    assert abs(links.unaccounted) < 0.5 * links.joining  # it would be missed
    assert np.flatnonzero(run.load_change[:, 0]).tolist() == [500, 1600, 2100]
    assert np.flatnonzero(run.load_change[:, 1]).tolist() == [500, 1200, 1600, 2100, 2700]


def test_a_machine_under_way_changes_its_load_as_the_open_loop_does_and_repeats_to_the_last_bit():
    dry = dataclasses.replace(HANGING, oil=None)
    loads = parse_loads(TEXT)
    run = whole(dry, Voltages("wild", wild, 3.0), START, Run(3.0), loads)
    again = whole(dry, Voltages("wild", wild, 3.0), START, Run(3.0), loads)
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(run, again, strict=True))
    machine = SimulatedMachine(dry, START, EXACT_SUITE, 0.005, loads=loads)
    for row, load in enumerate(run.load[1:], start=1):
        volts = wild(run.time[row - 1])
        report = machine.step(tuple(volts.tolist()))
        assert tuple(machine.load) == tuple(load)
        assert report.joints.position == tuple(run.states[row, [0, 6, 12]])


def test_the_bags_topic_tells_the_log_and_a_log_in_the_machines_file_is_there_from_the_start():
    log = Log(250.0, 0.2, 0.0, 3.0)
    carrying = dataclasses.replace(C180, manipulator=dataclasses.replace(C180.manipulator, log=log))
    assert own_load(carrying.manipulator) == Load(250.0, 3.0)
    run = whole(carrying, Voltages("wild", wild, 0.2), START, Run(0.2), parse_loads("0 kg from 0.1 s"))
    told = SensorLog(carrying, 200.0).observe(run)[topics.GROUND_TRUTH_LOAD]
    assert told[:21].tolist() == [[250.0, 3.0]] * 21
    assert told[21:, 0].tolist() == [0.0] * 20
