"""The compiled loop is the interpreted one, to the last bit; what it does not know it refuses."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_compile import flat_layout
from forest_control.config import controller_settings
from forest_control.operator.levers import Levers
from forest_control.operator.operator_profile import Mode
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.hydraulics.valve_parameters import PolynomialCurve, TableCurve
from forest_description.machine import load_machine
from forest_description.sensors.sensor_kinds import InertialUnit
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import draw, noise_generator, sensor_suite
from forest_sim.simulation.load_schedule import Load, loaded
from forest_study.closed_loop import closed_loop, compiled_loop, loop_core, loop_kernel
from forest_study.closed_loop.closed_loop import Operator

C180 = load_machine("c180_hoses")
START = inverse_kinematics((5.5, 0.0, 1.0), C180.manipulator.links)
USUAL = controller_settings.Settings(), valve_driver_parameters.Settings()
ROWS = 240


def hand(seed=0, rows=ROWS):
    """Return levers that jump, with the deadman let go now and then, and pressed with centred levers."""
    rng = np.random.default_rng(seed)
    held = np.clip(rng.normal(0.0, 0.6, (rows // 40, 3)), -1.0, 1.0)
    enabled = (np.arange(rows) // 60 % 3 != 1) & (np.arange(rows) > 9)
    pressed = np.diff(enabled, prepend=False) & enabled
    return np.column_stack([np.repeat(held, 40, axis=0) * ~pressed[:, None], enabled])


def interpreted(table, machine, settings, drive, model, suite):
    def operator(time):
        *levers, enabled = table[round(time / PERIOD)].tolist()
        return Operator(Levers(*levers), enabled > 0.5)

    end = PERIOD * len(table)
    return closed_loop.run(machine, operator, end, START, settings, drive, model, suite)


def assert_same(settings, drive, machine=C180, model=C180, seed=0, table=None):
    suite = sensor_suite(machine, noise=True, seed=seed)
    table = hand(seed) if table is None else table
    fast = compiled_loop.run(machine, table, START, settings, drive, model, suite)
    python = interpreted(table, machine, settings, drive, model, suite)
    for name, a, b in zip(fast._fields, fast, python, strict=True):
        np.testing.assert_array_equal(a, b, err_msg=name)
    assert np.ptp(fast.tip, axis=0).max() > 0.01  # and it moved


@pytest.mark.parametrize("scheme", list(Scheme))
def test_every_scheme_is_the_interpreted_loop_to_the_last_bit(scheme):
    assert_same(
        controller_settings.Settings(scheme=scheme), valve_driver_parameters.Settings(adapt=scheme % 2 == 1)
    )


def test_so_is_position_mode_and_a_driver_with_all_it_has():
    drive = valve_driver_parameters.Settings(adapt=True, dither_amplitude=0.1)
    assert_same(controller_settings.Settings(mode=Mode.POSITION), drive, seed=1)


def test_so_is_another_machine_than_believed_with_slow_sensors_and_none():
    """Half the sampling rate, no pressures read, a bent valve on the boom, a tabulated one on the stick."""
    sensors = dataclasses.replace(C180.sensors, sample_rate=100.0, pressure=None)
    table = TableCurve(voltages=(3.0, 6.0, 10.0), resistances=(9e12, 1e12, 3e11))
    bent = PolynomialCurve(coefficients=(12.0, -2.0, 0.09))
    other = dataclasses.replace(
        C180,
        sensors=sensors,
        boom=dataclasses.replace(C180.boom, valve=dataclasses.replace(C180.valve, curve=bent)),
        stick=dataclasses.replace(C180.stick, valve=dataclasses.replace(C180.valve, curve=table)),
    )
    drive = valve_driver_parameters.Settings(adapt=True)
    assert_same(controller_settings.Settings(), drive, other, C180, seed=2)
    assert_same(controller_settings.Settings(), drive, C180, other, seed=3)


def test_so_is_a_crane_whose_valves_open_less_than_believed_and_are_asked_for_no_more():
    """The driver tells the controller what it has learnt."""
    curve = TableCurve(voltages=(3.0, 6.0, 10.0), resistances=(9e12, 1e12, 3e11))
    weak = {
        name: dataclasses.replace(drive, valve=dataclasses.replace(C180.valve, curve=curve))
        for name, drive in (("swing", C180.swing), ("stick", C180.stick))
    }
    table = np.tile([1.0, 0.0, 0.8, 1.0], (ROWS, 1))
    table[:20, :3] = 0.0
    settings = controller_settings.Settings(tip_speed=3.0)
    drive = valve_driver_parameters.Settings(adapt=True)
    assert_same(settings, drive, dataclasses.replace(C180, **weak), C180, seed=1, table=table)


def test_so_is_a_crane_whose_angles_are_by_inertial_units():
    unit = InertialUnit(1.0, 1.0, 5.0, 0.005, 0.002, 0.001, 0.01)
    sensors = dataclasses.replace(
        C180.sensors, inertial_unit=unit, joint_angles="inertial_unit", linear_transducer=None
    )
    crane = dataclasses.replace(C180, sensors=sensors)
    assert_same(*USUAL, machine=crane, model=crane, seed=2)


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_the_core_interpreted_is_the_core_compiled(substeps):
    suite, table = sensor_suite(C180, noise=True, seed=4), hand(4)[20:32]
    settings, drive = controller_settings.Settings(), valve_driver_parameters.Settings()
    fast = compiled_loop.run(C180, table, START, settings, drive, suite=suite, substeps=substeps)
    k = loop_kernel.knowledge(C180, C180, settings, drive, suite, substeps)
    loop, normals = (
        loop_kernel.begin(k, START, suite),
        compiled_loop.draws(suite, len(table)).ravel().tolist(),
    )
    for row, (*levers, enabled) in enumerate(table.tolist()):
        loop, happened = loop_core.period(loop, Levers(*levers), enabled > 0.5, True, k, normals, row)
        assert happened.command == tuple(fast.commands[row])
        assert happened.tip == tuple(fast.tip[row])
        assert happened.pressures == tuple(fast.pressures[row])


def test_a_run_in_longer_steps_is_another_one_that_ends_where_the_finest_does():
    found = {n: compiled_loop.prepared(C180, hand(6), START, *USUAL, substeps=n).run() for n in (2, 5, 20)}
    away = [np.abs(found[n].angles - found[20].angles).max() for n in (2, 5)]
    assert 0.0 < away[1] < away[0] < 3e-4


def test_runs_of_one_seed_share_their_noise_which_no_one_may_change():
    suite = sensor_suite(C180, noise=True, seed=5)
    drawn, generator = compiled_loop.draws(suite, 100), noise_generator(suite)
    assert drawn is compiled_loop.draws(suite, 100)
    assert not drawn.flags.writeable
    assert drawn[:3].tolist() == [draw(generator).normal for _ in range(3)]
    assert (compiled_loop.draws(suite._replace(seed=6), 100) != drawn).all()


def test_a_log_that_is_grasped_and_dropped_on_the_way_is_the_interpreted_loops():
    suite, table, plant = sensor_suite(C180, noise=True, seed=5), hand(5), plant_parameters(C180)
    held = loaded(plant, C180.manipulator, Load(900.0))
    moved = compiled_loop.prepared(C180, table, START, *USUAL, suite=suite).run({90: held, 170: plant})
    k = loop_kernel.knowledge(C180, C180, *USUAL, suite)
    loop = closed_loop.ClosedLoop(plant, k.control, k.drive, START, suite)
    for row, (*levers, enabled) in enumerate(table.tolist()):
        if row in (90, 170):
            loop.change_load(held if row == 90 else plant)
        happened = loop.period(Operator(Levers(*levers), enabled > 0.5))
        assert happened.angles == tuple(moved.angles[row]), row
        assert happened.pressures == tuple(moved.pressures[row]), row
    assert len(moved.tip) == len(table)


def test_all_machines_and_settings_share_one_shape():
    """Or a kernel made for one would misread another's numbers."""
    shapes = set()
    for name in ("c180_hoses", "c180_thesis", "loader"):
        machine = load_machine(name)
        k = loop_kernel.knowledge(
            machine,
            machine,
            controller_settings.Settings(),
            valve_driver_parameters.Settings(),
            sensor_suite(machine),
        )
        shapes.add(tuple(path for path, _ in flat_layout.leaves(k, "k")))
    assert len(shapes) == 1


def test_equal_seeds_repeat_and_others_do_not():
    suites = [sensor_suite(C180, noise=True, seed=seed) for seed in (1, 1, 2)]
    tips = [compiled_loop.run(C180, hand(), START, *USUAL, suite=suite).tip for suite in suites]
    assert [np.array_equal(a, b) for a, b in pairwise(tips)] == [True, False]


def test_faulty_sensors_are_refused():
    suite = sensor_suite(C180, faults=parse_faults("boom_resolver: absent from 2 s"))
    with pytest.raises(ValueError, match="faults are not compiled"):
        compiled_loop.run(C180, hand(), START, *USUAL, suite=suite)


def test_levers_without_a_deadman_are_refused():
    with pytest.raises(ValueError, match=r"shape \(240, 3\); allowed: a row of 4"):
        compiled_loop.run(C180, hand()[:, :3], START, *USUAL)


def test_a_session_in_pieces_is_the_session_at_once():
    """To the last bit, a log grasped on the way."""
    whole = compiled_loop.prepared(C180, hand(), START, *USUAL)
    plant = loaded(plant_parameters(C180), C180.manipulator, Load(200.0))
    session = compiled_loop.Session(whole)
    for end in (3, 100):
        session.advance(end)
    session.change_load(plant)
    session.advance(ROWS)
    np.testing.assert_array_equal(session.moved.tip, whole.run({100: plant}).tip)
    assert session.row == ROWS
