"""What each record gives by the thesis' linear estimators, and what it is refused for."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_description.mechanics.load import Log
from forest_ident.estimators import gravity, hose_estimators, motor_leakage
from forest_ident.estimators.least_squares import LinearFit
from forest_ident.measurements.session import Session, SessionError
from forest_ident.refinement import linear_estimates
from forest_ident.refinement.linear_estimates import estimates

C180 = load_machine("c180_hoses")


def with_facts(session, **facts):
    return dataclasses.replace(session, metadata={**session.metadata, **facts})


def refused(machine, session, sentence):
    with pytest.raises(SessionError, match=sentence):
        estimates(machine, session)


def test_a_valves_record_gives_both_directions_and_the_second_port(unknown_machine, sessions):
    found = estimates(C180, sessions("valve"))
    assert [(e.key, e.unit, e.initial) for e in found] == [
        ("valve.deadband_voltage", "V", True),
        ("valve.minimum_resistance", "Pa*s2/m6", True),
        ("valve.backward.deadband_voltage", "V", True),
        ("valve.backward.minimum_resistance", "Pa*s2/m6", True),
        ("valve.port_2_area", "1", True),
    ]
    assert len({(e.method, e.condition) for e in found}) == 1
    assert found[0].value == pytest.approx(unknown_machine.valve.deadband_voltage, abs=0.005)
    assert all(0.0 < e.standard_error < 0.02 * e.value for e in found)
    refused(
        C180, sessions("valve").part(0, 1500), r"valve: the record holds \d steady .* takes 4 each or more"
    )


def test_a_hoses_record_gives_its_resistance_and_the_rest_by_groups_and_in_phase(unknown_machine, sessions):
    session = sessions("hose")
    found = estimates(C180, session)
    assert [(e.key, e.initial) for e in found] == [
        ("hose.turbulent_resistance", True),
        ("hose.inertance", False),
        ("hose.inertance", True),
        ("hose.capacitance", False),
        ("hose.capacitance", True),
    ]
    resistance, of_groups, inertance, _, capacitance = found
    for e in (resistance, inertance, capacitance):
        assert e.value == pytest.approx(getattr(unknown_machine.hose, e.key[5:]), rel=0.05)
        assert 0.0 < e.standard_error < 0.05 * e.value
        assert math.isfinite(e.condition)
    means = hose_estimators.four_group_means(session, resistance.value, False)[0]
    assert of_groups.value == pytest.approx(np.mean(means))
    assert of_groups.standard_error == pytest.approx(np.std(means, ddof=1) / 2.0)
    assert math.isnan(of_groups.condition)


def test_a_hoses_record_of_other_facts_is_refused(sessions):
    session, length = sessions("hose"), C180.hose.length
    facts = {key: value for key, value in session.metadata.items() if key != "laminar"}
    refused(C180, dataclasses.replace(session, metadata=facts), "no fact laminar; it takes hose_axis")
    assert len(estimates(C180, with_facts(session, hose_length=1.0009 * length))) == 5
    refused(C180, with_facts(session, hose_length=1.0011 * length), "holds a piece of .* m of hose.length")
    refused(
        C180,
        with_facts(session, laminar=1.0),
        "a drop that goes with its square, as the turbulent .* does; it takes one that goes with the flow",
    )
    refused(C180, session.part(0, 600), r"hose: the record holds \d steady flows; it takes 4 or more")


def test_a_motors_records_give_leakages_as_resistances(unknown_machine, sessions):
    external = sessions("motor_external")
    (outside,) = estimates(unknown_machine, external)
    conductance, error = motor_leakage.external(unknown_machine, external).first
    assert (outside.key, outside.method) == ("swing.external_leakage_resistance", "case drain (4.8)")
    assert outside.value == pytest.approx(1.0 / conductance)
    assert outside.standard_error == pytest.approx(error / conductance**2)
    (inside,) = estimates(unknown_machine, sessions("motor_internal"))
    assert inside.key == "swing.internal_leakage_resistance"
    assert inside.value == pytest.approx(unknown_machine.swing.internal_leakage_resistance, rel=0.02)
    refused(C180, external.part(0, 4000), "holds 20 s; it takes 20 s or more")
    assert estimates(C180, external.part(0, 4001))
    blind = {name: column for name, column in external.readings.items() if name != "case_drain"}
    dry = dataclasses.replace(external, readings=blind, metadata={})
    refused(C180, dry, "no flow of the case drain; it takes its meter, or the fact case_drain_volume")
    assert estimates(C180, with_facts(dry, case_drain_volume=1e-3))[0].value > 0.0


@pytest.mark.parametrize("conductance", [0.0, -1e-12])
def test_what_leaks_the_wrong_way_has_no_resistance(conductance):
    fit = LinearFit(np.array([conductance]), np.array([1e-13]), 3.0, np.zeros(2), np.eye(1))
    e = linear_estimates._inverse("swing.external_leakage_resistance", fit, "any")
    assert (math.isnan(e.value), math.isnan(e.standard_error), e.condition) == (True, True, math.inf)
    assert not e.usable


def test_an_axis_that_hardly_moved_tells_no_damping(sessions):
    session = sessions("damping_swing")
    (found,) = estimates(C180, session)
    assert (found.key, found.method) == ("swing.damping", "least squares (4.11)")

    def turned_by(way):
        angle = session.column("swing_resolver")
        scaled = angle * way / np.ptp(angle)
        return dataclasses.replace(session, readings={**session.readings, "swing_resolver": scaled})

    assert estimates(C180, turned_by(0.051))
    refused(C180, turned_by(0.049), "damping_swing: the record holds a motion over 0.049 rad; it takes more")


def test_two_masses_take_three_rests_and_no_log(monkeypatch):
    session = Session("gravity", np.arange(10) * 0.005, np.zeros((10, 3)), {})
    asked = []

    def masses(_machine, _session, names):
        asked.append(names)
        numbers = np.array([[710.0, 640.0], [7.0, 6.0]])[:, : len(names)]
        return LinearFit(*numbers, 12.0, np.zeros(6), np.eye(2))

    monkeypatch.setattr(gravity, "masses", masses)
    monkeypatch.setattr(gravity, "poses", lambda *_: (np.zeros((2, 3)), np.zeros((2, 2))))
    refused(C180, session, "gravity: the record holds 2 poses at rest; it takes 3 or more")
    monkeypatch.setattr(gravity, "poses", lambda *_: (np.zeros((3, 3)), np.zeros((3, 2))))
    found = estimates(C180, session)
    assert [(e.key, e.value, e.standard_error, e.condition, e.unit) for e in found] == [
        ("manipulator.head_mass", 710.0, 7.0, 12.0, "kg"),
        ("manipulator.boom_mass", 640.0, 6.0, 12.0, "kg"),
    ]
    log = dataclasses.replace(C180.manipulator, log=Log(300.0, 4.0, 0.15))
    assert estimates(dataclasses.replace(C180, manipulator=log), session) == []
    bare = dataclasses.replace(C180.manipulator, head_mass=0.0)
    estimates(dataclasses.replace(C180, manipulator=bare), session)
    assert asked == [("head_mass", "boom_mass"), ("boom_mass",)]  # of a mass of zero there is nothing
    assert estimates(C180, dataclasses.replace(session, name="validation")) == []


def test_exact_meters_have_neither_floor_nor_end(sessions):
    meter = C180.sensors.flow_meter
    noisy, exact = sessions("valve"), with_facts(sessions("valve"), exact_sensors=1.0)
    assert (linear_estimates.floor(C180, noisy), linear_estimates.highest(C180, noisy)) == (
        meter.lowest,
        meter.highest,
    )
    assert (linear_estimates.floor(C180, exact), linear_estimates.highest(C180, exact)) == (0.0, math.inf)
    assert linear_estimates.floor(C180) == meter.lowest
