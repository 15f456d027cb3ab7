"""Which numbers beyond the thesis a record tells, and with which prior."""

import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.parameter_estimate import EXCITATION
from forest_ident.refinement import extension_keys


def test_a_plain_crane_has_none():
    plain = load_machine("c180_hoses")
    for kind in ("damping", "spool", "valve"):
        assert extension_keys.told_by(plain, kind, "boom", "valve") == ()


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
    assert not extension_keys.is_extension("boom.damping")


def test_a_dead_time_is_known_to_no_less_than_the_simulators_rounding():
    found = extension_keys.rounding({"valve.dead_time": 0.008, "valve.hysteresis": 0.4})
    assert set(found) == {"valve.dead_time"}
    assert 0.008 * found["valve.dead_time"] == pytest.approx(0.29e-3, rel=0.01)


def test_every_number_names_the_motion_that_tells_it():
    assert {name.rpartition(".")[2] for name in extension_keys.NAMES} <= set(EXCITATION)
