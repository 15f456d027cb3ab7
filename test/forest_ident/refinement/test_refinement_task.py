"""What each record's fit seeks, what goes along with it, and by which channels: on two cranes."""

import dataclasses

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.measurements.session import Session
from forest_ident.refinement.refinement_task import (
    INERTIAS,
    is_parameter,
    simulations,
    stated_keys,
    task,
    tells_stated,
)

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")
LAW = tuple(
    f"valve.{part}{key}"
    for part, key in (
        ("", "deadband_voltage"),
        ("", "minimum_resistance"),
        ("backward.", "deadband_voltage"),
        ("backward.", "minimum_resistance"),
        ("", "port_2_area"),
        ("", "spool_bandwidth"),
    )
)
OWN_LAW = tuple(f"stick.{key}" for key in (*LAW, "valve.spool_damping"))
PUMP, OTHER_PUMP = (
    ("pump.supply_pressure", "pump.compensator_band"),
    ("pump.margin", "pump.response_time"),
)
MASSES = ("manipulator.head_mass", "manipulator.boom_mass")
LEAKAGE = ("swing.internal_leakage_resistance", "swing.external_leakage_resistance")


def line(regime):
    return f"hose.{regime}_resistance", "hose.inertance", "hose.capacitance"


def record(name, **facts):
    return Session(name, np.arange(3.0), np.zeros((3, 3)), {}, facts)


C180_TASKS = {
    "valve": ((*LAW, *PUMP), line("turbulent")),
    "spool_lag": (LAW[-1:], ()),
    "hose": (line("turbulent"), (*LAW, *PUMP)),
    "hose_laminar": (line("laminar"), (*LAW, *PUMP)),
    "gravity": (MASSES, (*PUMP, *LAW, "boom.damping", *line("turbulent"), "stick.damping")),
    "motor_external": (
        LEAKAGE[1:],
        ("swing.damping", LEAKAGE[0], *LAW, *line("laminar"), *PUMP, *MASSES),
    ),
    "motor_internal": (LEAKAGE, ("swing.damping", *line("laminar"), *MASSES)),
    "deadband_swing": (
        ("swing.valve.deadband_voltage", "swing.valve.backward.deadband_voltage"),
        (
            *(f"swing.valve.{key}" for key in ("minimum_resistance", "backward.minimum_resistance")),
            *("swing.valve.port_2_area", "swing.damping", *LEAKAGE, *PUMP, *MASSES),
        ),
    ),
    "deadband_boom": (
        ("boom.valve.deadband_voltage", "boom.valve.backward.deadband_voltage"),
        (
            *(f"boom.valve.{key}" for key in ("minimum_resistance", "backward.minimum_resistance")),
            *("boom.valve.port_2_area", "boom.damping", *PUMP, *MASSES),
        ),
    ),
    "damping_swing": (("swing.damping",), (*LAW, *line("laminar"), *LEAKAGE, *PUMP, *MASSES)),
    "damping_boom": (
        ("boom.damping",),
        ("stick.damping", *LAW, *line("turbulent"), *PUMP, *MASSES),
    ),
    "damping_stick": (
        ("stick.damping",),
        ("boom.damping", *LAW, *line("turbulent"), *PUMP, *MASSES),
    ),
}
LOADER_TASKS = {
    "valve_stick": ((*OWN_LAW, *OTHER_PUMP), (*line("turbulent"), "oil.air.share")),
    "gravity": (
        (*MASSES, "valve.leakage_conductance", "stick.valve.leakage_conductance"),
        (
            *OTHER_PUMP,
            *(*LAW, "valve.spool_damping", "boom.damping", *line("laminar")),
            *(*OWN_LAW, "stick.damping", "hose.turbulent_resistance"),
        ),
    ),
    "damping_stick": (
        ("stick.damping", "stick.friction.coulomb_force", "stick.friction.breakaway_force"),
        ("boom.damping", *OWN_LAW, *line("turbulent"), *OTHER_PUMP, *MASSES, "oil.air.share"),
    ),
}
FACTS = {"hose": {"hose_axis": 0.0, "laminar": 0.0}, "hose_laminar": {"hose_axis": 2.0, "laminar": 1.0}}


@pytest.mark.parametrize(
    ("machine", "name", "free", "carried"),
    [
        *((C180, name, *keys) for name, keys in C180_TASKS.items()),
        *((LOADER, name, *keys) for name, keys in LOADER_TASKS.items()),
    ],
)
def test_a_record_seeks_its_own_numbers_and_takes_the_others_along(machine, name, free, carried):
    found = task(machine, record(name, **FACTS.get(name, {})))
    assert found is not None
    assert (found.free, found.carried) == (free, carried)


def of_axis(name, *more):
    ports = (f"{name}_pressure_1_actuator", f"{name}_pressure_2_actuator")
    return (f"{name}_resolver", f"{name}_transducer", *ports, *more)


@pytest.mark.parametrize(
    ("name", "channels"),
    [
        (
            "valve",
            (
                *("swing_pressure_1_valve", "swing_pressure_2_valve"),
                *("swing_flow", "stick_flow", "supply_pressure", "swing_spool"),
            ),
        ),
        ("spool_lag", ("swing_spool",)),
        (
            "hose",
            (
                *("swing_pressure_1_valve", "swing_pressure_2_valve", "swing_pressure_1_actuator"),
                *("swing_flow", "stick_flow", "supply_pressure"),
            ),
        ),
        ("motor_external", of_axis("swing", "swing_flow", "supply_pressure", "case_drain")),
        ("motor_internal", of_axis("swing", "swing_flow", "case_drain")),
        ("damping_boom", of_axis("boom", "boom_flow", "supply_pressure")),
        ("deadband_stick", of_axis("stick", "stick_flow", "supply_pressure")),
        ("gravity", ("supply_pressure", *of_axis("boom"), *of_axis("stick"))),
    ],
)
def test_a_record_is_judged_by_the_channels_that_feel_what_it_seeks(name, channels):
    assert task(C180, record(name, **FACTS.get(name, {}))).channels == channels


def test_static_errors_go_along_on_the_crane_the_load_on_a_rig_and_the_tilt_where_it_creeps():
    def nuisances(name):
        return task(C180, record(name, **FACTS.get(name, {}))).nuisances

    offsets = ("boom.angle", "stick.angle", "oil.offset")
    assert nuisances("damping_swing") == nuisances("gravity") == nuisances("deadband_boom") == offsets
    assert nuisances("motor_internal") == (*offsets, "tilt", "swing.angle")
    assert (nuisances("valve"), nuisances("hose"), nuisances("spool_lag")) == (
        ("rig.load",),
        ("rig.load",),
        (),
    )
    names = (*offsets, "tilt", "swing.angle", *INERTIAS, "rig.load.valve", "start.boom_resolver.gravity")
    assert not any(map(is_parameter, names))
    assert is_parameter("boom.damping")


def test_a_record_that_is_only_checked_is_not_refined():
    assert task(C180, record("validation")) is None
    assert simulations(C180, record("validation")) == 0.0


def test_a_mass_that_the_crane_does_not_have_is_not_sought():
    bare = dataclasses.replace(C180.manipulator, head_mass=0.0)
    found = task(dataclasses.replace(C180, manipulator=bare), record("gravity"))
    assert found.free == ("manipulator.boom_mass",)
    assert (
        "manipulator.head_mass"
        not in task(dataclasses.replace(C180, manipulator=bare), record("damping_boom")).carried
    )


def test_simulations_are_those_of_derivatives_of_stated_numbers_and_of_a_search():
    assert simulations(C180, record("spool_lag")) == pytest.approx(1.1 * 1 + 8)
    assert simulations(C180, record("valve")) == pytest.approx(1.1 * (8 + 3 + 1) + 8)
    assert simulations(C180, record("gravity")) == pytest.approx(1.1 * (2 + 13 + 3 + 9) + 19 + 8)


def test_the_stated_numbers_that_a_record_feels_are_its_axis_and_both_links():
    swing, boom, both = (
        stated_keys(C180, record(name)) for name in ("damping_swing", "damping_boom", "gravity")
    )
    assert {"swing.motor_displacement", "manipulator.base_offset"} <= set(swing)
    assert not any(key.startswith(("boom.head", "stick.head")) for key in swing)
    assert "boom.head_area" in boom
    assert "stick.head_area" not in boom
    assert {"boom.head_area", "stick.head_area", "manipulator.stick_mass"} <= set(both)
    assert len(both) == len(set(both))
    assert set(INERTIAS) <= set(swing) & set(boom) & set(both)
    assert stated_keys(C180, record("valve")) == ()
    assert tells_stated(C180)
    assert not tells_stated(LOADER)
