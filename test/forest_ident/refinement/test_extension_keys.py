"""Which numbers beyond the thesis a record tells, and with which prior."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.parameter_estimate import EXCITATION, excitation_for
from forest_ident.measurements.session import Session
from forest_ident.refinement import extension_keys
from forest_ident.refinement.refinement_task import task
from forest_ident.refinement.result import UNTOLD, Result, unidentified


def test_a_plain_crane_has_none():
    plain = load_machine("c180_hoses")
    for kind in ("damping", "spool", "valve", "gravity"):
        assert extension_keys.told_by(plain, kind, "boom", "valve") == ()
        assert extension_keys.felt_by(plain, kind, ("swing", "boom", "stick"), "valve") == ()
    assert extension_keys.of_machine(plain) == ()


def test_each_record_tells_its_own_numbers_of_the_crane_as_built():
    built = load_machine("c180")
    for kind in ("spool", "valve"):  # a valve's record is fitted first, and would take play for a wrong law
        assert extension_keys.told_by(built, kind, "swing", "valve") == (
            *("valve.hysteresis", "valve.dead_time", "valve.spool_slew_limit"),
        )
    boom = extension_keys.told_by(built, "damping", "boom", "valve")
    assert boom == (
        *("boom.friction.coulomb_force", "boom.friction.breakaway_force"),
        *("boom.holding_1.setting", "boom.holding_1.pilot_ratio", "oil.air.share"),
    )
    assert all(map(extension_keys.is_extension, boom))
    assert extension_keys.told_by(built, "damping", "swing", "valve")[2:] == (
        *("swing.backlash.free_way", "oil.air.share"),
    )
    leaking = load_machine("loader")
    assert extension_keys.told_by(leaking, "gravity", "swing", "valve") == (
        *("valve.leakage_conductance", "stick.valve.leakage_conductance"),
    )
    assert not extension_keys.is_extension("boom.damping")


def test_what_a_record_feels_goes_along_though_another_tells_it():
    built = load_machine("c180")
    for name, felt in (
        ("hose", "oil.air.share"),
        ("deadband_stick", "stick.holding_2.pilot_ratio"),
        ("motor_external", "swing.friction.coulomb_torque"),
        ("deadband_swing", "swing.backlash.free_way"),
    ):
        facts = {"hose_axis": 0.0, "laminar": 0.0}
        work = task(built, Session(name, np.arange(2.0), np.zeros((2, 3)), {}, facts))
        assert work is not None
        assert felt in work.carried
        assert not set(work.carried) & set(work.free)
    leaking = load_machine("loader")
    assert "swing.valve.leakage_conductance" in extension_keys.felt_by(
        leaking, "motor", ("swing",), "swing.valve"
    )
    assert set(extension_keys.felt_by(built, "hose", (), "valve")) == {"oil.air.share"}


def test_a_dead_time_is_known_to_no_less_than_the_simulators_rounding():
    found = extension_keys.rounding({"valve.dead_time": 0.008, "valve.hysteresis": 0.4})
    assert set(found) == {"valve.dead_time"}
    assert 0.008 * found["valve.dead_time"] == pytest.approx(0.29e-3, rel=0.01)


def test_every_number_names_the_motion_that_tells_it():
    for key in (*extension_keys.NAMES, *UNTOLD):
        assert excitation_for(key) in EXCITATION.values()


def test_what_no_record_tells_is_said_with_the_motion_that_would():
    built = load_machine("c180")
    said = dict(unidentified(Result(built, built)))
    assert "turned round" in said["swing.backlash.free_way"]
    assert "taken as stated" in said["boom.elasticity.stiffness"]
    plain = load_machine("c180_hoses")
    left = dict(unidentified(Result(plain, plain)))
    assert not [key for key in left if "elasticity" in key or "friction" in key]
