"""What a record's fit simulates for given numbers, and which readings count."""

import dataclasses

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.experiments import rigs
from forest_ident.measurements.parameter_path import value_of
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error.fit_problem import Channel
from forest_ident.output_error.prediction import Offsets
from forest_ident.refinement import refinement, result
from forest_ident.refinement.refinement_task import Task
from forest_ident.refinement.result import Result

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")


def record(name, readings=None, facts=None):
    return Session(name, np.arange(4) * 0.005, np.zeros((4, 3)), readings or {}, facts or {})


def simulated(monkeypatch, machine, session, values):
    """What the simulator is asked for."""
    asked = []
    monkeypatch.setattr(refinement, "predict", lambda *arguments: asked.append(arguments) or {})
    refinement._predicted(machine, session, values, 2e-3)
    ((model, told, offsets, start, step),) = asked
    assert (told, step) == (session, 2e-3)
    return model, offsets, start


def test_parameters_factors_offsets_tilt_and_start_go_where_they_belong(monkeypatch):
    session = record("motor_internal", {"platform_roll": np.array([0.08, 0.12, 0.08, 0.12])})
    values = {
        "boom.damping": 2e5,
        "boom.inertia": 1.1,
        "tilt": 0.02,
        "swing.angle": 1e-3,
        "boom.angle": 2e-3,
        "stick.angle": 3e-3,
        "oil.offset": 0.5,
        "start.boom_resolver.motor_internal": 4e-3,
        "start.swing_pressure_1_actuator.motor_internal": 5e3,
    }
    model, offsets, start = simulated(monkeypatch, C180, session, values)
    assert model.boom.damping == 2e5
    for moment in ("xx", "yy", "zz", "xy"):
        for link, factor in (("boom", 1.1), ("stick", 1.0)):
            name = f"{link}_{moment}"
            assert getattr(model.manipulator, name) == pytest.approx(factor * getattr(C180.manipulator, name))
    assert model.manipulator.platform_tilt == pytest.approx(0.1 + 0.02)
    assert offsets == Offsets(1e-3, 2e-3, 3e-3, 0.5)
    assert start == {"boom_resolver": 4e-3, "swing_pressure_1_actuator": 5e3}
    plain, offsets, start = simulated(monkeypatch, C180, record("damping_boom"), {"boom.damping": 2e5})
    assert plain == dataclasses.replace(C180, boom=dataclasses.replace(C180.boom, damping=2e5))
    assert (offsets, start) == (Offsets(), {})


def test_a_benchs_load_counts_on_its_own_record(monkeypatch):
    session = record("valve")
    loads = [
        value_of(simulated(monkeypatch, C180, session, {f"rig.load.{name}": 3e9})[0], rigs.LOAD_KEY)
        for name in ("valve", "hose")
    ]
    assert loads[0] == pytest.approx(3e9 * rigs.DISPLACEMENT**2)
    assert loads[1] != pytest.approx(loads[0])


def test_a_machine_stands_tilted_as_read_as_told_or_as_its_file_says():
    def tilt(session):
        return refinement.prepared(C180, session).manipulator.platform_tilt

    assert tilt(record("motor_internal", {"platform_roll": np.full(4, 0.09)})) == pytest.approx(0.09)
    assert tilt(record("motor_internal", facts={"platform_tilt": 0.07})) == 0.07
    assert tilt(record("motor_internal")) == C180.manipulator.platform_tilt
    assert refinement.prepared(C180, record("motor_external", {"platform_roll": np.full(4, 0.09)})) is C180
    assert refinement.prepared(C180, record("valve")) != C180


def test_a_record_without_a_channel_that_moves_is_refused():
    work = Task((), (), ("boom_resolver", "boom_flow"))
    still = record("damping_boom", {"boom_resolver": np.zeros(4)})
    sentence = "no sensor reads all the time and moves; it takes one of boom_resolver, boom_flow"
    with pytest.raises(SessionError, match=f"damping_boom: {sentence}"):
        refinement._channels(C180, still, work)
    moving = record("damping_boom", {"boom_resolver": np.arange(4.0)})
    assert [c.name for c in refinement._channels(C180, moving, work)] == ["boom_resolver"]


def test_on_a_rig_the_meters_are_the_benchs():
    bare = dataclasses.replace(C180, sensors=dataclasses.replace(C180.sensors, flow_meter=None))
    readings = {"swing_flow": np.arange(4.0)}
    (bench,) = refinement._channels(bare, record("valve", readings), Task((), (), ("swing_flow",)))
    (crane,) = refinement._channels(bare, record("damping_swing", readings), Task((), (), ("swing_flow",)))
    assert bench.floor == rigs.meters(bare).flow_meter.lowest > 0.0
    assert crane.floor == 0.0


def test_on_a_rig_a_valves_readings_count_once_they_have_settled_and_above_the_highest_floor(monkeypatch):
    asked = []
    monkeypatch.setattr(refinement.sample_mask, "fresh", lambda columns: columns)
    monkeypatch.setattr(refinement.sample_mask, "while_open", lambda *rest: asked.append(rest[2:]) or {})
    channels = [Channel("swing_flow", 1.0, floor=3e-5), Channel("stick_flow", 1.0, floor=5e-5)]
    readings = {"swing_flow": np.arange(4.0), "stick_flow": np.arange(4.0)}
    for name in ("valve_swing", "hose", "spool_lag"):
        refinement._measured(record(name, readings), channels)
    refinement._measured(record("valve"), [])
    assert asked == [(0.25, 5e-5), (0.0, 5e-5), (0.0, 5e-5), (0.25, 0.0)]


def estimate(key, value=1.0, **more):
    return Estimate(key, value, 0.1, "1", 1.0, "test", **more)


def test_an_estimate_stands_beside_its_own_number_that_of_both_directions_or_of_all_axes():
    for key, machine, value in (
        ("boom.damping", C180, C180.boom.damping),
        ("valve.backward.deadband_voltage", C180, C180.valve.deadband_voltage),
        ("boom.valve.deadband_voltage", C180, C180.valve.deadband_voltage),
        ("boom.valve.backward.minimum_resistance", C180, C180.valve.minimum_resistance),
        ("boom.friction.coulomb_force", C180, None),
        ("boom.friction.coulomb_force", LOADER, LOADER.boom.friction.coulomb_force),
    ):
        assert result.value_in(machine, key) == value, key


def test_tables_are_in_the_files_order_and_of_inertias_the_start_is_one():
    keys = ("stick.damping", "pump.supply_pressure", "valve.deadband_voltage")
    found = Result(C180, C180, {key: estimate(key) for key in keys})
    order = [e.key for e, _ in result.table(found)]
    assert set(order) == set(keys)
    assert order == sorted(order, key=[*result.schema.parameters(result.Machine)].index)
    found.told = {key: estimate(key) for key in ("boom.inertia", "manipulator.stick_mass")}
    assert [start for _, start in result.told_table(found)] == [1.0, C180.manipulator.stick_mass]


def test_what_a_linear_estimator_or_a_stated_number_tells_is_not_missing():
    found = Result(C180, C180)
    missing = dict(result.unidentified(found))
    assert {"pump.supply_pressure", "valve.deadband_voltage", "boom.damping", "hose.inertance"} <= set(
        missing
    )
    assert {"hose.turbulent_resistance", "hose.laminar_resistance", *result.LEAKAGE} <= set(missing)
    found.linear = [estimate("boom.damping")]
    found.told = {"manipulator.stick_mass": estimate("manipulator.stick_mass")}
    found.estimates = {"hose.inertance": estimate("hose.inertance")}
    left = dict(result.unidentified(found))
    assert missing.keys() - left.keys() == {"boom.damping", "manipulator.stick_mass", "hose.inertance"}
